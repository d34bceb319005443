// SPDX-License-Identifier: Apache-2.0
// main.c - the program: finds the command, runs it, turns its status into an exit code.
#include <stdio.h>
#include <string.h>

#include "cli/cli.h"

static void print_usage(FILE *to)
{
    fputs("sheen - photographs of a shiny object into a model whose highlights move\n\n"
          "usage: sheen COMMAND [options]\n\n",
          to);
    for (const sheen_command *const *c = sheen_commands; *c; c++)
        fprintf(to, "  %-10s  %s\n", (*c)->name, (*c)->summary);
    fputs("\n"
          "  --version, --list-commands, --help\n\n"
          "'sheen COMMAND --help' explains a command. Exit codes: 0 done; 1 failed; 2 wrong usage;\n"
          "3 ran, but a stated quality limit was not met.\n",
          to);
}

static const sheen_command *find_command(const char *name)
{
    for (const sheen_command *const *c = sheen_commands; *c; c++)
        if (!strcmp((*c)->name, name))
            return *c;
    return NULL;
}

static int unknown_command(const char *word)
{
    const char *names[64];
    size_t n = 0;
    for (; n < 63 && sheen_commands[n]; n++)
        names[n] = sheen_commands[n]->name;
    names[n] = NULL;
    const char *nearest = sheen_cli_nearest(word, names);
    if (nearest)
        fprintf(stderr, "sheen: unknown command '%s'; did you mean '%s'?\n", word, nearest);
    else
        fprintf(stderr, "sheen: unknown command '%s' (see 'sheen --help')\n", word);
    return SHEEN_EXIT_USAGE;
}

// Options of the program itself; -1 where the word is none.
static int program_option(const char *word)
{
    if (!strcmp(word, "--version"))
        puts("sheen " SHEEN_VERSION);
    else if (!strcmp(word, "--help") || !strcmp(word, "-h") || !strcmp(word, "help"))
        print_usage(stdout);
    else if (!strcmp(word, "--list-commands"))
        for (const sheen_command *const *c = sheen_commands; *c; c++)
            puts((*c)->name);
    else
        return -1;
    return fflush(stdout) ? SHEEN_EXIT_FAILED : SHEEN_EXIT_DONE;
}

// --json before anything could be parsed: errors must come as JSON, too.
static bool asks_for_json(int argc, char **argv)
{
    for (int i = 0; i < argc; i++)
        if (!strcmp(argv[i], "--json"))
            return true;
    return false;
}

int main(int argc, char **argv)
{
    setvbuf(stdout, NULL, _IOLBF,
            0); // so that results and progress keep their order where both go to one place
    if (argc < 2) {
        print_usage(stderr);
        return SHEEN_EXIT_USAGE;
    }
    const int code = program_option(argv[1]);
    if (code >= 0)
        return code;
    const sheen_command *command = find_command(argv[1]);
    if (!command)
        return unknown_command(argv[1]);
    static sheen_cli cli;
    cli.command = command;
    cli.argc = argc - 2;
    cli.argv = argv + 2;
    cli.stage = "";
    cli.json = asks_for_json(cli.argc, cli.argv);
    sheen_err err = {0};
    sheen_cli_catch_interrupt();
    sheen_json_open(&cli.out, NULL, '{');
    const sheen_stopwatch start = sheen_stopwatch_now();
    const sheen_status s = command->run(&cli, &err);
    const sheen_stopwatch end = sheen_stopwatch_now();
    cli.stage = "";
    sheen_cli_add_timing(&cli, "all", end.wall_s - start.wall_s, end.cpu_s - start.cpu_s);
    return sheen_cli_finish(&cli, s, &err);
}
