// SPDX-License-Identifier: Apache-2.0
// bench.h - times a function: best and median nanoseconds of processor time an item, over many runs.
//
// Processor time of the whole process, because other programs share the machine; the best run is the figure
// to compare, as nothing makes a run faster than the code is.
#ifndef SHEEN_TESTS_BENCH_H
#define SHEEN_TESTS_BENCH_H

#include <stddef.h>

// Runs body(self) at least `runs` times and prints one line: name, best and median ns an item. Returns the best.
double bench(const char *name, size_t n_items, int runs, void (*body)(void *self), void *self);

// The same by the clock on the wall, for what several threads do: means something on an idle machine only.
double bench_elapsed(const char *name, size_t n_items, int runs, void (*body)(void *self), void *self);

// Keeps a result alive so that the compiler does not drop the work.
void bench_keep(double x);

#endif
