// SPDX-License-Identifier: Apache-2.0
// choose.c - chooses frames of a hand-held camera by what they show of the board.
//
// A frame is judged against the one before it, so that a hand has come to rest when one is taken. The ring counts as
// covered when nobody could stand in it further than a little more than the spread from every view.
#include "cli/choose.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calib/stillness.h"
#include "cli/frame_tags.h"
#include "cli/shutter.h"

static const double covered = 1.25; // holes of so many spreads are none: a hand does not hit their middle
static const double frame_ns = 1e9 / 30;
static const int64_t hint_every_ns = 1000000000, neighbours_ns = 500000000;

typedef enum hint { NONE, NO_BOARD, MOVES, BLURRED, NOT_NEW } hint;

static sheen_status load_camera(sheen_cli_choose *c, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (!sheen_session_has(s, SHEEN_SESSION_CAMERA))
        return SHEEN_OK;
    c->camera = malloc(sizeof *c->camera);
    if (!c->camera)
        return sheen_fail_memory(err, sizeof *c->camera, "a camera");
    const sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_CAMERA, err);
    return st ? st : sheen_camera_load(c->camera, path, err);
}

// The views that the session has already. A frame that does not show the board has none.
static sheen_status load_views(sheen_cli_choose *c, const sheen_session *s, sheen_err *err)
{
    for (size_t i = 0; i < s->n_frames; i++) {
        sheen_frame frame = {.info = s->frames[i]};
        uint8_t *payload = NULL;
        sheen_cli_frame_tags t;
        double v_board[3];
        if (s->frames[i].role != SHEEN_ROLE_INPUT)
            continue;
        sheen_status st = sheen_session_payload(&payload, &frame.size_bytes, s, &s->frames[i], err);
        frame.data = payload;
        if (!st)
            st = sheen_cli_frame_tags_find(&t, &frame, c->detector, &c->boards, err);
        free(payload);
        if (st)
            return st;
        if (sheen_view_direction(v_board, c->camera, t.raster.width_px, t.raster.height_px, t.tags, t.n_tags))
            sheen_view_sphere_add(&c->sphere, v_board);
        sheen_cli_frame_tags_release(&t);
    }
    return SHEEN_OK;
}

sheen_status sheen_cli_choose_init(sheen_cli_choose *c, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    c->before_ns = c->hinted_ns = INT64_MIN / 2;
    if (!sheen_session_has(s, SHEEN_SESSION_BOARD))
        return sheen_fail(err, SHEEN_EARG,
                          "'%s' has no board: bring it in with 'sheen import %s --board board.json'", s->path,
                          s->path);
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_BOARD, err);
    if (!st)
        st = sheen_board_set_load(&c->boards, path, err);
    if (!st)
        st = sheen_tag_detector_new(&c->detector, c->boards.boards[0].family, err);
    if (!st)
        st = load_camera(c, s, err);
    if (!st)
        st = load_views(c, s, err);
    if (st)
        sheen_cli_choose_release(c);
    return st;
}

void sheen_cli_choose_release(sheen_cli_choose *c)
{
    sheen_tag_detector_free(&c->detector);
    sheen_board_set_release(&c->boards);
    free(c->camera);
    free(c->before);
    c->camera = NULL;
    c->before = NULL;
    c->n_before = 0;
}

bool sheen_cli_choose_missing(char text[120], const sheen_cli_choose *c)
{
    double middle_rad;
    const double hole_rad = sheen_view_sphere_hole_rad(&c->sphere, &middle_rad);
    const size_t n = c->sphere.n_views;
    if (n > 1 && hole_rad <= covered * c->spread_rad) {
        snprintf(text, 120, "%zu views, all around", n);
        return true;
    }
    snprintf(text, 120, "%zu view%s, nothing from %s yet", n, n == 1 ? "" : "s", sheen_view_side(middle_rad));
    return false;
}

