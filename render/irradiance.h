// SPDX-License-Identifier: Apache-2.0
// irradiance.h - diffuse light on a surface that turns under its lights: texture times E(normal in the world).
//
// Beyond the paper, whose texture is the diffuse colour itself. Where the object turned, that colour changes with the turn:
//     I_D = a E,    E = max(0, sum_k e_k Y_k(n)) + sum_j g_j max(0, n.L_j) / |L_j|^3 V_j(p),    L_j = l_j - x / distance_j
// a: the texture (albedo); Y_k: real spherical harmonics; l_j: lamps, g_j >= 0; x: the point from the lamps' origin (as in lamp.h);
// V_j: 0 where the mesh hides the lamp. Scale: at that origin the mean of E over all directions, without shadows, is 1 in each
// channel (e_0 Y_0 + sum g_j / 4 = 1), so that a is the colour under that light. Where the camera moved, E is 1.
#ifndef SHEEN_RENDER_IRRADIANCE_H
#define SHEEN_RENDER_IRRADIANCE_H

#include "render/surroundings.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_IRRADIANCE_MAX_LAMPS = 24 };

typedef struct sheen_irradiance_lamp {
    float l_world[3];             // unit, towards it from the lamps' origin
    float inverse_distance_per_m; // 0: infinitely far
    double rgb[3];                // g_j
} sheen_irradiance_lamp;

typedef struct sheen_irradiance {
    int present;                        // 0: E is 1
    int degree;                         // of the harmonics, 0 to 2; the terms beyond are zero
    double rgb[SHEEN_AMBIENT_TERMS][3]; // e_k, in the order of sheen_ambient_basis
    sheen_irradiance_lamp lamps[SHEEN_IRRADIANCE_MAX_LAMPS];
    int n_lamps;
} sheen_irradiance;

// Terms of harmonics up to a degree: 1, 4, 9.
int sheen_irradiance_terms(int degree);
// The harmonics' part for a unit normal, never below 0.
void sheen_irradiance_ambient(float rgb[3], const sheen_irradiance *e, const float n_world[3]);
// max(0, n.L) / |L|^3 of a lamp at x_m from the lamps' origin, without shadows, and the unit direction towards it from there.
float sheen_irradiance_lamp_cosine(float to_lamp_world[3], const sheen_irradiance_lamp *lamp,
                                   const float x_m[3], const float n_world[3]);

#ifdef __cplusplus
}
#endif
#endif
