// SPDX-License-Identifier: Apache-2.0
// white.c - paper beside the tags' corners: found by the tags, looked at in each frame before it is recorded.
//
// A tag stands in the middle of a white square whose side is at least a quarter longer than the tag's: between the two,
// on the line from the tag's middle through its corner, there is bare paper.
#include "cli/white.h"

#include <math.h>
#include <stdlib.h>

#include "cli/frame_tags.h"

enum { MAX_PATCHES = 1024 };

sheen_status sheen_cli_white_init(sheen_cli_white *w, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    *w = (sheen_cli_white){0};
    if (!sheen_session_has(s, SHEEN_SESSION_BOARD))
        return SHEEN_OK;
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_BOARD, err);
    if (!st)
        st = sheen_board_set_load(&w->boards, path, err);
    if (!st)
        st = sheen_tag_detector_new(&w->detector, w->boards.boards[0].family, err);
    if (st)
        sheen_cli_white_release(w);
    return st;
}

void sheen_cli_white_release(sheen_cli_white *w)
{
    sheen_tag_detector_free(&w->detector);
    sheen_board_set_release(&w->boards);
    *w = (sheen_cli_white){0};
}

static float sample(const sheen_raster *r, int x, int y, int c)
{
    const size_t px = (size_t)y * (size_t)r->width_px + (size_t)x;
    const size_t at = px * (size_t)r->n_channels + (size_t)(r->n_channels >= 3 ? c : 0);
    if (r->bits == 8)
        return (float)((const uint8_t *)r->data)[at] / 255;
    return r->bits == 16 ? (float)((const uint16_t *)r->data)[at] / 65535 : ((const float *)r->data)[at];
}

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

bool sheen_cli_white_measure(float rgb[3], const sheen_raster *r, sheen_transfer transfer,
                             const sheen_tag_seen *tags, size_t n_tags)
{
    static const double beyond = 1.2; // of the way from the middle to the corner
    float patches[3][MAX_PATCHES];
    size_t n = 0;
    for (size_t i = 0; i < n_tags; i++)
        for (int k = 0; k < 4 && n < MAX_PATCHES; k++) {
            double q_px[2];
            for (int j = 0; j < 2; j++) {
                const double middle = 0.25 * (tags[i].q_px[0][j] + tags[i].q_px[1][j] + tags[i].q_px[2][j] +
                                              tags[i].q_px[3][j]);
                q_px[j] = floor(middle + beyond * (tags[i].q_px[k][j] - middle) + 0.5);
            }
            if (!(q_px[0] >= 0 && q_px[1] >= 0 && q_px[0] < r->width_px && q_px[1] < r->height_px))
                continue;
            for (int c = 0; c < 3; c++)
                patches[c][n] = sheen_transfer_decode(transfer, sample(r, (int)q_px[0], (int)q_px[1], c));
            n++;
        }
    for (int c = 0; n && c < 3; c++) {
        qsort(patches[c], n, sizeof patches[c][0], compare);
        rgb[c] = patches[c][n / 2];
    }
    return n > 0;
}

sheen_status sheen_cli_white_check(void *self, const sheen_frame *frame, sheen_err *err)
{
    sheen_cli_white *w = self;
    sheen_cli_frame_tags t;
    float rgb[3];
    if (!w->detector)
        return SHEEN_OK;
    sheen_status s = sheen_cli_frame_tags_find(&t, frame, w->detector, &w->boards, err);
    if (s)
        return s;
    if (sheen_cli_white_measure(rgb, &t.raster, frame->info.transfer, t.tags, t.n_tags)) {
        w->n_seen++;
        s = sheen_drift_check(&w->drift, rgb, err);
    } else
        w->n_unseen++;
    sheen_cli_frame_tags_release(&t);
    return s;
}
