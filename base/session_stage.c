// SPDX-License-Identifier: Apache-2.0
// session_stage.c - files that enter a session together.
//
// They are first written into .staging/. Renaming that folder to .commit/ is the one step that decides: before it
// nothing has happened, after it everything will. Its files are then renamed to their places, payloads before
// sidecars before the rest, and the folder is removed; whoever opens the session next finishes an interrupted commit.
// A stale .staging/ means nothing and is removed by the next commit.
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/session_private.h"

#define STAGING ".staging"
#define COMMIT ".commit"

// So that what was renamed or written in a folder outlasts a power cut. Not every file system can: no error.
static void sync_dir(const sheen_session *s, const char *folder)
{
    char path[SHEEN_PATH_MAX];
    const int fd = sheen_session_path(path, s, folder, NULL) ? -1
                                                             : open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return;
    fsync(fd);
    close(fd);
}

sheen_status sheen_session_stage(sheen_session *staged, const sheen_session *s, sheen_err *err)
{
    char frames[SHEEN_PATH_MAX];
    *staged = (sheen_session){.moving = s->moving};
    memcpy(staged->created, s->created, sizeof staged->created);
    sheen_status st = sheen_session_path(staged->path, s, STAGING, err);
    if (!st)
        st = sheen_dir_remove(staged->path, err);
    if (!st)
        st = sheen_session_path(frames, staged, SHEEN_SESSION_FRAMES, err);
    return st ? st : sheen_dir_make(frames, err);
}

void sheen_session_unstage(sheen_session *staged)
{
    sheen_session_release(staged);
    if (staged->path[0])
        sheen_dir_remove(staged->path, NULL); // what stays means nothing and goes with the next commit
    staged->path[0] = 0;
}

// Renames one file of .commit/<folder> to its place. One that is gone was moved by another process.
static sheen_status move_file(const sheen_session *s, const char *from_dir, const char *folder,
                              const char *name, sheen_err *err)
{
    char from[SHEEN_PATH_MAX], to_dir[SHEEN_PATH_MAX], to[SHEEN_PATH_MAX];
    sheen_status st = sheen_path_join(from, from_dir, name, err);
    if (!st)
        st = sheen_path_join(to_dir, s->path, folder, err);
    if (!st && *folder)
        st = sheen_dir_make(to_dir, err);
    if (!st)
        st = sheen_path_join(to, to_dir, name, err);
    if (st)
        return st;
    if (rename(from, to) && errno != ENOENT)
        return sheen_fail(err, SHEEN_EIO, "cannot move '%s' to its place: %s", from, strerror(errno));
    return SHEEN_OK;
}

// Moves the files of .commit/<folder>, but for those with the ending `later` (NULL: all).
static sheen_status move_files(const sheen_session *s, const char *folder, const char *later, sheen_err *err)
{
    char commit[SHEEN_PATH_MAX], dir[SHEEN_PATH_MAX];
    sheen_names names;
    sheen_status st = sheen_session_path(commit, s, COMMIT, err);
    if (!st)
        st = sheen_path_join(dir, commit, folder, err);
    if (st || !sheen_dir_exists(dir))
        return st;
    st = sheen_dir_list(&names, dir, NULL, err);
    if (st)
        return st;
    for (size_t i = 0; !st && i < names.count; i++) {
        char path[SHEEN_PATH_MAX];
        if (later && !strcmp(sheen_path_extension(names.names[i]), later))
            continue;
        st = sheen_path_join(path, dir, names.names[i], err);
        if (!st && sheen_file_exists(path))
            st = move_file(s, dir, folder, names.names[i], err);
    }
    sheen_names_release(&names);
    sync_dir(s, folder);
    return st;
}

// A session has one mesh: before a new one takes its place, those of other types go.
static sheen_status drop_old_mesh(const sheen_session *s, sheen_err *err)
{
    sheen_session commit = {0};
    sheen_status st = sheen_session_path(commit.path, s, COMMIT, err);
    const char *fresh = st ? NULL : sheen_session_mesh_file(&commit);
    if (!fresh)
        return st;
    for (const char *const *f = sheen_session_mesh_files; !st && *f; f++) {
        char path[SHEEN_PATH_MAX];
        st = sheen_session_path(path, s, *f, err);
        if (!st && strcmp(*f, fresh) != 0)
            st = sheen_file_remove(path, err);
    }
    return st;
}

sheen_status sheen_session_roll_forward(const sheen_session *s, sheen_err *err)
{
    char commit[SHEEN_PATH_MAX];
    sheen_status st = sheen_session_path(commit, s, COMMIT, err);
    if (st || !sheen_dir_exists(commit))
        return st;
    st = move_files(s, SHEEN_SESSION_MASKS, NULL, err);
    if (!st)
        st = move_files(s, SHEEN_SESSION_HIGHLIGHTS, NULL, err);
    if (!st)
        st = move_files(s, SHEEN_SESSION_FRAMES, "json", err);
    if (!st)
        st = move_files(s, SHEEN_SESSION_FRAMES, NULL, err);
    if (!st)
        st = drop_old_mesh(s, err);
    if (!st)
        st = move_files(s, "", NULL, err);
    if (!st)
        st = sheen_dir_remove(commit, err);
    return st ? sheen_wrap(err, st, "an import was interrupted and cannot be completed") : SHEEN_OK;
}

sheen_status sheen_session_commit(sheen_session *s, sheen_session *staged, sheen_err *err)
{
    char commit[SHEEN_PATH_MAX];
    sheen_status st = sheen_session_path(commit, s, COMMIT, err);
    if (!st)
        st = sheen_session_roll_forward(s, err); // of another process
    sync_dir(staged, "");
    if (!st)
        st = sheen_dir_replace(commit, staged->path, err);
    if (st) {
        sheen_session_unstage(staged);
        return st;
    }
    sheen_session_release(staged);
    staged->path[0] = 0;
    st = sheen_session_roll_forward(s, err);
    if (st)
        return st;
    char path[SHEEN_PATH_MAX];
    memcpy(path, s->path, sizeof path);
    sheen_session_release(s);
    return sheen_session_open(s, path, err);
}
