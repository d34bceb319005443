// SPDX-License-Identifier: Apache-2.0
// hook.c - runs a person's command beside a capture. A signal that ends the capture (Ctrl-C) reaches it, too.
#include "cli/hook.h"

#include <errno.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "base/file.h"

extern char **environ;

enum { MAX_ENVIRONMENT = 4096 };

// The environment with two more variables, which replace any of the same name.
static void extend(char *out[MAX_ENVIRONMENT + 1], char *action, char *argument)
{
    size_t n = 0;
    for (char **e = environ; *e && n < MAX_ENVIRONMENT - 2; e++)
        if (strncmp(*e, "ACTION=", 7) != 0 && strncmp(*e, "ARGUMENT=", 9) != 0)
            out[n++] = *e;
    out[n++] = action;
    out[n++] = argument;
    out[n] = NULL;
}

sheen_status sheen_cli_hook(const char *command, const char *action, const char *argument, sheen_err *err)
{
    char *environment[MAX_ENVIRONMENT + 1], action_is[64], argument_is[SHEEN_PATH_MAX + 16],
        line[SHEEN_PATH_MAX];
    char shell[] = "sh", option[] = "-c";
    pid_t pid;
    int how = 0;
    if (!command)
        return SHEEN_OK;
    if (snprintf(line, sizeof line, "%s", command) >= (int)sizeof line)
        return sheen_fail(err, SHEEN_EARG, "the hook's command is too long");
    snprintf(action_is, sizeof action_is, "ACTION=%s", action);
    snprintf(argument_is, sizeof argument_is, "ARGUMENT=%s", argument);
    extend(environment, action_is, argument_is);
    char *const argv[] = {shell, option, line, NULL};
    const int code = posix_spawn(&pid, "/bin/sh", NULL, NULL, argv, environment);
    if (code)
        return sheen_fail(err, SHEEN_EIO, "cannot run the hook '%.200s': %s", command, strerror(code));
    while (waitpid(pid, &how, 0) < 0)
        if (errno != EINTR)
            return sheen_fail(err, SHEEN_EIO, "cannot wait for the hook '%.200s'", command);
    if (WIFEXITED(how) && !WEXITSTATUS(how))
        return SHEEN_OK;
    return sheen_fail(err, SHEEN_EIO, "the hook '%.200s' failed at %s", command, action);
}

sheen_status sheen_cli_hook_frame(const char *command, const sheen_session *s, const sheen_frame_info *f,
                                  sheen_err *err)
{
    char file[160], path[SHEEN_PATH_MAX];
    snprintf(file, sizeof file, SHEEN_SESSION_FRAMES "/%s", f->file);
    const sheen_status st = sheen_session_path(path, s, file, err);
    return st ? st : sheen_cli_hook(command, "download", path, err);
}
