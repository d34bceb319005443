// SPDX-License-Identifier: Apache-2.0
// cli.h - one run of the program: its arguments, its answer, its progress. What all commands share.
#ifndef SHEEN_CLI_CLI_H
#define SHEEN_CLI_CLI_H

#include <stdbool.h>
#include <stddef.h>

#include "base/json_write.h"
#include "base/progress.h"
#include "base/session.h"
#include "cli/cmd.h"

enum {
    SHEEN_EXIT_DONE = 0,
    SHEEN_EXIT_FAILED = 1,
    SHEEN_EXIT_USAGE = 2,
    SHEEN_EXIT_LIMIT = 3, // ran, but a stated quality limit was not met
};

enum { SHEEN_CLI_MAX_TIMINGS = 64 };

typedef struct sheen_cli_timing {
    char what[64];
    double wall_s, cpu_s;
} sheen_cli_timing;

typedef struct sheen_cli {
    const sheen_command *command;
    int argc;
    char **argv; // what follows the command's name
    // After sheen_cli_parse:
    const char **args; // what is not an option, n_args of them
    size_t n_args;
    bool json, timings, wants_help;
    bool wrong_usage;      // the error is the person's command line: exit code 2
    bool limit_missed;     // exit code 3
    sheen_json_writer out; // the answer of --json: an object, open
    // Progress (progress_bar.c).
    const char *stage; // put before the names of timings, "" for a single command
    char what[64];     // step being shown
    bool bar_shown, terminal;
    double what_since_s, shown_at_s;
    sheen_cli_timing times[SHEEN_CLI_MAX_TIMINGS];
    size_t n_times;
} sheen_cli;

// ---- parse.c

// Reads the command line by the table (and --json, --timings, --help, which every command has). min_args to max_args
// arguments must remain. On --help it prints the help and sets wants_help: return OK at once then.
sheen_status sheen_cli_parse(sheen_cli *cli, const sheen_option *options, size_t min_args, size_t max_args,
                             sheen_err *err);
// sheen_fail with EARG for a wrong command line.
sheen_status sheen_cli_usage(sheen_cli *cli, sheen_err *err, const char *fmt, ...) SHEEN_PRINTF(3, 4);
// Marks a failed conversion of an option's value as a wrong command line; passes the status on.
sheen_status sheen_cli_option_status(sheen_cli *cli, sheen_status s);

// ---- help.c

void sheen_cli_help(const sheen_command *command, const sheen_option *options);
enum { SHEEN_CLI_N_COMMON = 3 };
extern const sheen_option sheen_cli_common_options[SHEEN_CLI_N_COMMON + 1]; // their targets are NULL

// ---- nearest.c

// The candidate that the word was probably meant to be, or NULL. Candidates end with NULL.
const char *sheen_cli_nearest(const char *word, const char *const *candidates);

// ---- output.c

// A line of the answer for a person; nothing under --json.
void sheen_cli_say(const sheen_cli *cli, const char *fmt, ...) SHEEN_PRINTF(2, 3);
// A remark on stderr, "sheen: ..."; also under --json.
void sheen_cli_warn(sheen_cli *cli, const char *fmt, ...) SHEEN_PRINTF(2, 3);
// "" for 1, else "s".
const char *sheen_cli_plural(size_t n);
// Prints what is left to print (sentence, JSON, timings) and returns the exit code.
int sheen_cli_finish(sheen_cli *cli, sheen_status s, const sheen_err *err);

// ---- progress_bar.c

// SIGINT and SIGTERM from now on make progress callbacks ask for a stop; a second one kills.
void sheen_cli_catch_interrupt(void);
bool sheen_cli_interrupted(void);
// For a stage's options. A bar on a terminal, at most one plain line a second elsewhere, nothing under --json.
sheen_progress sheen_cli_progress(sheen_cli *cli);
// Takes the bar off the screen before anything else is printed.
void sheen_cli_clear_bar(sheen_cli *cli);
void sheen_cli_add_timing(sheen_cli *cli, const char *what, double wall_s, double cpu_s);

// ---- session_arg.c

// A session that a command may have to make, and can undo.
typedef struct sheen_cli_session {
    sheen_session session;
    bool fresh;     // was made by this command
    bool fresh_dir; // with its folder
} sheen_cli_session;

sheen_status sheen_cli_session_create(sheen_cli_session *s, const char *path, sheen_moving moving,
                                      sheen_err *err);
// Releases it; a failed command's fresh session is removed again where it is still empty.
void sheen_cli_session_close(sheen_cli_session *s, bool failed);

#endif
