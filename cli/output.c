// SPDX-License-Identifier: Apache-2.0
// output.c - what the program prints: lines for a person, one JSON object for a program, the error's sentence.
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"

void sheen_cli_say(const sheen_cli *cli, const char *fmt, ...)
{
    if (cli->json)
        return;
    va_list args;
    va_start(args, fmt);
    vprintf(fmt, args);
    va_end(args);
    putchar('\n');
}

void sheen_cli_warn(sheen_cli *cli, const char *fmt, ...)
{
    sheen_cli_clear_bar(cli);
    fflush(stdout);
    fputs("sheen: ", stderr);
    va_list args;
    va_start(args, fmt);
    vfprintf(stderr, fmt, args);
    va_end(args);
    fputc('\n', stderr);
}

const char *sheen_cli_plural(size_t n)
{
    return n == 1 ? "" : "s";
}

static const char *code_name(sheen_status s)
{
    static const char *const names[] = {
#define X(code, text) #code,
        SHEEN_STATUS_LIST(X)
#undef X
    };
    return (size_t)s < sizeof names / sizeof *names ? names[s] : "UNKNOWN";
}

static void put_timings(sheen_cli *cli)
{
    sheen_json_open(&cli->out, "timings", '[');
    for (size_t i = 0; i < cli->n_times; i++) {
        sheen_json_open(&cli->out, NULL, '{');
        sheen_json_put_string(&cli->out, "step", cli->times[i].what);
        sheen_json_put_number(&cli->out, "wall_s", cli->times[i].wall_s);
        sheen_json_put_number(&cli->out, "cpu_s", cli->times[i].cpu_s);
        sheen_json_close(&cli->out);
    }
    sheen_json_close(&cli->out);
}

static void print_timings(const sheen_cli *cli)
{
    printf("\n%-44s %9s %9s\n", "step", "wall s", "cpu s");
    for (size_t i = 0; i < cli->n_times; i++)
        printf("%-44s %9.2f %9.2f\n", cli->times[i].what, cli->times[i].wall_s, cli->times[i].cpu_s);
}

static void print_json(sheen_cli *cli, sheen_status s, const sheen_err *err)
{
    if (s) {
        sheen_json_writer_release(&cli->out); // half an answer is none
        sheen_json_open(&cli->out, NULL, '{');
        sheen_json_open(&cli->out, "error", '{');
        sheen_json_put_string(&cli->out, "code", cli->wrong_usage ? "EUSAGE" : code_name(s));
        sheen_json_put_string(&cli->out, "message", err->msg);
        sheen_json_close(&cli->out);
    }
    if (cli->timings)
        put_timings(cli);
    sheen_json_close(&cli->out);
    const char *text = sheen_json_text(&cli->out);
    puts(text ? text : "{\"error\": {\"code\": \"ENOMEM\", \"message\": \"out of memory\"}}");
}

int sheen_cli_finish(sheen_cli *cli, sheen_status s, const sheen_err *err)
{
    sheen_cli_clear_bar(cli);
    int code = !s                 ? (cli->limit_missed ? SHEEN_EXIT_LIMIT : SHEEN_EXIT_DONE)
               : cli->wrong_usage ? SHEEN_EXIT_USAGE
                                  : SHEEN_EXIT_FAILED;
    if (cli->json && !cli->wants_help)
        print_json(cli, s, err);
    else if (cli->timings && cli->n_times)
        print_timings(cli);
    if (s)
        sheen_cli_warn(cli, "%s", err->msg);
    if ((fflush(stdout) || ferror(stdout)) && code == SHEEN_EXIT_DONE) {
        sheen_cli_warn(cli, "cannot write the answer: %s", strerror(errno));
        code = SHEEN_EXIT_FAILED;
    }
    sheen_json_writer_release(&cli->out);
    free(cli->args);
    return code;
}
