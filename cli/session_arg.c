// SPDX-License-Identifier: Apache-2.0
// session_arg.c - the SESSION argument of commands that may have to make one.
#include <string.h>

#include "cli/cli.h"

sheen_status sheen_cli_session_create(sheen_cli_session *s, const char *path, sheen_moving moving,
                                      sheen_err *err)
{
    char manifest[SHEEN_PATH_MAX];
    *s = (sheen_cli_session){0};
    const sheen_status st = sheen_path_join(manifest, path, SHEEN_SESSION_MANIFEST, err);
    if (st)
        return st;
    s->fresh = !sheen_file_exists(manifest);
    s->fresh_dir = !sheen_dir_exists(path);
    return sheen_session_create(&s->session, path, moving, err);
}

// Whether the folder has no name that ends in `suffix` but these two.
static bool holds_only(const sheen_session *s, const char *folder, const char *suffix, const char *a,
                       const char *b)
{
    char dir[SHEEN_PATH_MAX];
    sheen_names names;
    if (sheen_session_path(dir, s, folder, NULL) || sheen_dir_list(&names, dir, suffix, NULL))
        return false;
    bool only = true;
    for (size_t i = 0; i < names.count; i++)
        only = only && (!strcmp(names.names[i], a) || !strcmp(names.names[i], b));
    sheen_names_release(&names);
    return only;
}

// Whether the session is empty still: another process may have put something there meanwhile.
static bool is_empty(const sheen_session *s)
{
    return holds_only(s, "", NULL, SHEEN_SESSION_MANIFEST, SHEEN_SESSION_FRAMES) &&
           holds_only(s, SHEEN_SESSION_FRAMES, ".json", "", "");
}

void sheen_cli_session_close(sheen_cli_session *s, bool failed)
{
    char path[SHEEN_PATH_MAX];
    if (failed && s->fresh && !s->session.n_frames && s->session.path[0] && is_empty(&s->session)) {
        if (!sheen_session_path(path, &s->session, SHEEN_SESSION_MANIFEST, NULL))
            sheen_file_remove(path, NULL);
        if (!sheen_session_path(path, &s->session, SHEEN_SESSION_FRAMES, NULL))
            sheen_dir_remove(path, NULL);
        if (s->fresh_dir)
            sheen_dir_remove(s->session.path, NULL);
    }
    sheen_session_release(&s->session);
}
