// SPDX-License-Identifier: Apache-2.0
// exact_score.h - how far a fitted model is from an exact scene.
#ifndef SHEEN_TESTS_FIT_EXACT_SCORE_H
#define SHEEN_TESTS_FIT_EXACT_SCORE_H

#include <stdio.h>

#include "render/model.h"
#include "tests/fit/exact_scene.h"

// PSNRs are means over the held-out views, over pixels that the object covers wholly and whose texels were seen.
typedef struct exact_score {
    double sigma_error;    // share of the truth; NaN for GGX, which has no sigma
    int n_found;           // lights with a counterpart: within 2 degrees, strength within a factor 2
    double direction_deg;  // worst of those found
    double distance_error; // worst of those found, share of the truth; NaN where lights are far
    double strength_error; // worst of those found, share of the truth
    double colour_error;   // worst of those found: distance of the chromaticities xy
    double specular_db, no_specular_db; // linear, of the specular layer; of a black one
    double composite_db;                // sRGB
    double true_specular_db;            // sRGB: the model's diffuse layer under the true specular one
    double true_diffuse_db;             // sRGB: the model's specular layer over the true diffuse one
} exact_score;

// model: fitted to s->inputs; its mesh is ignored, the scene's is used.
void exact_score_model(exact_score *out, const exact_scene *s, const sheen_model *model);

// One line of a table, and its heading.
void exact_score_print_heading(FILE *to);
void exact_score_print(FILE *to, const char *scene, const char *method, const exact_score *score);

#endif
