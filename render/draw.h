// SPDX-License-Identifier: Apache-2.0
// draw.h - pictures of a model from any viewpoint (section 5): texture + specular, added.
#ifndef SHEEN_RENDER_DRAW_H
#define SHEEN_RENDER_DRAW_H

#include "base/camera.h"
#include "base/image.h"
#include "render/model.h"
#include "render/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// Which layers are wanted.
enum {
    SHEEN_LAYER_DIFFUSE = 1,
    SHEEN_LAYER_SPECULAR = 2,
    SHEEN_LAYER_COMPOSITE = 4,
    SHEEN_LAYER_COVERAGE = 8,
    SHEEN_LAYER_HOLES = 16,
    SHEEN_LAYERS_ALL = 31
};

typedef struct sheen_draw_options {
    unsigned layers;         // 0: all; the others stay empty (no pixels)
    int samples_per_side;    // antialiasing: n x n samples a pixel; 0: 2
    int n_threads;           // 0: one per processor
    float hole_rgb[3];       // colour that marks surface which no photograph saw, linear
    int mark_holes;          // else a hole has what the texture was filled with there, or is black
    float background_rgb[3]; // composite's background, linear
} sheen_draw_options;

// Layers of one view, each width_px x height_px of the camera; pixel values are means over its samples.
// diffuse and specular are premultiplied by coverage; composite = diffuse + specular + (1 - coverage)
// background.
typedef struct sheen_layers {
    sheen_image diffuse;   // RGB, linear
    sheen_image specular;  // RGB, linear
    sheen_image composite; // RGB, linear
    sheen_image coverage;  // 1 channel: share of the pixel's samples on the object
    sheen_image holes;     // 1 channel: share of its samples on surface that was never seen
} sheen_layers;

void sheen_layers_release(sheen_layers *l);

// A drawing of one model: keeps its ray-tracing structure and sorted lights. Read-only use from one thread.
typedef struct sheen_drawing sheen_drawing;
sheen_status sheen_drawing_new(sheen_drawing **out, const sheen_model *model,
                               sheen_err *err); // model is lent
void sheen_drawing_free(sheen_drawing **d);

// rt_cam_obj: the view. rt_world_obj: where the object stands under the lights (NULL: the model's own).
// EARG (not finite), ENOMEM.
sheen_status sheen_draw(sheen_layers *out, const sheen_drawing *d, const sheen_camera *cam,
                        const double rt_cam_obj[6], const double *rt_world_obj,
                        const sheen_draw_options *options, sheen_err *err);

// The same into layers of an earlier call (or zeroed ones): pictures of the right size are used again, which
// for a film saves more time than one would think.
sheen_status sheen_redraw(sheen_layers *layers, const sheen_drawing *d, const sheen_camera *cam,
                          const double rt_cam_obj[6], const double *rt_world_obj,
                          const sheen_draw_options *options, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
