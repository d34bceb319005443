// SPDX-License-Identifier: Apache-2.0
// capture_turns.c - a session by turntable: the recorder's steps, watched by the board's tags and by the person's keys.
#include <stdio.h>
#include <string.h>

#include "capture/turn_steps.h"
#include "cli/capture_job.h"
#include "cli/hook.h"
#include "cli/keys.h"
#include "cli/table_arg.h"
#include "cli/table_eye.h"

typedef struct turning {
    sheen_cli *cli;
    const sheen_cli_capture *args;
    const sheen_session *session;
    sheen_cli_eye eye;
    sheen_record_policy steps; // of the table; asked between the person's keys
} turning;

static sheen_status see(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                        double *angle_deg, sheen_err *err)
{
    return sheen_cli_eye_see(&((turning *)self)->eye, frame, reference, angle_deg, err);
}

static sheen_status next_round(void *self, int i_round, sheen_err *err)
{
    const turning *t = self;
    char prompt[80], line[16];
    snprintf(prompt, sizeof prompt, "round %d: put the camera at its next height, then press Enter", i_round);
    const sheen_status s = sheen_cli_ask(line, sizeof line, t->cli, prompt, err);
    return s ? sheen_wrap(err, s, "round %d was not begun", i_round) : s;
}

static sheen_status place_object(void *self, bool on, sheen_err *err)
{
    const turning *t = self;
    char line[16];
    const sheen_status s = sheen_cli_ask(
        line, sizeof line, t->cli,
        on ? "put the object on the board as it shall stand, then press Enter"
           : "take the object off, leave the board, then press Enter",
        err);
    return s ? sheen_wrap(err, s, "the turn was not begun") : s;
}

static sheen_status ask(void *self, int64_t *since_ns, sheen_err *err)
{
    turning *t = self;
    const sheen_status s = sheen_cli_keys_between(t->cli, err);
    return s ? s : t->steps.ask(t->steps.self, since_ns, err);
}

static sheen_status look(void *self, sheen_frame *frame, sheen_verdict *verdict, sheen_err *err)
{
    turning *t = self;
    if (sheen_cli_keys_stopped())
        return sheen_fail(err, SHEEN_ECANCEL, "stopped by the person");
    return t->steps.look(t->steps.self, frame, verdict, err);
}

static sheen_status stored(void *self, const sheen_frame_info *f, sheen_err *err)
{
    const turning *t = self;
    return sheen_cli_hook_frame(t->args->hook, t->session, f, err);
}

size_t sheen_cli_capture_missing(const sheen_cli_capture *a, const sheen_session *s)
{
    const sheen_turn_options o = {
        .n_steps = a->n_steps, .n_rounds = a->n_rounds, .place_object = a->background ? place_object : NULL};
    return sheen_turn_steps_missing(s, &o);
}

static sheen_status check(sheen_cli *cli, const sheen_cli_capture *a, const sheen_session *s,
                          const sheen_source *src, const sheen_cli_eye *eye, sheen_err *err)
{
    if (s->moving != SHEEN_MOVING_OBJECT)
        return sheen_fail(err, SHEEN_EARG,
                          "'%s' is a session of a camera that moves: a turntable wants one of its own",
                          s->path);
    if (!sheen_source_is_live(src))
        return sheen_fail(err, SHEEN_EARG, "a turntable wants a camera: '%s' is none", a->device);
    if (!eye->detector)
        sheen_cli_warn(
            cli,
            "'%s' has no camera model or no board: the angles are those commanded, and a broken turn "
            "cannot be gone on with",
            s->path);
    return SHEEN_OK;
}

// The table is there.
static sheen_status turn(turning *t, sheen_cli_capture *a, sheen_session *s, sheen_source *src,
                         sheen_record_report *r, sheen_table *table, sheen_err *err)
{
    sheen_turn_steps steps = {0};
    const bool by_hand = !strncmp(a->turntable, "manual:", 7);
    t->eye.any_axis = by_hand;
    const sheen_turn_options o = {.n_steps = a->n_steps,
                                  .n_rounds = a->n_rounds,
                                  .see = t->eye.detector ? see : NULL,
                                  .next_round = next_round,
                                  .place_object = a->background ? place_object : NULL,
                                  .self = t,
                                  .tolerance_deg = by_hand ? 180.0 / a->n_steps : 0};
    sheen_status st = sheen_turn_steps_init(&steps, s, table, &o, err);
    if (st)
        return st;
    t->steps = sheen_turn_steps_policy(&steps);
    a->o.policy = (sheen_record_policy){.self = t, .ask = ask, .look = look, .stored = stored};
    sheen_cli_say(t->cli,
                  "Ctrl-C or the key s stops the turntable at once; p pauses before the next step, q ends");
    st = sheen_cli_capture_record(t->cli, a, s, src, r, err);
    sheen_turn_steps_release(&steps);
    return st;
}

sheen_status sheen_cli_capture_turns(sheen_cli *cli, sheen_cli_capture *a, sheen_session *s,
                                     sheen_source *src, sheen_record_report *r, sheen_err *err)
{
    turning t = {.cli = cli, .args = a, .session = s};
    sheen_table *table = NULL;
    sheen_table_config config;
    sheen_status st = sheen_cli_eye_init(&t.eye, s, err);
    if (!st)
        st = check(cli, a, s, src, &t.eye, err);
    a->o.count = sheen_cli_capture_missing(a, s);
    if (!st && !a->o.count)
        sheen_cli_say(cli, "all %d frames are there", a->n_steps * a->n_rounds + a->background);
    else if (!st) {
        sheen_cli_keys_open();
        st = sheen_cli_table_open(&table, &config, cli, a->turntable, a->turntable_file, err);
        if (!st)
            st = turn(&t, a, s, src, r, table, err);
        sheen_table_close(&table);
        sheen_cli_keys_close();
    }
    sheen_cli_eye_release(&t.eye);
    return st;
}
