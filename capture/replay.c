// SPDX-License-Identifier: Apache-2.0
// replay.c - replay:SESSION, a recorded session as a source: every frame as it was delivered, as fast as it is asked for.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture/source_backend.h"

typedef struct replay {
    sheen_session session;
    bool one_role;
    sheen_role role;
    size_t i_next;
    uint8_t *payload, *mask; // lent out
} replay;

static const size_t mask_max_bytes = (size_t)256 << 20;

// Splits "PATH?role=test" and reads the options.
static sheen_status parse_rest(replay *r, char path[SHEEN_PATH_MAX], const char *rest, sheen_err *err)
{
    const char *query = strrchr(rest, '?');
    const size_t n = query ? (size_t)(query - rest) : strlen(rest);
    if (!n || n >= SHEEN_PATH_MAX)
        return sheen_fail(err, SHEEN_EARG, n ? "its path is too long" : "it names no session");
    memcpy(path, rest, n);
    path[n] = 0;
    if (!query)
        return SHEEN_OK;
    static const char role[] = "?role=";
    if (strncmp(query, role, sizeof role - 1) != 0)
        return sheen_fail(err, SHEEN_EARG,
                          "unknown option '%.60s': there is only '?role=input|calibration|test|background'",
                          query);
    r->one_role = true;
    return sheen_role_from_name(&r->role, query + sizeof role - 1, err);
}

static bool is_played(const replay *r, size_t i)
{
    return !r->one_role || r->session.frames[i].role == r->role;
}

static int64_t replay_count(const void *self)
{
    const replay *r = self;
    return r->one_role ? (int64_t)sheen_session_count_role(&r->session, r->role)
                       : (int64_t)r->session.n_frames;
}

static void replay_close(void *self)
{
    replay *r = self;
    sheen_session_release(&r->session);
    free(r->payload);
    free(r->mask);
    free(r);
}

static sheen_status replay_open(void **self_out, const char *rest, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    replay *r = calloc(1, sizeof *r);
    if (!r)
        return sheen_fail_memory(err, sizeof *r, "a replay");
    sheen_status s = parse_rest(r, path, rest, err);
    if (!s)
        s = sheen_session_open(&r->session, path, err);
    if (!s && !replay_count(r))
        s = sheen_fail(err, SHEEN_EDATA, "the session has no frames%s%s", r->one_role ? " of role " : "",
                       r->one_role ? sheen_role_name(r->role) : "");
    if (s) {
        replay_close(r);
        return s;
    }
    *self_out = r;
    return SHEEN_OK;
}

static sheen_status lend_mask(replay *r, sheen_frame *frame, sheen_err *err)
{
    char file[160], path[SHEEN_PATH_MAX];
    snprintf(file, sizeof file, SHEEN_SESSION_MASKS "/%s.png", frame->info.name);
    sheen_status s = sheen_session_path(path, &r->session, file, err);
    if (s || !sheen_file_exists(path))
        return s;
    s = sheen_file_read(&r->mask, &frame->mask_bytes, path, mask_max_bytes, err);
    frame->mask = r->mask;
    return s;
}

static sheen_status replay_next(void *self, int timeout_ms, sheen_frame *frame, sheen_err *err)
{
    (void)timeout_ms; // never waits
    replay *r = self;
    free(r->payload);
    free(r->mask);
    r->payload = r->mask = NULL;
    while (r->i_next < r->session.n_frames && !is_played(r, r->i_next))
        r->i_next++;
    if (r->i_next == r->session.n_frames)
        return sheen_fail(err, SHEEN_EEND, "the recording is over");
    const sheen_frame_info *f = &r->session.frames[r->i_next++];
    sheen_status s = sheen_session_payload(&r->payload, &frame->size_bytes, &r->session, f, err);
    if (s)
        return s;
    frame->info = *f;
    frame->data = r->payload;
    frame->extension = sheen_path_extension(f->file); // lent by the session's list, which stays
    return lend_mask(r, frame, err);
}

const sheen_source_backend sheen_source_replay = {
    .scheme = "replay",
    .open = replay_open,
    .next = replay_next,
    .stop = NULL,
    .count = replay_count,
    .close = replay_close,
};
