// SPDX-License-Identifier: Apache-2.0
// frame_tags.c - develops a frame and has the board's tags found in it.
#include "cli/frame_tags.h"

#include <stdlib.h>

void sheen_cli_frame_tags_release(sheen_cli_frame_tags *t)
{
    free(t->tags);
    free(t->grey);
    sheen_raster_release(&t->raster);
    *t = (sheen_cli_frame_tags){0};
}

sheen_status sheen_cli_frame_tags_find(sheen_cli_frame_tags *out, const sheen_frame *frame,
                                       sheen_tag_detector *detector, const sheen_board_set *boards,
                                       sheen_err *err)
{
    *out = (sheen_cli_frame_tags){0};
    sheen_status s = sheen_frame_develop(&out->raster, frame, err);
    if (s)
        return s;
    const sheen_raster *r = &out->raster;
    out->grey = malloc((size_t)r->width_px * (size_t)r->height_px);
    if (!out->grey)
        s = sheen_fail_memory(err, (double)r->width_px * r->height_px, "a grey picture");
    else {
        sheen_raster_grey(out->grey, r, frame->info.transfer);
        s = sheen_tags_detect(&out->tags, &out->n_tags, detector, out->grey, r->width_px, r->height_px,
                              boards, err);
    }
    if (s)
        sheen_cli_frame_tags_release(out);
    return s;
}
