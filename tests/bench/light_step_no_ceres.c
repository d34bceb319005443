// SPDX-License-Identifier: Apache-2.0
// light_step_no_ceres.c - where Ceres is not installed.
#include "tests/bench/light_step.h"

int light_step_ceres(double *x, const light_step *p, int max_iterations)
{
    (void)x;
    (void)p;
    (void)max_iterations;
    return 0;
}
