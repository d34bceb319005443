// SPDX-License-Identifier: Apache-2.0
// help.c - a command's help, made from its option table.
#include <stdio.h>
#include <string.h>

#include "cli/cli.h"

const sheen_option sheen_cli_common_options[SHEEN_CLI_N_COMMON + 1] = {
    {"json", 0, SHEEN_OPTION_FLAG, NULL, NULL, "the answer as one JSON object", 0, 0},
    {"timings", 0, SHEEN_OPTION_FLAG, NULL, NULL, "a table of the steps and the time that each took", 0, 0},
    {"help", 'h', SHEEN_OPTION_FLAG, NULL, NULL, "this text", 0, 0},
    {0},
};

// "  -o, --output FILE", and the text from column 28 on; its own line breaks are kept.
static void print_option(const sheen_option *o)
{
    enum { COLUMN = 28 };
    char left[80];
    if (o->letter)
        snprintf(left, sizeof left, "  -%c, --%s%s%s", o->letter, o->name, o->arg ? " " : "",
                 o->arg ? o->arg : "");
    else
        snprintf(left, sizeof left, "  --%s%s%s", o->name, o->arg ? " " : "", o->arg ? o->arg : "");
    printf("%-*s", COLUMN, left);
    if (strlen(left) >= COLUMN)
        printf("\n%*s", COLUMN, "");
    for (const char *line = o->help; line;) {
        const size_t n = strcspn(line, "\n");
        printf("%.*s\n", (int)n, line);
        line = line[n] ? line + n + 1 : NULL;
        if (line)
            printf("%*s", COLUMN, "");
    }
}

void sheen_cli_help(const sheen_command *command, const sheen_option *options)
{
    printf("sheen %s - %s\n\nusage: sheen %s %s\n\n%s\noptions:\n", command->name, command->summary,
           command->name, command->synopsis, command->about);
    for (; options && options->name; options++)
        print_option(options);
    for (const sheen_option *o = sheen_cli_common_options; o->name; o++)
        print_option(o);
    printf("\nexample:\n%s", command->example);
}
