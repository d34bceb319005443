// SPDX-License-Identifier: Apache-2.0
// lamp.h - lights as objects: direction, distance, extent, colour; and the lobe under which they are seen.
//
// Beyond the paper, whose lights are nodes of a hemisphere, all infinitely far. What a lamp adds at a surface point x (metres,
// from the lamps' common origin, frame world) with unit normal n, seen from the unit direction v:
//
//     rgb * (1 / N) sum_k  1 / |L_k|^2 * B(n, v, L_k / |L_k|)                L_k = d_k - inverse_distance * x
//     B = [n.l > 0] F_h ((1 - tail) exp(-alpha^2 / (2 sigma^2)) + tail / (1 + alpha^2 / (4 sigma^2))^2) / max(n.v, 0.2)
//     F_h = 1 + fresnel (1 - v.h)^5
//
// alpha: angle between n and h = bisector of v and l. tail = 0 is eq. (7); tail = 1 is the GGX distribution of roughness
// alpha_g = 2 sigma, which has the same curvature at its peak. d_0 .. d_N-1 are N points spread evenly over the lamp's disc
// about its direction, which faces the origin: d_k = d + radius sqrt((k + 1/2) / N) (cos(2.39996 k) a + sin(2.39996 k) b),
// with a, b unit and square to the unit direction d (a = d x axis of d's smallest component, b = d x a). N is 1 for a
// radius below 0.05 sigma, else 8, 16, 32, 64 or 128, as radius / sigma is below 1, 2, 4, 8 or not. Shadowed by the mesh towards d.
//
// Where alpha v.h of the direction to d exceeds 6 sigma + 0.75 radius, only the far tail is left, and d stands for all its points.
#ifndef SHEEN_RENDER_LAMP_H
#define SHEEN_RENDER_LAMP_H

#include <stddef.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_lamp {
    float direction_world[3];     // unit, from the lamps' origin
    float inverse_distance_per_m; // 0: infinitely far
    float radius_rad;             // half of its apparent width from the origin; 0: a point
    float rgb
        [3]; // light at the peak of its highlight at the origin, for a surface that faces the camera: k_S omega L
} sheen_lamp;

// The lobe that all lamps share.
typedef struct sheen_lobe_shape {
    float sigma_rad; // of the Gaussian
    float tail;      // 0..1: share of the heavy-tailed lobe
    float fresnel;   // Schlick: (1 - F0) / F0; 0: none
} sheen_lobe_shape;

enum { SHEEN_LAMPS_MAX = 4096, SHEEN_LAMP_MAX_POINTS = 128 };

// Lamps taken apart into points, as arrays, for the kernel.
typedef struct sheen_lamp_points {
    float *dx, *dy, *dz, *inverse_distance, *share; // [n_points]; share = 1 / N
    size_t *first;     // [n_lamps + 1] lamp i has the points first[i] .. first[i + 1]
    float *far_alpha2; // [n_lamps] beyond which its middle stands for all
    size_t n_lamps, n_points;
    struct sheen_lamp_points *middles; // the lamps as points; NULL in itself
} sheen_lamp_points;

// Points of a disc of this radius under a lobe of this width.
size_t sheen_lamp_point_count(float radius_rad, float sigma_rad);

// lamps: [n] (NULL where n is 0). Calls with the same sigma and radii give the same points. ENOMEM.
sheen_status sheen_lamp_points_init(sheen_lamp_points *out, const sheen_lamp *lamps, size_t n,
                                    float sigma_rad, sheen_err *err);
void sheen_lamp_points_release(sheen_lamp_points *p);

// response[n]: of lamps begin .. begin + n, uncoloured and unshadowed (times rgb it is what they add). x_m: the surface point
// from the lamps' origin. n, v: world.
void sheen_lamp_responses(float *response, const sheen_lamp_points *p, size_t begin, size_t n,
                          const sheen_lobe_shape *lobe, const float x_m[3], const float n_world[3],
                          const float v_world[3]);

// Neighbouring surface points: means of their places and of their unit vectors, and by how far each differs from that at most.
typedef struct sheen_lamp_patch {
    float x_m[3], n_world[3], v_world[3]; // from the lamps' origin; the means' lengths may be below 1
    float x_reach_m, n_reach, v_reach;
} sheen_lamp_patch;

// What no point of the patch's response to the lamp exceeds; HUGE_VALF where the patch is too bent for a bound.
float sheen_lamp_response_bound(const sheen_lamp *lamp, const sheen_lobe_shape *lobe,
                                const sheen_lamp_patch *patch);
// sheen_lamp_responses in double precision with the library's functions, as written above.
void sheen_lamp_responses_ref(double *response, const sheen_lamp *lamps, size_t n,
                              const sheen_lobe_shape *lobe, const float x_m[3], const float n_world[3],
                              const float v_world[3]);

#ifdef __cplusplus
}
#endif
#endif
