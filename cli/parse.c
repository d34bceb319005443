// SPDX-License-Identifier: Apache-2.0
// parse.c - reads a command line by a table: --name VALUE, --name=VALUE, -o VALUE, --; options and arguments in any order.
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"

enum { MAX_OPTIONS = 48 };

sheen_status sheen_cli_usage(sheen_cli *cli, sheen_err *err, const char *fmt, ...)
{
    char text[400];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    cli->wrong_usage = true;
    return sheen_fail(err, SHEEN_EARG, "%s (see 'sheen %s --help')", text, cli->command->name);
}

sheen_status sheen_cli_option_status(sheen_cli *cli, sheen_status s)
{
    cli->wrong_usage = cli->wrong_usage || s;
    return s;
}

static const sheen_option *find_long(const sheen_option *options, const char *name, size_t n)
{
    for (; options->name; options++)
        if (!strncmp(options->name, name, n) && !options->name[n])
            return options;
    return NULL;
}

static const sheen_option *find_letter(const sheen_option *options, char letter)
{
    for (; options->name; options++)
        if (letter && options->letter == letter)
            return options;
    return NULL;
}

static bool read_number(double *out, const char *text)
{
    char *end;
    const double x = strtod(text, &end);
    if (end == text || *end || !isfinite(x))
        return false;
    *out = x;
    return true;
}

static bool in_range(const sheen_option *o, double x)
{
    return x >= o->min && x <= o->max;
}

static bool read_size(const sheen_option *o, const char *text)
{
    char *end;
    const long w = strtol(text, &end, 10);
    if (end == text || *end != 'x')
        return false;
    const char *second = end + 1;
    const long h = strtol(second, &end, 10);
    if (end == second || *end || !in_range(o, (double)w) || !in_range(o, (double)h))
        return false;
    int *size = o->target;
    size[0] = (int)w;
    size[1] = (int)h;
    return true;
}

static sheen_status set_value(sheen_cli *cli, const sheen_option *o, const char *text, sheen_err *err)
{
    double x;
    switch (o->kind) {
    case SHEEN_OPTION_FLAG:
        *(bool *)o->target = true;
        return SHEEN_OK;
    case SHEEN_OPTION_TEXT:
        *(const char **)o->target = text;
        return *text ? SHEEN_OK : sheen_cli_usage(cli, err, "'--%s' wants its %s", o->name, o->arg);
    case SHEEN_OPTION_INT:
        if (!read_number(&x, text) || floor(x) != x || !in_range(o, x))
            return sheen_cli_usage(cli, err, "'--%s' wants a whole number from %.0f to %.0f, not '%.60s'",
                                   o->name, o->min, o->max, text);
        *(int *)o->target = (int)x;
        return SHEEN_OK;
    case SHEEN_OPTION_NUMBER:
        if (!read_number(&x, text) || !in_range(o, x))
            return sheen_cli_usage(cli, err, "'--%s' wants a number from %g to %g, not '%.60s'", o->name,
                                   o->min, o->max, text);
        *(double *)o->target = x;
        return SHEEN_OK;
    case SHEEN_OPTION_SIZE:
        return read_size(o, text) ? SHEEN_OK
                                  : sheen_cli_usage(cli, err,
                                                    "'--%s' wants a size such as 1280x960, each side %.0f to "
                                                    "%.0f, not '%.60s'",
                                                    o->name, o->min, o->max, text);
    }
    return SHEEN_OK;
}

static sheen_status unknown_option(sheen_cli *cli, const sheen_option *options, const char *text, size_t n,
                                   sheen_err *err)
{
    const char *names[MAX_OPTIONS + 1];
    char word[80];
    size_t n_names = 0;
    for (; options->name && n_names < MAX_OPTIONS; options++)
        names[n_names++] = options->name;
    names[n_names] = NULL;
    snprintf(word, sizeof word, "%.*s", (int)(n < 79 ? n : 79), text);
    const char *nearest = sheen_cli_nearest(word, names);
    if (nearest)
        return sheen_cli_usage(cli, err, "unknown option '--%s'; did you mean '--%s'?", word, nearest);
    return sheen_cli_usage(cli, err, "unknown option '--%s'", word);
}

// One option at argv[*i]; *i moves on over its value.
static sheen_status parse_option(sheen_cli *cli, const sheen_option *options, int *i, sheen_err *err)
{
    const char *word = cli->argv[*i], *value = NULL;
    const sheen_option *o;
    if (word[1] == '-') {
        const size_t n = strcspn(word + 2, "=");
        o = find_long(options, word + 2, n);
        if (!o)
            return unknown_option(cli, options, word + 2, n, err);
        if (word[2 + n])
            value = word + 3 + n;
    } else {
        o = find_letter(options, word[1]);
        if (!o)
            return sheen_cli_usage(cli, err, "unknown option '%.40s'", word);
        if (word[2])
            value = word + 2;
    }
    if (o->kind == SHEEN_OPTION_FLAG)
        return value ? sheen_cli_usage(cli, err, "'--%s' takes no value", o->name)
                     : set_value(cli, o, "", err);
    if (!value && *i + 1 < cli->argc)
        value = cli->argv[++*i];
    return value ? set_value(cli, o, value, err)
                 : sheen_cli_usage(cli, err, "'--%s' wants its %s", o->name, o->arg);
}

// The command's table and the common options in one.
static void join_tables(sheen_option out[MAX_OPTIONS + 1], sheen_cli *cli, const sheen_option *options)
{
    bool *const targets[SHEEN_CLI_N_COMMON] = {&cli->json, &cli->timings, &cli->wants_help};
    size_t n = 0;
    for (; options && options->name && n < MAX_OPTIONS - SHEEN_CLI_N_COMMON; options++)
        out[n++] = *options;
    for (size_t k = 0; k < SHEEN_CLI_N_COMMON; k++) {
        out[n] = sheen_cli_common_options[k];
        out[n++].target = targets[k];
    }
    out[n] = (sheen_option){0};
}

static bool is_option(const char *word)
{
    // "-12,30" is a value such as an angle, "-" a file
    return word[0] == '-' && word[1] && !strchr("0123456789.", word[1]);
}

sheen_status sheen_cli_parse(sheen_cli *cli, const sheen_option *options, size_t min_args, size_t max_args,
                             sheen_err *err)
{
    sheen_option all[MAX_OPTIONS + 1];
    bool only_args = false;
    join_tables(all, cli, options);
    cli->args = calloc((size_t)cli->argc + 1, sizeof *cli->args);
    if (!cli->args)
        return sheen_fail_memory(err, (double)cli->argc * sizeof *cli->args, "the command line");
    for (int i = 0; i < cli->argc; i++) {
        const char *word = cli->argv[i];
        if (!only_args && !strcmp(word, "--"))
            only_args = true;
        else if (!only_args && is_option(word)) {
            const sheen_status s = parse_option(cli, all, &i, err);
            if (s)
                return s;
        } else
            cli->args[cli->n_args++] = word;
    }
    if (cli->wants_help) {
        sheen_cli_help(cli->command, options);
        return SHEEN_OK;
    }
    if (cli->n_args < min_args)
        return sheen_cli_usage(cli, err, "an argument is missing: sheen %s %s", cli->command->name,
                               cli->command->synopsis);
    if (cli->n_args > max_args)
        return sheen_cli_usage(cli, err, "'%.100s' is one argument too many", cli->args[max_args]);
    return SHEEN_OK;
}
