// SPDX-License-Identifier: Apache-2.0
// gltf_reflection.h - what a surface with glTF's material mirrors of a panorama: appendix B of its specification and
// KHR_materials_specular, as viewers on the web have it. Used inside render only.
//
// Mirrored light is F L: L is the panorama's radiance about the mirror direction, spread by the GGX lobe as those viewers
// spread it (the lobe of a view along the normal), and F = F0 A + F90 B the reflectance of the lobe as a whole: A and B are
// integrals of GGX with Smith's shadowing over the angle (Karis 2013, "Real shading in Unreal Engine 4").
#ifndef SHEEN_RENDER_GLTF_REFLECTION_H
#define SHEEN_RENDER_GLTF_REFLECTION_H

#include "base/image.h"

enum { SHEEN_GLTF_LOBE_SAMPLES = 128, SHEEN_GLTF_COSINES = 64 };

typedef struct sheen_gltf_reflection {
    float lobe[SHEEN_GLTF_LOBE_SAMPLES][3];             // directions about +z
    float A[SHEEN_GLTF_COSINES], B[SHEEN_GLTF_COSINES]; // at the middle of each step of the cosine
} sheen_gltf_reflection;

void sheen_gltf_reflection_init(sheen_gltf_reflection *r, double roughness);
// F at an angle whose cosine to the normal is this.
float sheen_gltf_reflectance(const sheen_gltf_reflection *r, float cosine, float f0, float f90);
// L: the panorama about the unit direction r_env.
void sheen_gltf_mirrored(float rgb[3], const sheen_gltf_reflection *r, const sheen_image *panorama,
                         const float r_env[3]);
// L everywhere, as a panorama of this height. ENOMEM.
sheen_status sheen_gltf_spread(sheen_image *out, const sheen_gltf_reflection *r, const sheen_image *panorama,
                               int height_px, int n_threads, sheen_err *err);

#endif
