// SPDX-License-Identifier: Apache-2.0
// metrics.c - PSNR over chosen pixels.
#include "fit/metrics.h"

#include <assert.h>
#include <math.h>

static double to_db(double sum, size_t n)
{
    return n ? -10 * log10(sum / (double)n) : (double)NAN;
}

static float clip(float x)
{
    return x > 0 ? x < 1 ? x : 1 : 0; // NaN becomes 0
}

sheen_psnr sheen_psnr_of(const sheen_image *rendered, const sheen_image *photo, const uint8_t *select)
{
    assert(rendered->width_px == photo->width_px && rendered->height_px == photo->height_px);
    assert(rendered->n_channels == 3 && photo->n_channels == 3);
    const size_t n = (size_t)photo->width_px * (size_t)photo->height_px;
    double linear = 0, coded = 0;
    size_t n_pixels = 0;
    for (size_t i = 0; i < n; i++) {
        if (select && !select[i])
            continue;
        n_pixels++;
        for (size_t c = 0; c < 3; c++) {
            const float a = clip(rendered->data[3 * i + c]), b = clip(photo->data[3 * i + c]);
            if (a == b)
                continue;
            const double d = (double)a - (double)b;
            const double e = (double)sheen_transfer_encode(SHEEN_TRANSFER_SRGB, a) -
                             (double)sheen_transfer_encode(SHEEN_TRANSFER_SRGB, b);
            linear += d * d;
            coded += e * e;
        }
    }
    return (sheen_psnr){to_db(linear, 3 * n_pixels), to_db(coded, 3 * n_pixels), n_pixels};
}
