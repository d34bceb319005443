// SPDX-License-Identifier: Apache-2.0
// fuzz_register_points.c - any bytes as marks of a mesh in frames.
#include <math.h>
#include <stdlib.h>

#include "pose/register_points.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_register_point *points;
    size_t n;
    if (sheen_register_points_parse(&points, &n, data, size_bytes, NULL))
        return 0;
    for (size_t i = 0; i < n; i++)
        if (!points[i].frame[0] || !isfinite(points[i].q_px[0] + points[i].q_px[1] + points[i].p_obj[2]))
            abort();
    free(points);
    return 0;
}
