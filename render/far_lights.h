// SPDX-License-Identifier: Apache-2.0
// far_lights.h - node lights and lamps as they are seen from the middle of the object. Used inside render only.
#ifndef SHEEN_RENDER_FAR_LIGHTS_H
#define SHEEN_RENDER_FAR_LIGHTS_H

#include "render/model.h"

typedef struct sheen_far_light {
    float v_env[3];        // unit, towards it
    double power_rgb[3];   // reflectance times the irradiance that a surface facing it gets
    double solid_angle_sr; // 0: a point
    double distance_m;     // INFINITY: a node, or a lamp so far
} sheen_far_light;

// All lights with any power. rt_world_obj, R_env_obj: how the object stands under them, and in env. The caller frees *out. ENOMEM.
sheen_status sheen_far_lights_make(sheen_far_light **out, size_t *n, const sheen_model *model,
                                   const double rt_world_obj[6], double R_env_obj[3][3], sheen_err *err);

#endif
