// SPDX-License-Identifier: Apache-2.0
// live.c - looks at each frame of a camera: is the board there, still, sharp, and somewhere new; then keeps it.
#include "cli/live.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/board.h"
#include "calib/guide.h"
#include "calib/saddles.h"
#include "calib/steady.h"
#include "capture/record.h"
#include "cli/camera_open.h"

enum { MAX_VIEWS = 200 };

static const double STILL_PX = 0.35; // from one frame to the next
static const double SHARP_PX = 1.6;  // sigma of edges
static const double NEW_PX = 40;     // from every frame taken so far, of a picture 1280 px wide

typedef struct live {
    sheen_cli *cli;
    const sheen_live_options *options;
    sheen_board board;
    sheen_tag_detector *detector;
    sheen_board_view last, taken[MAX_VIEWS];
    size_t n_taken;
    const char *told; // what the person was told last about the present picture
    bool done;
} live;

static void tell(live *l, const char *what)
{
    if (l->told == what)
        return;
    l->told = what;
    if (what)
        sheen_cli_say(l->cli, "  %s", what);
}

static sheen_status observe(sheen_board_view *view, double *blur_px, live *l, const sheen_frame *frame,
                            sheen_err *err)
{
    sheen_raster r;
    *view = (sheen_board_view){0};
    sheen_status s = sheen_frame_develop(&r, frame, err);
    if (s)
        return s;
    uint8_t *grey = malloc((size_t)r.width_px * (size_t)r.height_px);
    if (!grey)
        s = sheen_fail_memory(err, (double)r.width_px * r.height_px, "a grey picture");
    else {
        sheen_raster_grey(grey, &r, frame->info.transfer);
        s = sheen_board_observe(view, l->detector, grey, r.width_px, r.height_px, &l->board, err);
        *blur_px = s ? (double)NAN : sheen_view_blur_px(view, grey);
    }
    free(grey);
    sheen_raster_release(&r);
    return s;
}

// Why the frame is not taken; NULL: take it.
static const char *objection(const live *l, const sheen_board_view *view, double blur_px)
{
    if (!view->n_tags)
        return "the board is not in view";
    if (view->n_saddles < SHEEN_CALIBRATE_MIN_CORNERS)
        return "more of the board must be in view, larger or sharper";
    if (!(sheen_views_motion_px(&l->last, view) <= STILL_PX))
        return "hold still";
    if (!(blur_px <= SHARP_PX))
        return "not sharp: more light, or another distance";
    for (size_t i = 0; i < l->n_taken; i++)
        if (sheen_views_motion_px(&l->taken[i], view) <= NEW_PX * view->width_px / 1280)
            return "that one is taken: move the board as said";
    return NULL;
}

static sheen_status look(void *self, sheen_frame *frame, sheen_verdict *verdict, sheen_err *err)
{
    live *l = self;
    sheen_board_view view;
    double blur_px = (double)NAN;
    *verdict = SHEEN_VERDICT_PASS;
    if (l->done)
        return sheen_fail(err, SHEEN_EEND, "the accuracy is reached");
    const sheen_status s = observe(&view, &blur_px, l, frame, err);
    if (s)
        return s;
    const char *why_not = objection(l, &view, blur_px);
    tell(l, why_not);
    if (!why_not) {
        *verdict = SHEEN_VERDICT_TAKE;
        l->taken[l->n_taken++] = view;
        view = (sheen_board_view){0};
    }
    sheen_board_view_release(&l->last);
    l->last = view;
    return SHEEN_OK;
}

static sheen_status advise(live *l, sheen_err *err)
{
    sheen_guidance next;
    const sheen_status s = sheen_guide_next(&next, &l->board, l->taken, l->n_taken, l->options->accuracy_px,
                                            err);
    if (s)
        return s;
    l->done = next.done || l->n_taken >= (size_t)l->options->max_frames || l->n_taken >= MAX_VIEWS;
    if (isfinite(next.sigma_px))
        sheen_cli_say(l->cli, "%zu taken; the lens is certain to %.3f px%s", l->n_taken, next.sigma_px,
                      next.done ? ": enough" : "");
    else
        sheen_cli_say(l->cli, "%zu taken", l->n_taken);
    if (!l->done && isfinite(next.expected_px))
        sheen_cli_say(l->cli, "%s (then %.3f px)", next.words, next.expected_px);
    else if (!l->done)
        sheen_cli_say(l->cli, "%s", next.words);
    return SHEEN_OK;
}

static sheen_status stored(void *self, const sheen_frame_info *info, sheen_err *err)
{
    (void)info;
    live *l = self;
    l->told = NULL;
    const sheen_status s = advise(l, err);
    return s ? s : l->done ? sheen_fail(err, SHEEN_EEND, "the accuracy is reached") : SHEEN_OK;
}

static sheen_status load_board(live *l, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const char *file = sheen_session_has(s, SHEEN_SESSION_CALIBRATION_BOARD) ? SHEEN_SESSION_CALIBRATION_BOARD
                                                                             : SHEEN_SESSION_BOARD;
    if (!sheen_session_has(s, file))
        return sheen_fail(err, SHEEN_EDATA, "session '%s' has no board: give --board FILE", s->path);
    sheen_status st = sheen_session_path(path, s, file, err);
    if (!st)
        st = sheen_board_load(&l->board, path, err);
    if (!st)
        st = sheen_tag_detector_new(&l->detector, l->board.family, err);
    return st;
}

sheen_status sheen_cli_live(sheen_cli *cli, sheen_session *s, const sheen_live_options *options,
                            size_t *n_taken, sheen_err *err)
{
    sheen_source *src = NULL;
    sheen_record_report report = {0};
    sheen_record_options record = {.set_role = true, .role = SHEEN_ROLE_CALIBRATION};
    live *l = calloc(1, sizeof *l);
    if (!l)
        return sheen_fail_memory(err, sizeof *l, "a live calibration");
    l->cli = cli;
    l->options = options;
    record.policy = (sheen_record_policy){.self = l, .look = look, .stored = stored};
    sheen_status st = load_board(l, s, err);
    if (!st)
        st = sheen_cli_camera_open(cli, &src, options->device, false, err);
    if (!st)
        st = advise(l, err);
    if (!st)
        st = sheen_record(s, src, &record, &report, err);
    *n_taken = report.n_recorded + report.n_present;
    if ((st == SHEEN_EEND || st == SHEEN_ECANCEL) && *n_taken) // enough, or the person says so
        st = SHEEN_OK;
    sheen_source_close(&src);
    sheen_board_view_release(&l->last);
    for (size_t i = 0; i < l->n_taken; i++)
        sheen_board_view_release(&l->taken[i]);
    sheen_tag_detector_free(&l->detector);
    sheen_board_release(&l->board);
    free(l);
    return st;
}
