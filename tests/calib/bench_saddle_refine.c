// SPDX-License-Identifier: Apache-2.0
// Time of one corner refinement (window 5 to each side), and of its slow twin.
#include <stdio.h>
#include <stdlib.h>

#include "base/progress.h"
#include "calib/saddle_refine.h"
#include "support.h"

enum { SIZE = 64, REPEATS = 2000, RUNS = 9 };

typedef sheen_status refine(double q_px[2], const uint8_t *grey, int width_px, int height_px, int half_px,
                            sheen_err *err);

static double best_ns(refine *f, const uint8_t *grey)
{
    double best = 1e30;
    for (int run = 0; run < RUNS; run++) {
        const double start_s = sheen_stopwatch_now().cpu_s;
        for (int i = 0; i < REPEATS; i++) {
            double q[2] = {31.2 + i % 7 * 0.1, 32.1};
            assert_int_equal(f(q, grey, SIZE, SIZE, 5, NULL), SHEEN_OK);
        }
        const double ns = (sheen_stopwatch_now().cpu_s - start_s) / REPEATS * 1e9;
        best = ns < best ? ns : best;
    }
    return best;
}

static void refines(void **state)
{
    (void)state;
    uint8_t grey[SIZE * SIZE];
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            const int edge = x < SIZE / 2 ? -1 : 1, other = y < SIZE / 2 ? -1 : 1;
            const int soft = x == SIZE / 2 || y == SIZE / 2;
            grey[y * SIZE + x] = (uint8_t)(soft ? 110 : 110 + 80 * edge * other);
        }
    printf("saddle_refine      %8.0f ns\n", best_ns(sheen_saddle_refine, grey));
    printf("saddle_refine_ref  %8.0f ns\n", best_ns(sheen_saddle_refine_ref, grey));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(refines)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
