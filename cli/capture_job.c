// SPDX-License-Identifier: Apache-2.0
// capture_job.c - one session's capture: opens source and session, records with a policy, says what came of it.
#include "cli/capture_job.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "capture/import.h"
#include "cli/camera_open.h"
#include "cli/choose.h"
#include "cli/hook.h"
#include "cli/shutter.h"
#include "cli/white.h"

// One capture at work.
typedef struct capture_job {
    sheen_cli *cli;
    const sheen_cli_capture *args;
    const sheen_session *session;
    sheen_cli_white white;
    sheen_cli_choose choose;
} capture_job;

// What a camera lost; nothing of a recording, which loses none.
static void report_counts(sheen_cli *cli, const sheen_source *src)
{
    sheen_source_counts c;
    if (!sheen_source_is_live(src))
        return;
    sheen_source_counters(&c, src);
    sheen_cli_say(cli,
                  "the camera delivered %lld good frames; %lld dropped, %lld flagged as damaged, %lld cut "
                  "short, %lld late, "
                  "%lld with other settings",
                  (long long)c.n_frames, (long long)c.n_dropped, (long long)c.n_flagged, (long long)c.n_short,
                  (long long)c.n_late, (long long)c.n_unlocked);
    sheen_json_open(&cli->out, "camera_frames", '{');
    sheen_json_put_int(&cli->out, "good", c.n_frames);
    sheen_json_put_int(&cli->out, "dropped", c.n_dropped);
    sheen_json_put_int(&cli->out, "flagged", c.n_flagged);
    sheen_json_put_int(&cli->out, "short", c.n_short);
    sheen_json_put_int(&cli->out, "late", c.n_late);
    sheen_json_put_int(&cli->out, "unlocked", c.n_unlocked);
    sheen_json_close(&cli->out);
}

static void report(sheen_cli *cli, const sheen_session *s, const sheen_record_report *r,
                   const sheen_cli_white *w)
{
    sheen_cli_say(cli, "%zu frame%s recorded into '%s'%s", r->n_recorded, sheen_cli_plural(r->n_recorded),
                  s->path, r->n_present ? ", the others were there already" : "");
    if (r->n_skipped)
        sheen_cli_warn(cli, "%zu frame%s passed over because the disk was slower than the camera",
                       r->n_skipped, r->n_skipped == 1 ? " was" : "s were");
    if (w->detector && w->n_unseen)
        sheen_cli_warn(cli,
                       "%zu of them did not show the board: whether the light changed there is not known",
                       w->n_unseen);
    sheen_json_put_string(&cli->out, "session", s->path);
    sheen_json_put_int(&cli->out, "recorded_frames", (long long)r->n_recorded);
    sheen_json_put_int(&cli->out, "present_frames", (long long)r->n_present);
    sheen_json_put_int(&cli->out, "skipped_frames", (long long)r->n_skipped);
    sheen_json_put_int(&cli->out, "recovered_stalls", r->n_recovered);
}

static void on_notice(void *self, const char *text)
{
    sheen_cli_clear_bar(self);
    sheen_cli_warn(self, "%s", text);
}

// A frame is safe on the disk.
static sheen_status on_stored(void *self, const sheen_frame_info *f, sheen_err *err)
{
    const capture_job *job = self;
    char missing[120];
    if (job->args->choose) {
        sheen_cli_choose_missing(missing, &job->choose);
        sheen_cli_clear_bar(job->cli);
        sheen_cli_say(job->cli, "%s taken: %s", f->name, missing);
    }
    return sheen_cli_hook_frame(job->args->hook, job->session, f, err);
}

static sheen_status ask_chooser(void *self, int64_t *since_ns, sheen_err *err)
{
    return sheen_cli_choose_ask(&((capture_job *)self)->choose, since_ns, err);
}

static sheen_status ask_chooser_to_look(void *self, sheen_frame *frame, sheen_verdict *verdict,
                                        sheen_err *err)
{
    return sheen_cli_choose_look(&((capture_job *)self)->choose, frame, verdict, err);
}

static sheen_status begin_choosing(capture_job *job, sheen_cli_capture *a, sheen_err *err)
{
    job->choose = (sheen_cli_choose){.spread_rad = a->spread_deg * 0.017453292519943295,
                                     .max_motion_px = a->max_motion_px,
                                     .max_blur_px = a->max_blur_px,
                                     .hint = on_notice,
                                     .hint_self = job->cli};
    a->o.policy.ask = ask_chooser;
    a->o.policy.look = ask_chooser_to_look;
    return sheen_cli_choose_init(&job->choose, job->session, err);
}

// Who decides which frames are taken.
static sheen_status set_policy(capture_job *job, sheen_cli_capture *a, const sheen_source *src,
                               sheen_err *err)
{
    const bool live = sheen_source_is_live(src);
    if (a->turntable) // it has set its own
        return SHEEN_OK;
    a->by_hand = live && (a->choose || !a->o.count);
    a->o.policy.self = job;
    a->o.policy.stored = on_stored;
    if (a->by_hand) {
        sheen_cli_shutter_open();
        sheen_cli_say(job->cli, "Enter takes a frame (kill -USR1 %ld, too), q ends", (long)getpid());
    }
    if (a->choose)
        return begin_choosing(job, a, err);
    if (a->by_hand)
        a->o.policy.ask = sheen_cli_shutter_ask;
    return SHEEN_OK;
}

