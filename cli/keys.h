// SPDX-License-Identifier: Apache-2.0
// keys.h - single keys at a terminal while a turntable works, and whole lines in between.
//
//     p or space   pause before the next step; again: go on
//     q            end after the present step
//     s            stop at once, also in the middle of a move
//
// Where standard input is no terminal there are no keys; Ctrl-C works everywhere.
#ifndef SHEEN_CLI_KEYS_H
#define SHEEN_CLI_KEYS_H

#include <stdbool.h>
#include <stddef.h>

#include "cli/cli.h"

// From now on keys count without Enter. What was pressed before is forgotten.
void sheen_cli_keys_open(void);
// The terminal is again as it was found.
void sheen_cli_keys_close(void);

// True after s or Ctrl-C.
bool sheen_cli_keys_stopped(void);
// Between two steps: returns at once, or when a pause is over. ECANCEL: q, s or Ctrl-C.
sheen_status sheen_cli_keys_between(sheen_cli *cli, sheen_err *err);

// Asks for a line on stderr and waits for it; without its line feed, cut to size. ECANCEL: Ctrl-C or the end of the input.
sheen_status sheen_cli_ask(char *line, size_t size_bytes, sheen_cli *cli, const char *prompt, sheen_err *err);

#endif
