// SPDX-License-Identifier: Apache-2.0
// page_photos.h - a session's photographs as a page compares its drawings with them, and what else a page is told.
#ifndef SHEEN_CLI_PAGE_PHOTOS_H
#define SHEEN_CLI_PAGE_PHOTOS_H

#include "cli/stages.h"

enum { SHEEN_PAGE_MAX_PHOTOS = 64 };

// The input frames with poses, at most SHEEN_PAGE_MAX_PHOTOS of them, evenly chosen.
typedef struct sheen_page_photos {
    sheen_poses poses;
    size_t count, i_pose[SHEEN_PAGE_MAX_PHOTOS];
} sheen_page_photos;

sheen_status sheen_page_photos_open(sheen_page_photos *out, const sheen_session *s, size_t most,
                                    sheen_err *err);
void sheen_page_photos_close(sheen_page_photos *p);

// Linear light as a JPEG, for a page. The caller frees it.
sheen_status sheen_page_jpeg(uint8_t **jpeg, size_t *jpeg_bytes, const sheen_image *lin, sheen_err *err);

// Photograph i straightened to a pinhole of the page's field of view, at most width_px wide, as JPEG. The caller frees it.
sheen_status sheen_page_photo(uint8_t **jpeg, size_t *jpeg_bytes, const sheen_page_photos *p, size_t i,
                              const sheen_session *s, const sheen_camera *cam, int width_px, sheen_err *err);

// The page's "more" (docs/viewer.md): first view, and the photographs with their poses. Where `inside` they are in it as
// data, width_px wide; else it names them "photo/0", ... and the page asks its server, also for "state". The caller frees
// *json. ENOMEM and what reading photographs fails with.
sheen_status sheen_page_more(char **json, const sheen_page_photos *p, const sheen_session *s,
                             const sheen_cli_view *v, const double look_deg[2], bool inside, int width_px,
                             sheen_err *err);

#endif
