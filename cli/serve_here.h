// SPDX-License-Identifier: Apache-2.0
// serve_here.h - a page for the person at this machine: served, said, opened in the browser, until Ctrl-C.
#ifndef SHEEN_CLI_SERVE_HERE_H
#define SHEEN_CLI_SERVE_HERE_H

#include <stdbool.h>

#include "cli/cli.h"
#include "cli/serve.h"

typedef struct sheen_serve_options {
    int port;  // 0: any that is free
    bool stay; // only say the address
} sheen_serve_options;

// Answers until the person interrupts, which is no error. What sheen_server_open fails with.
sheen_status sheen_cli_serve(sheen_cli *cli, sheen_answering answering, void *self,
                             const sheen_serve_options *options, sheen_err *err);

#endif
