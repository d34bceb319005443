// SPDX-License-Identifier: Apache-2.0
// cmd.h - what a command is. To add one: a file cmd_<name>.c with a sheen_command, and a line in commands.c.
//
// A command's `run` declares its options in a table that points at its own variables, calls
// sheen_cli_parse, does its work through the libraries, says the result with sheen_cli_say, and puts the same
// facts into cli->out for --json. It returns a status; main.c turns that into the sentence and the exit code.
#ifndef SHEEN_CLI_CMD_H
#define SHEEN_CLI_CMD_H

#include <stdbool.h>

#include "base/status.h"

struct sheen_cli;

typedef struct sheen_command {
    const char *name;     // the verb
    const char *synopsis; // what follows "sheen <name> "
    const char *summary;  // one line, for the list of commands
    const char *about;    // a few lines, for its own help; each ends with a newline
    const char *example;  // lines that work as they stand, each ending with a newline
    sheen_status (*run)(struct sheen_cli *cli, sheen_err *err);
} sheen_command;

typedef enum sheen_option_kind {
    SHEEN_OPTION_FLAG,   // bool
    SHEEN_OPTION_TEXT,   // const char *
    SHEEN_OPTION_INT,    // int, min to max
    SHEEN_OPTION_NUMBER, // double, min to max
    SHEEN_OPTION_SIZE,   // int[2]: WIDTHxHEIGHT, each min to max
} sheen_option_kind;

// One row of a command's table; a row without a name ends it.
typedef struct sheen_option {
    const char *name; // "camera" is --camera
    char letter;      // 'o' is -o; 0: none
    sheen_option_kind kind;
    void *target;    // the variable; keeps its value where the option is not given
    const char *arg; // what the help calls its value: "FILE"
    const char *help;
    double min, max;
} sheen_option;

extern const sheen_command *const sheen_commands[]; // ends with NULL; commands.c

#endif
