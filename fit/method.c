// SPDX-License-Identifier: Apache-2.0
// method.c - names of the methods, and the call that runs one.
#include "fit/method.h"

#include <string.h>

#include "fit/refined.h"

static const char *const names[SHEEN_FIT_METHOD_COUNT] = {"paper", "refined"};

const char *sheen_fit_method_name(sheen_fit_method m)
{
    return names[m];
}

sheen_status sheen_fit_method_from_name(sheen_fit_method *out, const char *name, sheen_err *err)
{
    for (int i = 0; i < SHEEN_FIT_METHOD_COUNT; i++)
        if (!strcmp(name, names[i])) {
            *out = (sheen_fit_method)i;
            return SHEEN_OK;
        }
    return sheen_fail(err, SHEEN_EARG, "unknown method '%.40s': use 'paper' or 'refined'", name);
}

sheen_status sheen_fit_make(sheen_paper_fit *out, sheen_fit_method method, sheen_moving moving,
                            const sheen_mesh *mesh, sheen_photos *photos, const sheen_paper_options *options,
                            sheen_err *err)
{
    if (method == SHEEN_FIT_REFINED && moving != SHEEN_MOVING_CAMERA) {
        *out = (sheen_paper_fit){0};
        return sheen_fail(err, SHEEN_EUNSUP,
                          "the refined method wants a camera that moved about an object that stood "
                          "still: use --method paper");
    }
    sheen_status s = sheen_paper_fit_make(out, mesh, photos, options, err);
    if (s || method == SHEEN_FIT_PAPER)
        return s;
    if ((s = sheen_refined_fit(out, mesh, photos, options, err)))
        sheen_paper_fit_release(out);
    return s;
}
