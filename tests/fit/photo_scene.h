// SPDX-License-Identifier: Apache-2.0
// photo_scene.h - photographs of a model with known lights, drawn by sheen's own renderer.
#ifndef SHEEN_TESTS_FIT_PHOTO_SCENE_H
#define SHEEN_TESTS_FIT_PHOTO_SCENE_H

#include "fit/photos.h"
#include "render/model.h"

typedef struct photo_scene {
    sheen_model truth;   // figure or sphere with a painted texture and distant lights
    sheen_photos inputs; // on a ring at 35 degrees
    sheen_photos tests;  // between them, a little higher
} photo_scene;

typedef struct photo_scene_options {
    int bumpy; // a figure whose bumps hide one another; else a sphere
    int width_px, height_px;
    size_t n_inputs, n_tests;
    int n_lights; // up to 6; 0: matte
    double sigma_rad, noise;
} photo_scene_options;

void photo_scene_make(photo_scene *out, const photo_scene_options *o);
void photo_scene_release(photo_scene *s);
// Direction of light i in world.
void photo_scene_light(double v_world[3], int i);

#endif
