// SPDX-License-Identifier: Apache-2.0
// surroundings.h - what a glossy surface mirrors besides the lights: the board it stands on, and the room.
//
// Beyond the paper, whose hemisphere ends at the horizon. The mirrored radiance is looked up in the perfect mirror
// direction and weighted by Schlick's Fresnel term F = F0 + (1 - F0) (1 - cos theta_r)^5. Frame: world, whose plane
// z = 0 is the board's paper.
#ifndef SHEEN_RENDER_SURROUNDINGS_H
#define SHEEN_RENDER_SURROUNDINGS_H

#include "base/image.h"

#ifdef __cplusplus
extern "C" {
#endif

// Reflectance at normal incidence of glass, varnish and most plastics (refractive index 1.5).
#define SHEEN_DIELECTRIC_F0 0.04

enum { SHEEN_AMBIENT_TERMS = 9 };

typedef struct sheen_surroundings {
    int present; // 0: nothing is mirrored but the lights (the paper)
    double f0;   // reflectance at normal incidence
    double ambient_rgb[SHEEN_AMBIENT_TERMS]
                      [3]; // radiance from above the horizon: real spherical harmonics to order 2
    sheen_image board; // RGB radiance of the plane z = 0; row 0 has the lowest y; data NULL: all is `table`
    double board_x0_m, board_y0_m, board_pitch_m; // centre of pixel (0, 0), and pixel size
    double table_rgb[3];                          // radiance of the plane outside of the picture
} sheen_surroundings;

void sheen_surroundings_release(sheen_surroundings *s);

// F of the angle between normal and view; cosine is held to 0..1.
float sheen_fresnel(double f0, float cosine);

// The harmonics at a unit direction, in the order 1, y, z, x, xy, yz, 3z^2-1, xz, x^2-y^2 with their usual factors.
void sheen_ambient_basis(double basis[SHEEN_AMBIENT_TERMS], const float v_world[3]);

// Radiance (not yet times F) that arrives at p_world from direction r_world (unit), past the object.
void sheen_surroundings_radiance(float rgb[3], const sheen_surroundings *s, const float p_world[3],
                                 const float r_world[3]);

// What the plane z = 0 sends along r_world (below the horizon), spread as a rough surface mirrors it: the mean over
// SHEEN_SPREAD_POINTS directions that stand for a Gaussian of spread_rad about r_world; 0: r_world alone. Directions that the
// spread takes above the horizon are left out.
enum { SHEEN_SPREAD_POINTS = 16 };
void sheen_surroundings_plane(float rgb[3], const sheen_surroundings *s, const float p_world[3],
                              const float r_world[3], float spread_rad);

#ifdef __cplusplus
}
#endif
#endif
