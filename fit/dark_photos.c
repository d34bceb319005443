// SPDX-License-Identifier: Apache-2.0
// dark_photos.c - compares the photographs' mean luminances.
#include "fit/dark_photos.h"

#include <stdlib.h>
#include <string.h>

static const double darkest_share = 1.0 / 128;
static const double black_lin = 1e-6; // far below one step of any file's codes

static double mean_luminance(const sheen_photo *p)
{
    const size_t n_px = (size_t)p->image.width_px * (size_t)p->image.height_px;
    double sum = 0;
    size_t n = 0;
    for (size_t i = 0; i < n_px; i++) {
        if (p->mask.data && p->mask.data[i] < 0.99f)
            continue;
        sum += (double)sheen_luminance(p->image.data + 3 * i);
        n++;
    }
    return n ? sum / (double)n : 0;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

sheen_status sheen_photos_leave_out_dark(sheen_photos *photos, sheen_err *err)
{
    const size_t n = photos->count;
    double *mean = malloc((2 * n + 1) * sizeof *mean);
    if (!mean)
        return sheen_fail_memory(err, 16.0 * (double)n, "photographs");
    double *sorted = mean + n;
    for (size_t i = 0; i < n; i++)
        sorted[i] = mean[i] = mean_luminance(&photos->photos[i]);
    qsort(sorted, n, sizeof *sorted, ascending);
    const double brightest = n ? sorted[n - 1] : 0, median = n ? sorted[n / 2] : 0;
    photos->count = 0;
    for (size_t i = 0; i < n; i++) {
        sheen_photo *p = &photos->photos[i];
        if (mean[i] >= darkest_share * median) {
            photos->photos[photos->count++] = *p;
            continue;
        }
        if (!photos->n_dark++)
            memcpy(photos->dark_name, p->name, sizeof photos->dark_name);
        sheen_image_release(&p->image);
        sheen_image_release(&p->mask);
    }
    free(mean);
    if (n && brightest < black_lin)
        return sheen_fail(err, SHEEN_EDATA,
                          "all photographs are black, '%s' among them: check the files and how they were "
                          "exposed",
                          photos->photos[0].name);
    return SHEEN_OK;
}
