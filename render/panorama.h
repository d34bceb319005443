// SPDX-License-Identifier: Apache-2.0
// panorama.h - the light about the object as one equirectangular picture, as programs that know no node lights take it.
//
// Frame `env`: x right, y up, z towards the viewer, as glTF has it. Row 0 is the zenith; the middle of the picture is +x,
// and to the right of it follows +z: pixel (x, y) shows azimuth (x + 1/2) / width * 2 pi - pi from +x towards +z.
#ifndef SHEEN_RENDER_PANORAMA_H
#define SHEEN_RENDER_PANORAMA_H

#include "render/model.h"

#ifdef __cplusplus
extern "C" {
#endif

// Linear RGB radiance, height_px rows of twice as many pixels: what the model's surroundings are from the object's middle;
// black where it has none. rt_world_obj, R_env_obj: how the object stands under the lights, and in env. ENOMEM.
sheen_status sheen_panorama_make(sheen_image *out, const sheen_model *model, const double rt_world_obj[6],
                                 double R_env_obj[3][3], int height_px, sheen_err *err);
// Adds node lights and lamps, as they are seen from the object's middle, as discs that light up a surface which reflects f0
// as they do in the model (far_lights.c). ENOMEM.
sheen_status sheen_panorama_add_lights(sheen_image *panorama, const sheen_model *model,
                                       const double rt_world_obj[6], double R_env_obj[3][3], double f0,
                                       sheen_err *err);

// Unit direction of a pixel's centre, and the solid angle of a pixel of that row.
void sheen_panorama_direction(float v_env[3], const sheen_image *panorama, int x, int y);
double sheen_panorama_pixel_sr(const sheen_image *panorama, int y);
// Radiance from a unit direction, between four pixels.
void sheen_panorama_at(float rgb[3], const sheen_image *panorama, const float v_env[3]);

// Light that falls on a surface with each of n normals, [n][3] to [n][3]: the integral of radiance times cosine. ENOMEM.
sheen_status sheen_panorama_irradiance(float *rgb, const float *n_env, size_t n, const sheen_image *panorama,
                                       sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
