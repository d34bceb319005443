// SPDX-License-Identifier: Apache-2.0
// session.c - the session's folder and its manifest, session.json.
#include "base/session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/json_write.h"
#include "base/session_private.h"

enum { MANIFEST_VERSION = 1 };

static const char *const moving_names[] = {
    [SHEEN_MOVING_CAMERA] = "camera",
    [SHEEN_MOVING_OBJECT] = "object",
};

const char *sheen_moving_name(sheen_moving m)
{
    return moving_names[m];
}

sheen_status sheen_moving_from_name(sheen_moving *out, const char *name, sheen_err *err)
{
    for (size_t i = 0; i < sizeof moving_names / sizeof *moving_names; i++)
        if (!strcmp(name, moving_names[i])) {
            *out = (sheen_moving)i;
            return SHEEN_OK;
        }
    return sheen_fail(err, SHEEN_EARG, "'%.60s' does not say what moved: use 'camera' or 'object'", name);
}

static sheen_status parse_manifest(sheen_session *s, const sheen_json *root, sheen_err *err)
{
    const char *moving, *created;
    sheen_status st = sheen_json_schema(root, "sheen-session", MANIFEST_VERSION, NULL, err);
    if (!st)
        st = sheen_json_string(root, "moving", &moving, err);
    if (!st)
        st = sheen_json_string(root, "created", &created, err);
    if (st)
        return st;
    snprintf(s->created, sizeof s->created, "%s", created);
    return sheen_moving_from_name(&s->moving, moving, NULL)
               ? sheen_fail(err, SHEEN_EFORMAT, "'moving' is '%.60s', not 'camera' or 'object'", moving)
               : SHEEN_OK;
}

static sheen_status read_manifest(sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_json *root = NULL;
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_MANIFEST, err);
    if (st)
        return st;
    if (!sheen_dir_exists(s->path))
        return sheen_fail(err, SHEEN_EIO, "no such folder");
    if (!sheen_file_exists(path))
        return sheen_fail(err, SHEEN_EFORMAT, "not a session, it has no '" SHEEN_SESSION_MANIFEST "'");
    st = sheen_json_load(&root, path, err);
    if (!st) {
        st = parse_manifest(s, root, err);
        if (st)
            sheen_wrap(err, st, "cannot read '%s'", path);
    }
    sheen_json_free(&root);
    return st;
}

static sheen_status set_path(sheen_session *s, const char *path, sheen_err *err)
{
    *s = (sheen_session){0};
    size_t n = strlen(path);
    while (n > 1 && path[n - 1] == '/')
        n--;
    if (!n || n >= sizeof s->path)
        return sheen_fail(err, SHEEN_EARG,
                          n ? "the session's path is too long" : "the session's path is empty");
    memcpy(s->path, path, n);
    s->path[n] = 0;
    return SHEEN_OK;
}

sheen_status sheen_session_open(sheen_session *s, const char *path, sheen_err *err)
{
    sheen_status st = set_path(s, path, err);
    if (st)
        return st;
    st = read_manifest(s, err);
    if (!st)
        st = sheen_session_roll_forward(s, err);
    if (!st)
        st = sheen_session_list_frames(s, err);
    if (!st)
        return SHEEN_OK;
    sheen_session_release(s);
    return sheen_wrap(err, st, "cannot open session '%s'", path);
}

static void now_utc(char text[32])
{
    const time_t t = time(NULL);
    struct tm utc;
    gmtime_r(&t, &utc);
    strftime(text, 32, "%Y-%m-%dT%H:%M:%SZ", &utc);
}

// A folder that may become a session: there is none, or nothing is in it.
static sheen_status check_empty(const char *path, sheen_err *err)
{
    if (!sheen_dir_exists(path))
        return SHEEN_OK;
    sheen_names names;
    const sheen_status st = sheen_dir_list(&names, path, NULL, err);
    if (st)
        return st;
    // An empty frames/ is what a cut during this function leaves.
    const bool fine = !names.count || (names.count == 1 && !strcmp(names.names[0], SHEEN_SESSION_FRAMES));
    sheen_names_release(&names);
    return fine
               ? SHEEN_OK
               : sheen_fail(err, SHEEN_EARG,
                            "'%s' holds other things and is not a session: name a new or empty folder", path);
}

// What a power cut left; another program may be writing, so that what is young stays.
static void sweep(const sheen_session *s)
{
    static const char *const folders[] = {".", SHEEN_SESSION_FRAMES, SHEEN_SESSION_MASKS};
    enum { STALE_S = 600 };
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        char path[SHEEN_PATH_MAX];
        if (!sheen_session_path(path, s, folders[i], NULL))
            sheen_dir_sweep(path, STALE_S);
    }
}

sheen_status sheen_session_create(sheen_session *s, const char *path, sheen_moving moving, sheen_err *err)
{
    sheen_status st = set_path(s, path, err);
    if (st)
        return st;
    if (sheen_session_has(s, SHEEN_SESSION_MANIFEST)) {
        st = sheen_session_open(s, path, err);
        if (!st)
            sweep(s);
        return st;
    }
    char frames[SHEEN_PATH_MAX];
    st = check_empty(s->path, err);
    if (st)
        return st;
    st = sheen_session_path(frames, s, SHEEN_SESSION_FRAMES, err);
    if (!st)
        st = sheen_dir_make(frames, err);
    if (!st) {
        s->moving = moving;
        now_utc(s->created);
        st = sheen_session_save(s, err);
    }
    return st ? sheen_wrap(err, st, "cannot make session '%s'", path) : SHEEN_OK;
}

void sheen_session_release(sheen_session *s)
{
    if (!s)
        return;
    free(s->frames);
    s->frames = NULL;
    s->n_frames = 0;
}

sheen_status sheen_session_save(const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_MANIFEST, err);
    if (st)
        return st;
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-session/1");
    sheen_json_put_string(&w, "created", s->created);
    sheen_json_put_string(&w, "moving", sheen_moving_name(s->moving));
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}

sheen_status sheen_session_path(char out[SHEEN_PATH_MAX], const sheen_session *s, const char *file,
                                sheen_err *err)
{
    return sheen_path_join(out, s->path, file, err);
}

bool sheen_session_has(const sheen_session *s, const char *file)
{
    char path[SHEEN_PATH_MAX];
    return !sheen_session_path(path, s, file, NULL) && (sheen_file_exists(path) || sheen_dir_exists(path));
}

const char *const sheen_session_mesh_files[] = {"mesh.ply", "mesh.obj", "mesh.glb", NULL};

const char *sheen_session_mesh_file(const sheen_session *s)
{
    for (const char *const *f = sheen_session_mesh_files; *f; f++)
        if (sheen_session_has(s, *f))
            return *f;
    return NULL;
}
