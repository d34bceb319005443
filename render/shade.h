// SPDX-License-Identifier: Apache-2.0
// shade.h - the view-dependent light of a surface point: lobe of the lights, shadowed, and what it mirrors.
//
// The one forward model of the specular part: draw calls it for pixels, fit for texels.
#ifndef SHEEN_RENDER_SHADE_H
#define SHEEN_RENDER_SHADE_H

#include <stdbool.h>

#include "render/model.h"
#include "render/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_shading {
    const sheen_model *model;       // k_S, sigma, lights, surroundings, texture; lent
    const sheen_scene *scene;       // of the model's mesh
    const sheen_light_cells *cells; // of the model's lights at its sigma
    const sheen_lamp_points *lamps; // of the model's lamps
    float R_world_obj[3][3], t_world_obj[3];
    float R_board_world[3][3], t_board_world[3]; // the board turns with an object that turns; else identity
    float offset_m;                              // by which secondary rays start off the surface
} sheen_shading;

void sheen_shading_init(sheen_shading *s, const sheen_model *model, const sheen_scene *scene,
                        const sheen_light_cells *cells, const sheen_lamp_points *lamps,
                        const double rt_world_obj[6]);

// Specular light, for a gloss of 1, of nodes by eq. (7) (times k_S and the lights' colour), and of lamps (lamp.h), each shadowed by the mesh where the model says so.
void sheen_shade_lights(float rgb[3], const sheen_shading *s, const float p_obj[3], const float n_obj[3],
                        const float v_obj[3]);
// False where sheen_shade_lights would give black at each of n neighbouring points (arrays [n][3]): then it need not be asked. By a bound
// on the lobe over all of them, so that it may be true where nothing shines.
bool sheen_shade_may_shine(const sheen_shading *s, const float *p_obj, const float *n_obj, const float *v_obj,
                           size_t n);
// E of irradiance.h at a point: what the texture there is multiplied by. 1 where the model has none.
void sheen_shade_irradiance(float rgb[3], const sheen_shading *s, const float p_obj[3], const float n_obj[3]);
// 1 where the mesh hides the light in direction l_world from the point. n_world: its normal.
int sheen_shade_hidden(const sheen_shading *s, const float p_obj[3], const float n_world[3],
                       const float l_world[3]);
// Radiance in the mirror direction, without F, of n points (arrays [n][3]; neighbours side by side are faster): the object's
// own texture where it stands in the way, else the surroundings. Black where the model has none.
void sheen_shade_mirrored(float *rgb, const sheen_shading *s, const float *p_obj, const float *n_obj,
                          const float *v_obj, size_t n);
// The same taken apart: rgb where the mirror direction meets the object or the plane, and black where it leads up and out;
// then above_world is that direction, else 0.
void sheen_shade_split(float *rgb, float *above_world, const sheen_shading *s, const float *p_obj,
                       const float *n_obj, const float *v_obj, size_t n);
// Both, the second times F, and all times each place's gloss[n] (gloss.h).
void sheen_shade(float *rgb, const sheen_shading *s, const float *gloss, const float *p_obj,
                 const float *n_obj, const float *v_obj, size_t n);

#ifdef __cplusplus
}
#endif
#endif
