// SPDX-License-Identifier: Apache-2.0
// test_parallel.c - every index exactly once, for any number of threads; nested loops; progress and quiet.
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/parallel.h"
#include "base/progress.h"
#include "base/quiet.h"
#include "support.h"

enum { N = 10007 };

static void count(void *self, size_t begin, size_t end)
{
    unsigned char *seen = self;
    for (size_t i = begin; i < end; i++)
        seen[i]++;
}

static void every_index_once(void **state)
{
    (void)state;
    static unsigned char seen[N];
    for (int threads = 0; threads < 6; threads++)
        for (size_t grain = 0; grain < 300; grain += 99) {
            memset(seen, 0, sizeof seen);
            sheen_parallel_for(N, grain, threads, count, seen);
            for (int i = 0; i < N; i++)
                assert_int_equal(seen[i], 1);
        }
    sheen_parallel_for(0, 16, 4, count, NULL); // nothing to do, nothing called
    assert_true(sheen_cpu_count() >= 1);
}

static bool three_steps(void *self, const char *what, int done, int total)
{
    (void)what;
    assert_int_equal(total, 9);
    *(int *)self += 1;
    return done < 3;
}

static void progress_counts_and_cancels(void **state)
{
    (void)state;
    int n = 0;
    sheen_err err;
    const sheen_progress p = {.step = three_steps, .self = &n}, silent = {0};
    for (int i = 0; i < 3; i++)
        assert_ok(sheen_progress_step(&p, "work", i, 9, &err), err);
    assert_fails(sheen_progress_step(&p, "work", 3, 9, &err), err, SHEEN_ECANCEL, "cancelled during 'work'");
    assert_int_equal(n, 4);
    assert_ok(sheen_progress_step(&silent, "work", 3, 9, &err), err);
    assert_ok(sheen_progress_step(NULL, "work", 3, 9, &err), err);
}

static void note(void *self, const char *what, double wall_s, double cpu_s)
{
    assert_string_equal(what, "part");
    assert_true(wall_s >= 0 && cpu_s >= 0);
    *(int *)self += 1;
}

static void timed_parts_are_reported(void **state)
{
    (void)state;
    int n = 0;
    const sheen_progress p = {.timed = note, .self = &n};
    sheen_stopwatch watch = sheen_stopwatch_now();
    sheen_progress_timed(&p, "part", &watch);
    sheen_progress_timed(NULL, "part", &watch);
    assert_int_equal(n, 1);
}

// What is written to stderr inside the span does not come out; what follows does.
static void quiet_is_quiet_and_ends(void **state)
{
    (void)state;
    int ends[2];
    char text[64] = "";
    assert_int_equal(pipe(ends), 0);
    const int saved = dup(STDERR_FILENO);
    dup2(ends[1], STDERR_FILENO);
    const int token = sheen_quiet_begin();
    fprintf(stderr, "chatter");
    sheen_quiet_end(token);
    fprintf(stderr, "said");
    fflush(stderr);
    dup2(saved, STDERR_FILENO);
    close(saved);
    close(ends[1]);
    assert_int_equal(read(ends[0], text, sizeof text - 1), 4);
    assert_string_equal(text, "said");
    close(ends[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_index_once),
        cmocka_unit_test(progress_counts_and_cancels),
        cmocka_unit_test(timed_parts_are_reported),
        cmocka_unit_test(quiet_is_quiet_and_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
