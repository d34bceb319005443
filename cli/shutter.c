// SPDX-License-Identifier: Apache-2.0
// shutter.c - requests for frames from the keyboard and by signal, with the time of each.
#include "cli/shutter.h"

#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <time.h>
#include <unistd.h>

static _Atomic int64_t signalled_ns = -1;
static bool input_over, ended;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void on_signal(int number)
{
    (void)number;
    atomic_store(&signalled_ns, now_ns());
}

void sheen_cli_shutter_open(void)
{
    struct sigaction action = {0};
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGUSR1, &action, NULL);
}

// What was typed so far, without waiting. Only at a terminal does its end end the capture: a service has no input.
static bool read_enter(void)
{
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    bool enter = false;
    while (!input_over && poll(&input, 1, 0) > 0) {
        char c;
        const ssize_t n = read(STDIN_FILENO, &c, 1);
        if (n < 1) {
            input_over = true;
            ended = isatty(STDIN_FILENO);
        } else if (c == 'q')
            ended = true;
        else if (c == '\n')
            enter = true;
    }
    return enter;
}

int64_t sheen_cli_shutter(void)
{
    const int64_t by_signal_ns = atomic_exchange(&signalled_ns, -1);
    return read_enter() ? now_ns() : by_signal_ns;
}

sheen_status sheen_cli_shutter_ask(void *self, int64_t *since_ns, sheen_err *err)
{
    (void)self;
    *since_ns = sheen_cli_shutter();
    return ended ? sheen_fail(err, SHEEN_EEND, "the person has ended it") : SHEEN_OK;
}

bool sheen_cli_shutter_ended(void)
{
    return ended;
}
