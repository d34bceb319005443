// SPDX-License-Identifier: Apache-2.0
// evaluate.h - scores of a model, and of the baselines beside it, on photographs that the fit has not seen.
#ifndef SHEEN_FIT_EVALUATE_H
#define SHEEN_FIT_EVALUATE_H

#include "fit/baselines.h"
#include "fit/metrics.h"
#include "fit/photos.h"
#include "render/draw.h"

enum { SHEEN_EVALUATION_METHODS = 1 + SHEEN_BASELINE_COUNT };

// "sheen", then the baselines' names.
const char *sheen_evaluation_method_name(int method);

// One picture of one method. Object pixels: those that the mesh covers wholly in the view's pose.
typedef struct sheen_score {
    sheen_psnr object, highlights, frame; // frame: all pixels, the photograph's background kept in both
    sheen_orb orb;
    double hole_share; // of the object's pixels, shown as surface that no photograph saw
} sheen_score;

typedef struct sheen_evaluation {
    size_t n_views;
    char (*names)[64];                               // [n_views]
    sheen_score (*scores)[SHEEN_EVALUATION_METHODS]; // [n_views]
    int highlights_known; // 1: highlight pixels were given; 0: found in the photographs
} sheen_evaluation;

// Called with each method's picture of each view (lent, RGB linear, where the photograph's background is kept).
typedef void (*sheen_evaluation_picture)(void *self, const sheen_photo *photo, int method,
                                         const sheen_image *rendered, const uint8_t *object);

typedef struct sheen_evaluate_options {
    int n_threads;
    sheen_progress progress;
    sheen_evaluation_picture picture; // may be NULL
    void *picture_self;
} sheen_evaluate_options;

// Baselines take colours where no photograph saw the surface if the model does, so that none is worse for that alone.
// model: fitted to `inputs`; tests: other photographs, by the camera of `tests`. highlights[n] (or NULL): per test a mask of one
// channel, > 0.5 where the truth is known to be a highlight; an empty image where it is not given. Then highlight
// pixels are those where the photograph is brighter than the median texture, and all its neighbours, by 0.15 of white.
sheen_status sheen_evaluate(sheen_evaluation *out, const sheen_model *model, const sheen_photos *inputs,
                            const sheen_photos *tests, const sheen_image *highlights,
                            const sheen_evaluate_options *options, sheen_err *err);
void sheen_evaluation_release(sheen_evaluation *e);

// Adds the views of `more` to `into` (for folds) and leaves `more` empty. ENOMEM.
sheen_status sheen_evaluation_append(sheen_evaluation *into, sheen_evaluation *more, sheen_err *err);

// Mean over the views of a method's decibels (views where a figure does not exist are left out of it).
sheen_score sheen_evaluation_mean(const sheen_evaluation *e, int method);

#endif
