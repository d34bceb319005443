// SPDX-License-Identifier: Apache-2.0
// serve_here.c - the server's loop, and the person's browser.
#include "cli/serve_here.h"

#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

extern char **environ;

enum { WAIT_MS = 250 };

// The person's own browser; where there is none the address was said.
static void open_browser(const char *address)
{
    char program[] = "xdg-open", where[128];
    char *const args[] = {program, where, NULL};
    posix_spawn_file_actions_t quiet;
    pid_t child;
    snprintf(where, sizeof where, "%s", address);
    if (posix_spawn_file_actions_init(&quiet))
        return;
    if (!posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", O_WRONLY, 0) &&
        !posix_spawn_file_actions_adddup2(&quiet, STDOUT_FILENO, STDERR_FILENO))
        (void)posix_spawnp(&child, program, &quiet, NULL, args, environ);
    posix_spawn_file_actions_destroy(&quiet);
}

sheen_status sheen_cli_serve(sheen_cli *cli, sheen_answering answering, void *self,
                             const sheen_serve_options *options, sheen_err *err)
{
    sheen_server *server;
    const sheen_status st = sheen_server_open(&server, options->port, answering, self, err);
    if (st)
        return st;
    sheen_cli_say(cli, "%s", sheen_server_address(server));
    sheen_cli_say(cli, "for this machine only, until Ctrl-C");
    fflush(stdout);
    if (!options->stay)
        open_browser(sheen_server_address(server));
    while (!sheen_cli_interrupted())
        sheen_server_wait(server, WAIT_MS);
    sheen_server_close(&server);
    return SHEEN_OK;
}
