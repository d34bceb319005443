// SPDX-License-Identifier: Apache-2.0
// lens_model.c - the table of lens models, and the start of a splined one.
#include "calib/lens_model.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { KNOTS_ACROSS = 16 };

static const double FIELD_MARGIN = 1.25; // of the angle: a barrel's corners see further than its core says
static const double MOST_DEG = 200;

const sheen_lens_model sheen_lens_models[SHEEN_LENS_MODELS] = {
    {"opencv4", "LENSMODEL_OPENCV4", 8, false},      {"opencv5", "LENSMODEL_OPENCV5", 9, false},
    {"cahvor", "LENSMODEL_CAHVOR", 9, false},        {"opencv8", "LENSMODEL_OPENCV8", 12, false},
    {"splined", "LENSMODEL_STEREOGRAPHIC", 4, true},
};

sheen_status sheen_lens_model_find(const sheen_lens_model **out, const char *name, sheen_err *err)
{
    if (!name)
        name = "opencv8";
    for (int i = 0; i < SHEEN_LENS_MODELS; i++) {
        const sheen_lens_model *m = &sheen_lens_models[i];
        if (!strcmp(name, m->name) || (!m->splined && !strcmp(name, m->begun_as)) ||
            (m->splined && !strncmp(name, "LENSMODEL_SPLINED", strlen("LENSMODEL_SPLINED")))) {
            *out = m;
            return SHEEN_OK;
        }
    }
    return sheen_fail(
        err, SHEEN_EARG,
        "cannot calibrate the lens model '%.80s': use opencv4, opencv5, opencv8, cahvor, splined "
        "or auto",
        name);
}

void sheen_lens_spline(sheen_camera *camera)
{
    // stereographic: r = 2 f tan(angle / 2)
    const double half_px = camera->width_px / 2.0;
    const double field_rad = 4 * atan(half_px / (2 * camera->intrinsics[0]));
    const double field_deg = fmin(MOST_DEG, FIELD_MARGIN * field_rad * 180 / acos(-1.0));
    const double aspect = (double)camera->height_px / camera->width_px;
    const int down = (int)fmax(6, round(KNOTS_ACROSS * aspect));
    snprintf(camera->lensmodel, sizeof camera->lensmodel,
             "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=%d_Ny=%d_fov_x_deg=%d", KNOTS_ACROSS, down,
             5 * (int)ceil(field_deg / 5));
    camera->n_intrinsics = 4 + 2 * KNOTS_ACROSS * down;
    memset(camera->intrinsics + 4, 0, (size_t)(camera->n_intrinsics - 4) * sizeof *camera->intrinsics);
}
