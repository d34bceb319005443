// SPDX-License-Identifier: Apache-2.0
// v4l2_holder.c - which program has a file open, by looking through /proc/<pid>/fd.
#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "capture/v4l2_error.h"

static bool is_number(const char *name)
{
    return *name && strspn(name, "0123456789") == strlen(name);
}

// True where one of the process's descriptors leads to the file.
static bool holds(const char *proc, const char *pid, const struct stat *file)
{
    char dir[SHEEN_PATH_MAX], link[SHEEN_PATH_MAX];
    bool found = false;
    if (snprintf(dir, sizeof dir, "%.1000s/%.20s/fd", proc, pid) >= (int)sizeof dir)
        return false;
    DIR *fds = opendir(dir);
    if (!fds)
        return false; // another user's, or ended meanwhile
    for (const struct dirent *e = readdir(fds); e && !found; e = readdir(fds)) {
        struct stat target;
        found = !sheen_path_join(link, dir, e->d_name, NULL) && !stat(link, &target) &&
                target.st_dev == file->st_dev && target.st_ino == file->st_ino;
    }
    closedir(fds);
    return found;
}

static void name_of(char name[64], const char *proc, const char *pid)
{
    char path[SHEEN_PATH_MAX];
    snprintf(name, 64, "a program");
    snprintf(path, sizeof path, "%.1000s/%.20s/comm", proc, pid);
    FILE *f = fopen(path, "r");
    if (!f)
        return;
    char line[64];
    if (fgets(line, sizeof line, f) && line[0] != '\n') {
        line[strcspn(line, "\n")] = 0;
        memcpy(name, line, sizeof line);
    }
    fclose(f);
}

void sheen_v4l2_holder(char *out, size_t size_bytes, const char *path, const char *proc)
{
    char self[24], name[64];
    out[0] = 0;
    snprintf(self, sizeof self, "%ld", (long)getpid());
    struct stat file;
    DIR *processes = stat(path, &file) ? NULL : opendir(proc);
    if (!processes)
        return;
    for (const struct dirent *e = readdir(processes); e; e = readdir(processes))
        if (is_number(e->d_name) && strcmp(e->d_name, self) != 0 && holds(proc, e->d_name, &file)) {
            name_of(name, proc, e->d_name);
            snprintf(out, size_bytes, "%s (process %.20s)", name, e->d_name);
            break;
        }
    closedir(processes);
}
