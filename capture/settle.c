// SPDX-License-Identifier: Apache-2.0
// settle.c - brightness of frames and whether it still changes.
//
// The mean over the whole picture is little moved by a hand that holds the camera, and shows at once an exposure that
// lags, a white balance that drifts, and lamps that flicker.
#include "capture/settle.h"

#include <math.h>

static const float max_spread = 0.02f, dark = 0.002f; // of full scale: below it noise is all there is

static float sample(const sheen_raster *r, size_t at)
{
    if (r->bits == 8)
        return (float)((const uint8_t *)r->data)[at] / 255;
    return r->bits == 16 ? (float)((const uint16_t *)r->data)[at] / 65535 : ((const float *)r->data)[at];
}

void sheen_settle_mean(float rgb[3], const sheen_raster *r, sheen_transfer transfer)
{
    const int step = 1 + (int)sqrt((double)r->width_px * r->height_px / 1e4);
    double sum[3] = {0};
    size_t n = 0;
    for (int y = step / 2; y < r->height_px; y += step)
        for (int x = step / 2; x < r->width_px; x += step, n++)
            for (int c = 0; c < 3; c++) {
                const size_t px = (size_t)y * (size_t)r->width_px + (size_t)x;
                const size_t at = px * (size_t)r->n_channels + (size_t)(r->n_channels >= 3 ? c : 0);
                sum[c] += (double)sheen_transfer_decode(transfer, sample(r, at));
            }
    for (int c = 0; c < 3; c++)
        rgb[c] = n ? (float)(sum[c] / (double)n) : 0;
}

float sheen_settle_spread(const sheen_settle *s)
{
    const int n = s->n_frames < SHEEN_SETTLE_STILL ? s->n_frames : SHEEN_SETTLE_STILL;
    float spread = 0;
    for (int c = 0; n && c < 3; c++) {
        float least = s->rgb[0][c], most = least;
        for (int i = 1; i < n; i++) {
            least = fminf(least, s->rgb[i][c]);
            most = fmaxf(most, s->rgb[i][c]);
        }
        spread = fmaxf(spread, (most - least) / (most + dark));
    }
    return spread;
}

bool sheen_settle_add(sheen_settle *s, const float rgb[3])
{
    for (int c = 0; c < 3; c++)
        s->rgb[s->n_frames % SHEEN_SETTLE_STILL][c] = rgb[c];
    s->n_frames++;
    return s->n_frames >= SHEEN_SETTLE_MIN && sheen_settle_spread(s) < max_spread;
}
