// SPDX-License-Identifier: Apache-2.0
// table_arg.h - the turntable that a command line names: its file, the person's keys and Ctrl-C.
#ifndef SHEEN_CLI_TABLE_ARG_H
#define SHEEN_CLI_TABLE_ARG_H

#include "capture/turntable.h"
#include "cli/cli.h"

// Path of the turntable's file: the one given, else $XDG_CONFIG_HOME/sheen/turntable.json or ~/.config/sheen/turntable.json.
sheen_status sheen_cli_table_path(char path[SHEEN_PATH_MAX], const char *given, sheen_err *err);
// Reads the file (defaults where there is none and none was given) and opens the table. Ctrl-C stops it, and the key s where
// sheen_cli_keys_open was called.
// The person who turns a `manual:` table is asked on the terminal.
sheen_status sheen_cli_table_open(sheen_table **table, sheen_table_config *config, sheen_cli *cli,
                                  const char *device, const char *file, sheen_err *err);
// The same with direction 1 and no play, as the set-up wants it.
sheen_status sheen_cli_table_open_plain(sheen_table **table, sheen_table_config *config, sheen_cli *cli,
                                        const char *device, const char *file, sheen_err *err);

#endif
