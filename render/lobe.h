// SPDX-License-Identifier: Apache-2.0
// lobe.h - the forward model of the specular part, eq. (7) of the paper. It exists here only; fit calls it.
//
//     I_S = k_S (2 pi / N_L) sum_l L_l exp(-alpha_l^2 / (2 sigma^2)) / cos(theta_r)
//
// alpha: angle between the normal n and the bisector h of the direction v to the camera and the direction
// l to the light; theta_r: angle between n and v. Three things which the paper leaves open: a light below
// the surface's horizon (n.l <= 0) adds nothing, a surface that faces away from the camera (n.v <= 0) shows
// nothing, and 1/cos is held at 1/SHEEN_LOBE_MIN_COS at grazing views.
#ifndef SHEEN_RENDER_LOBE_H
#define SHEEN_RENDER_LOBE_H

#include <stddef.h>

#include "base/status.h"
#include "base/vec.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SHEEN_LOBE_MIN_COS 0.2f
// Beyond this many sigma of alpha a term is below 4e-6 of its peak and is left out everywhere.
#define SHEEN_LOBE_REACH_SIGMA 5.0f

// Lights as separate arrays: unit directions in the frame of n and v, and weight = (2 pi / N_L) L_l.
typedef struct sheen_lights {
    float *dx, *dy, *dz, *weight;
    size_t count;
} sheen_lights;

// alpha^2 in rad^2 for unit n, v, l; HUGE_VALF where n.l <= 0 or n.v <= 0.
float sheen_lobe_alpha2(const float n[3], const float v[3], const float l[3]);

// 1 / max(cos(theta_r), SHEEN_LOBE_MIN_COS).
static inline float sheen_lobe_inverse_cos(const float n[3], const float v[3])
{
    const float c = sheen_dotf(n, v);
    return 1.0f / (c > SHEEN_LOBE_MIN_COS ? c : SHEEN_LOBE_MIN_COS);
}

// sum_l weight_l exp(-alpha_l^2 / (2 sigma^2)) / cos(theta_r): eq. (7) without k_S.
float sheen_lobe_sum(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad);
// The same at a given level of instruction set up to sheen_cpu_level(): for tests and benchmarks.
float sheen_lobe_sum_level(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad,
                           int level);
// The same in double precision with the library's functions, term by term as written above.
double sheen_lobe_sum_ref(const sheen_lights *lights, const float n[3], const float v[3], float sigma_rad);

// The same sum over many lights where most are out of the lobe's reach: lights are sorted into cells of
// directions once, and only cells near the mirror direction are summed. Agrees with sheen_lobe_sum to the
// terms that SHEEN_LOBE_REACH_SIGMA leaves out.
typedef struct sheen_light_cells sheen_light_cells;
sheen_status sheen_light_cells_new(sheen_light_cells **out, const sheen_lights *lights, float sigma_rad,
                                   sheen_err *err);
void sheen_light_cells_free(sheen_light_cells **cells);
float sheen_light_cells_sum(const sheen_light_cells *cells, const float n[3], const float v[3]);
// The lights that the sum goes over for this normal and view: a superset of those in reach, lent. Some may have no weight.
void sheen_light_cells_near(sheen_lights *near, const sheen_light_cells *cells, const float n[3],
                            const float v[3]);

#ifdef __cplusplus
}
#endif
#endif