sheen_status sheen_cli_capture_record(sheen_cli *cli, sheen_cli_capture *a, sheen_session *s,
                                      sheen_source *src, sheen_record_report *r, sheen_err *err)
{
    capture_job job = {.cli = cli, .args = a, .session = s};
    a->o.progress = sheen_cli_progress(cli);
    sheen_status st = sheen_source_is_live(src) ? sheen_cli_white_init(&job.white, s, err) : SHEEN_OK;
    a->o.notice = on_notice;
    a->o.notice_self = cli;
    a->o.check = sheen_cli_white_check;
    a->o.check_self = &job.white;
    if (!st)
        st = set_policy(&job, a, src, err);
    if (!st)
        st = sheen_cli_hook(a->hook, "init", s->path, err);
    if (!st)
        st = sheen_record(s, src, &a->o, r, err);
    sheen_cli_clear_bar(cli);
    if (st == SHEEN_ECANCEL && a->by_hand && r->n_recorded) // Ctrl-C ends it as q does
        st = SHEEN_OK;
    if (!st) {
        report(cli, s, r, &job.white);
        report_counts(cli, src);
        st = sheen_cli_hook(a->hook, "stop", s->path, err);
    }
    a->o.policy.self = a->o.check_self = NULL; // they were of this call
    sheen_cli_choose_release(&job.choose);
    sheen_cli_white_release(&job.white);
    return st;
}

// A new session's camera is set as in the one that it is like: what was measured belongs to these settings.
static sheen_status follow_like(sheen_cli *cli, const sheen_cli_capture *a, sheen_source *src, sheen_err *err)
{
    sheen_session other;
    bool followed;
    sheen_status st = sheen_session_open(&other, a->like, err);
    if (st)
        return st;
    st = sheen_cli_follow(cli, &other, src, false, &followed, err);
    sheen_session_release(&other);
    return st;
}

// The camera is measured instead where that was asked for; else the session goes on under the settings that it was begun
// with.
static sheen_status use_camera(sheen_cli *cli, sheen_cli_capture *a, sheen_session *s, sheen_source *src,
                               sheen_record_report *r, sheen_err *err)
{
    bool followed;
    if (a->measure.dark || a->measure.flat || a->measure.response) {
        a->o.progress = sheen_cli_progress(cli);
        a->o.notice = on_notice;
        a->o.notice_self = cli;
        a->measure.bracket = a->o.bracket;
        return sheen_cli_measure_camera(cli, &a->measure, s, src, &a->o, err);
    }
    sheen_status st = sheen_cli_follow(cli, s, src, false, &followed, err);
    if (!st && !followed && a->like)
        st = follow_like(cli, a, src, err);
    if (st)
        return st;
    return a->turntable ? sheen_cli_capture_turns(cli, a, s, src, r, err)
                        : sheen_cli_capture_record(cli, a, s, src, r, err);
}

// What a new session takes over from another one: it is not there yet, and the other has it.
static sheen_status take_over(sheen_session *s, const char *like, sheen_err *err)
{
    static const char *const files[2] = {SHEEN_SESSION_CAMERA, SHEEN_SESSION_BOARD};
    char paths[3][SHEEN_PATH_MAX];
    const char *found[3] = {NULL};
    sheen_session other;
    sheen_import_report r;
    if (!like)
        return SHEEN_OK;
    sheen_status st = sheen_session_open(&other, like, err);
    if (st)
        return st;
    const char *const names[3] = {files[0], files[1], sheen_session_mesh_file(&other)};
    for (int i = 0; i < 3 && !st; i++) {
        const bool there = i < 2 ? sheen_session_has(s, names[i]) : sheen_session_mesh_file(s) != NULL;
        if (!names[i] || there || !sheen_session_has(&other, names[i]))
            continue;
        st = sheen_session_path(paths[i], &other, names[i], err);
        found[i] = paths[i];
    }
    const sheen_import_options o = {.camera = found[0], .board = found[1], .mesh = found[2]};
    if (!st && (found[0] || found[1] || found[2]))
        st = sheen_import(s, &o, &r, err);
    if (!st)
        st = sheen_radiometry_copy(s, &other, err);
    sheen_session_release(&other);
    return st;
}

sheen_status sheen_cli_capture_session(sheen_cli *cli, sheen_cli_capture *a, const char *path, sheen_err *err)
{
    sheen_source *src = NULL;
    sheen_cli_session s = {0};
    sheen_record_report r = {0};
    sheen_status st = sheen_cli_camera_open(cli, &src, a->device, a->remember, err);
    if (!st)
        st = sheen_cli_session_create(&s, path, a->moved, err);
    if (!st)
        st = take_over(&s.session, a->like, err);
    if (!st)
        st = use_camera(cli, a, &s.session, src, &r, err);
    sheen_cli_clear_bar(cli);
    if (st && r.n_recorded)
        sheen_cli_warn(cli, "%zu new frame%s recorded before that; the same command goes on from there",
                       r.n_recorded, r.n_recorded == 1 ? " was" : "s were");
    if (st && r.n_lost)
        sheen_cli_warn(cli, "%zu frame%s taken and could not be stored", r.n_lost,
                       r.n_lost == 1 ? " was" : "s were");
    sheen_cli_session_close(&s, st != SHEEN_OK);
    sheen_source_close(&src);
    return st;
}
