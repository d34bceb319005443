// SPDX-License-Identifier: Apache-2.0
// lens_model.h - which lens models one can calibrate, and how each is begun.
#ifndef SHEEN_CALIB_LENS_MODEL_H
#define SHEEN_CALIB_LENS_MODEL_H

#include <stdbool.h>

#include "base/camera.h"

typedef struct sheen_lens_model {
    const char *name;     // "opencv8": as on the command line
    const char *begun_as; // mrcal's name of the model in which poses and core are found
    int n_begun;          // its parameters
    bool splined;         // ends as a splined stereographic model
} sheen_lens_model;

enum { SHEEN_LENS_MODELS = 5 };
extern const sheen_lens_model sheen_lens_models[SHEEN_LENS_MODELS]; // from few parameters to many

// By its name, short ("opencv8", "splined") or mrcal's ("LENSMODEL_OPENCV8"); NULL: opencv8. EARG.
sheen_status sheen_lens_model_find(const sheen_lens_model **out, const char *name, sheen_err *err);
// Turns a stereographic camera into a splined one that sees the same: cubic, about 14 knots across the image and
// one beyond each edge.
void sheen_lens_spline(sheen_camera *camera);

#endif