sheen_status sheen_cli_choose_ask(void *self, int64_t *since_ns, sheen_err *err)
{
    sheen_cli_choose *c = self;
    char text[120];
    c->by_hand = sheen_cli_shutter() >= 0 || c->by_hand;
    *since_ns = 0;
    if (sheen_cli_shutter_ended())
        return sheen_fail(err, SHEEN_EEND, "the person has ended it");
    return sheen_cli_choose_missing(text, c) ? sheen_fail(err, SHEEN_EEND, "%s", text) : SHEEN_OK;
}

static void give_hint(sheen_cli_choose *c, int64_t t_ns, hint what, double by)
{
    char text[160] = "", missing[120];
    if (what == NONE || !c->hint || (c->last_hint == (int)what && t_ns - c->hinted_ns < 5 * hint_every_ns) ||
        t_ns - c->hinted_ns < hint_every_ns)
        return;
    sheen_cli_choose_missing(missing, c);
    if (what == NO_BOARD)
        snprintf(text, sizeof text, "the board is not in view");
    else if (what == MOVES)
        snprintf(text, sizeof text, "hold still: the picture moves by %.1f px", by);
    else if (what == BLURRED)
        snprintf(text, sizeof text, "not sharp: edges are %.1f px wide, %.1f are allowed", by,
                 c->max_blur_px);
    else
        snprintf(text, sizeof text, "move on: %s", missing);
    c->hint(c->hint_self, text);
    c->last_hint = (int)what;
    c->hinted_ns = t_ns;
}

// How far the picture moved in a thirtieth of a second; 0 where the frame before is too long ago to tell (a recording of
// single frames).
static double motion_px(const sheen_cli_choose *c, int64_t t_ns, const sheen_cli_frame_tags *t)
{
    const int64_t between_ns = t_ns - c->before_ns;
    if (t_ns < 0 || between_ns <= 0 || between_ns > neighbours_ns)
        return 0;
    const double moved_px = sheen_tags_motion_px(c->before, c->n_before, t->tags, t->n_tags);
    return isnan(moved_px) ? (double)INFINITY : moved_px * fmin(1, frame_ns / (double)between_ns);
}

// What is against this frame, with the number that says so.
static hint judge(sheen_cli_choose *c, double *by, int64_t t_ns, const sheen_cli_frame_tags *t)
{
    const sheen_raster *r = &t->raster;
    c->has_view = sheen_view_direction(c->v_board, c->camera, r->width_px, r->height_px, t->tags, t->n_tags);
    if (!c->has_view)
        return NO_BOARD;
    *by = motion_px(c, t_ns, t);
    if (*by > c->max_motion_px)
        return MOVES;
    *by = sheen_tags_blur_px(t->grey, r->width_px, r->height_px, t->tags, t->n_tags);
    if (*by > c->max_blur_px)
        return BLURRED;
    return sheen_view_sphere_nearest_rad(&c->sphere, c->v_board) < c->spread_rad ? NOT_NEW : NONE;
}

sheen_status sheen_cli_choose_look(void *self, sheen_frame *frame, sheen_verdict *verdict, sheen_err *err)
{
    sheen_cli_choose *c = self;
    sheen_cli_frame_tags t;
    double by = 0;
    const sheen_status s = sheen_cli_frame_tags_find(&t, frame, c->detector, &c->boards, err);
    if (s == SHEEN_EFORMAT) { // a frame that is broken inside
        *verdict = SHEEN_VERDICT_PASS;
        return SHEEN_OK;
    }
    if (s)
        return s;
    const hint against = judge(c, &by, frame->info.t_ns, &t);
    *verdict = against && !c->by_hand ? SHEEN_VERDICT_PASS : SHEEN_VERDICT_TAKE;
    free(c->before);
    c->before = t.tags;
    c->n_before = t.n_tags;
    c->before_ns = frame->info.t_ns;
    t.tags = NULL;
    sheen_cli_frame_tags_release(&t);
    if (*verdict == SHEEN_VERDICT_PASS) {
        give_hint(c, frame->info.t_ns, against, by);
        return SHEEN_OK;
    }
    c->by_hand = false;
    if (c->has_view)
        sheen_view_sphere_add(&c->sphere, c->v_board);
    return SHEEN_OK;
}
