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

// The model in two parts. The bytes are owned; release frees them.
typedef struct sheen_page {
    uint8_t *geometry; // deflated: numbers, mesh, lights, seen texels
    uint8_t *texture;  // WebP, the atlas of render/texture.h in sRGB
    size_t geometry_bytes, texture_bytes;
} sheen_page;

void sheen_page_release(sheen_page *page);

// Positions in 16 bits of the mesh's box, normals in 2 x 16 bits, lights' directions in 3 x 16 bits; the texture as
// it is (resample it first) in 8 bits, clipped to 0..1. EARG: nothing to pack, too much for a page, or a number that
// is not finite; ENOMEM.
sheen_status sheen_page_pack(sheen_page *out, const sheen_model *model, const sheen_page_view *view,
                             sheen_err *err);
// What a page shows, as a model that sheen_draw draws (vertices in the order of their first use). method and
// nodes are not part of a page and stay empty. view may be NULL. Trusts nothing. EFORMAT, ENOMEM.
sheen_status sheen_page_unpack(sheen_model *out, sheen_page_view *view, const sheen_page *page,
                               sheen_err *err);

// The finished page: `html` (the viewer, NUL-terminated, which holds the marks @SHEEN_TITLE@, @SHEEN_GEOMETRY@ and
// @SHEEN_TEXTURE@ once each, in this order) with the parts in base64 and the title escaped. The caller frees *text.
// EARG: a mark is missing; ENOMEM.
sheen_status sheen_page_html(char **text, size_t *size_bytes, const sheen_page *page, const char *html,
                             const char *title, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
