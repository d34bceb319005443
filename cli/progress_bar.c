// SPDX-License-Identifier: Apache-2.0
// progress_bar.c - progress on stderr: a bar with the time left on a terminal, sparse lines elsewhere; and SIGINT.
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"

static volatile sig_atomic_t interrupted;

static void on_interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

void sheen_cli_catch_interrupt(void)
{
    struct sigaction action = {.sa_flags = (int)SA_RESETHAND}; // the second one kills; sessions bear that
    action.sa_handler = on_interrupt;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    // A film's encoder or a pager that goes away is a failed write, not our death.
    signal(SIGPIPE, SIG_IGN);
}

bool sheen_cli_interrupted(void)
{
    return interrupted;
}

void sheen_cli_clear_bar(sheen_cli *cli)
{
    if (cli->bar_shown) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
    }
    cli->bar_shown = false;
}

static void format_left(char text[32], double left_s)
{
    if (left_s < 90)
        snprintf(text, 32, "%.0f s left", left_s);
    else
        snprintf(text, 32, "%.0f min left", left_s / 60);
}

static void draw_bar(sheen_cli *cli, int done, int total, double elapsed_s)
{
    enum { WIDTH = 30 };
    char bar[WIDTH + 1], left[32] = "";
    const int filled = total > 0 ? (int)((double)done / total * WIDTH) : 0;
    memset(bar, '.', WIDTH);
    memset(bar, '#', (size_t)(filled < WIDTH ? filled : WIDTH));
    bar[WIDTH] = 0;
    if (total > 0 && done > 0 && done < total && elapsed_s > 0.5)
        format_left(left, elapsed_s / done * (total - done));
    if (total > 0)
        fprintf(stderr, "\r\033[K%-24s [%s] %3.0f %%  %s", cli->what, bar, 100.0 * done / total, left);
    else
        fprintf(stderr, "\r\033[K%-24s %d", cli->what, done);
    fflush(stderr);
    cli->bar_shown = true;
}

static void print_line(const sheen_cli *cli, int done, int total)
{
    if (total > 0)
        fprintf(stderr, "%s: %d of %d\n", cli->what, done, total);
    else
        fprintf(stderr, "%s: %d\n", cli->what, done);
}

static bool on_step(void *self, const char *what, int done, int total)
{
    sheen_cli *cli = self;
    if (interrupted)
        return false;
    if (cli->json)
        return true;
    const double now_s = sheen_stopwatch_now().wall_s;
    const bool begins = strcmp(cli->what, what) != 0;
    if (begins) {
        snprintf(cli->what, sizeof cli->what, "%s", what);
        cli->what_since_s = now_s;
    }
    // A bar moves ten times a second; a line is printed when a step has been going for a second, then each second.
    const double pause_s = cli->terminal ? 0.1 : 1.0;
    if (begins && !cli->terminal)
        cli->shown_at_s = now_s;
    else if (begins || now_s - cli->shown_at_s >= pause_s) {
        cli->shown_at_s = now_s;
        if (cli->terminal)
            draw_bar(cli, done, total, now_s - cli->what_since_s);
        else
            print_line(cli, done, total);
    }
    if (done == total)
        sheen_cli_clear_bar(cli);
    return true;
}

void sheen_cli_add_timing(sheen_cli *cli, const char *what, double wall_s, double cpu_s)
{
    char name[sizeof cli->times->what];
    snprintf(name, sizeof name, "%.20s%s%.40s", cli->stage, *cli->stage ? ": " : "", what);
    size_t i = 0;
    while (i < cli->n_times && strcmp(cli->times[i].what, name) != 0)
        i++;
    if (i == SHEEN_CLI_MAX_TIMINGS)
        return;
    if (i == cli->n_times) {
        cli->n_times++;
        memcpy(cli->times[i].what, name, sizeof name);
    }
    cli->times[i].wall_s += wall_s;
    cli->times[i].cpu_s += cpu_s;
}

static void on_timed(void *self, const char *what, double wall_s, double cpu_s)
{
    sheen_cli_add_timing(self, what, wall_s, cpu_s);
}

sheen_progress sheen_cli_progress(sheen_cli *cli)
{
    cli->terminal = isatty(STDERR_FILENO);
    cli->what[0] = 0;
    return (sheen_progress){.step = on_step, .timed = on_timed, .self = cli};
}
