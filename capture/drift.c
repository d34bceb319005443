// SPDX-License-Identifier: Apache-2.0
// drift.c - compares the white of frames with that of the first: its brightness, and its colour for itself.
#include "capture/drift.h"

#include <math.h>
#include <string.h>

static const float max_brighter = 1.25f, max_colour = 1.06f;

sheen_status sheen_drift_check(sheen_drift *d, const float white_rgb[3], sheen_err *err)
{
    float ratio[3], product = 1;
    if (!d->begun) {
        d->begun = true;
        memcpy(d->rgb, white_rgb, sizeof d->rgb);
    }
    for (int c = 0; c < 3; c++) {
        ratio[c] = fmaxf(white_rgb[c], 1e-4f) / fmaxf(d->rgb[c], 1e-4f);
        product *= ratio[c];
    }
    const float brightness = cbrtf(product);
    if (brightness > max_brighter || brightness < 1 / max_brighter)
        return sheen_fail(
            err, SHEEN_EDATA,
            "the light has changed: the board's white is %.0f %% %s than in the first frame; put the "
            "lights back as they were, or begin a new session",
            100 * fabs((double)brightness - 1), brightness > 1 ? "brighter" : "darker");
    static const char *const names[] = {"red", "green", "blue"};
    for (int c = 0; c < 3; c++)
        if (ratio[c] / brightness > max_colour || ratio[c] / brightness < 1 / max_colour)
            return sheen_fail(
                err, SHEEN_EDATA,
                "the light's colour has changed: %s of the board's white is off by %.0f %%; look for a "
                "white balance that moves, or daylight that comes in",
                names[c], 100 * fabs((double)(ratio[c] / brightness) - 1));
    return SHEEN_OK;
}
