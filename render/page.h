// SPDX-License-Identifier: Apache-2.0
// page.h - a model as one web page: packed small, and put into the viewer. docs/viewer.md specifies the format.
#ifndef SHEEN_RENDER_PAGE_H
#define SHEEN_RENDER_PAGE_H

#include <stddef.h>
#include <stdint.h>

#include "render/model.h"

#ifdef __cplusplus
extern "C" {
#endif

// What a page needs beside the model to show it as `sheen render` does.
typedef struct sheen_page_view {
    double rt_board_obj[6];
    double focal_per_width; // focal length over the picture's width
} sheen_page_view;

// The model in three parts. The bytes are owned; release frees them.
typedef struct sheen_page {
    uint8_t *geometry; // deflated: numbers, lights, mesh, seen texels
    uint8_t *texture;  // AVIF, the atlas of render/texture.h in sRGB
    uint8_t *board;    // AVIF, what is mirrored of the plane, in sRGB over its brightest light; or NULL
    size_t geometry_bytes, texture_bytes, board_bytes;
} sheen_page;

typedef struct sheen_page_options {
    int quantizer; // of the texture, SHEEN_AVIF_FINEST to SHEEN_AVIF_COARSEST
    int n_threads; // 0: one a processor
} sheen_page_options;

// What the viewer is told besides the model.
typedef struct sheen_page_words {
    const char *title;
    const char
        *sources; // of pictures and connections, for the Content-Security-Policy; "" for a page of its own
    const char *more_json; // an object: "photographs" and what a server adds; "{}"
} sheen_page_words;

void sheen_page_release(sheen_page *page);

// Positions in 16 bits of the mesh's box, normals in 2 x 16 bits, the normal map to an eighth of sigma; the texture as it is (resample it first) in 8 bits,
// clipped to 0..1, and then coded as finely as the quantizer says. Numbers and lights stay as they are. EARG: nothing
// to pack, too much for a page, or a number that is not finite; ENOMEM.
sheen_status sheen_page_pack(sheen_page *out, const sheen_model *model, const sheen_page_view *view,
                             const sheen_page_options *options, sheen_err *err);
// What a page shows, as a model that sheen_draw draws (vertices in the order of their first use). view may be NULL.
// Trusts nothing. EFORMAT, ENOMEM.
sheen_status sheen_page_unpack(sheen_model *out, sheen_page_view *view, const sheen_page *page,
                               sheen_err *err);

// RFC 4648: 4 characters for each 3 bytes begun. Returns the end of what was written; no NUL.
char *sheen_put_base64(char *to, const uint8_t *data, size_t size_bytes);
// The finished page: `html` (the viewer, NUL-terminated, which holds the marks @SHEEN_SOURCES@, @SHEEN_TITLE@,
// @SHEEN_MORE@, @SHEEN_GEOMETRY@, @SHEEN_TEXTURE@ and @SHEEN_BOARD@ once each, in this order) with the parts in base64
// and the words escaped for where they stand. The caller frees *text. EARG: a mark is missing; ENOMEM.
sheen_status sheen_page_html(char **text, size_t *size_bytes, const sheen_page *page, const char *html,
                             const sheen_page_words *words, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
