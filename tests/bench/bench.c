// SPDX-License-Identifier: Apache-2.0
// bench.c - times a function.
#define _POSIX_C_SOURCE 200809L
#include "tests/bench/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MAX_RUNS = 1000 };

static volatile double kept;

void bench_keep(double x)
{
    kept = x;
}

static double now_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double best_of(clockid_t clock, const char *name, size_t n_items, int runs, void (*body)(void *self),
                      void *self)
{
    static double ns[MAX_RUNS];
    if (runs > MAX_RUNS)
        runs = MAX_RUNS;
    body(self); // warm
    for (int i = 0; i < runs; i++) {
        const double start_ns = now_ns(clock);
        body(self);
        ns[i] = (now_ns(clock) - start_ns) / (double)n_items;
    }
    qsort(ns, (size_t)runs, sizeof *ns, ascending);
    printf("%-44s %10.2f best %10.2f median ns an item (%zu items, %d runs)\n", name, ns[0], ns[runs / 2],
           n_items, runs);
    return ns[0];
}

double bench(const char *name, size_t n_items, int runs, void (*body)(void *self), void *self)
{
    return best_of(CLOCK_PROCESS_CPUTIME_ID, name, n_items, runs, body, self);
}

double bench_elapsed(const char *name, size_t n_items, int runs, void (*body)(void *self), void *self)
{
    return best_of(CLOCK_MONOTONIC, name, n_items, runs, body, self);
}
