// SPDX-License-Identifier: Apache-2.0
// gltf.h - a model as glTF 2.0 (.glb): base colour, roughness, KHR_materials_specular, and the light as a panorama.
//
// What glTF can say of the model: the lobe exp(-alpha^2 / 2 sigma^2) becomes the nearest GGX lobe, roughness^2 = 1.32
// sigma (lamps' lobe with its tail: a wider one). Of k_S and the lights only the product is known; the surface is given the reflectance f0 = 0.04 of glass and
// paint, and k_S over it goes into the panorama's radiance (panorama.h). The paper's lobe has no Fresnel term:
// KHR_materials_specular with the factor f0 and the colour 1 / 0.04 makes the reflectance f0 at all angles; a model with
// surroundings keeps glTF's own Fresnel term and its own reflectance. The global texture is light that left the surface; divided by the irradiance
// of the panorama it becomes base colour, so that in this panorama the object looks as in the photographs, and in others
// as it would there. Shadows on highlights and mirrored images of the object itself, which glTF cannot say, are met on average
// (gltf_specular.h). A normal map becomes normalTexture in tangent space, with tangents (gltf_surface.h).
#ifndef SHEEN_RENDER_GLTF_H
#define SHEEN_RENDER_GLTF_H

#include "render/model.h"
#include "render/surface_picture.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_gltf_options {
    const char *title;
    const double *rt_board_obj; // the board's z points up
    const double *rt_world_obj; // how the object stands under the lights
    size_t max_triangles;       // more are simplified away
    int max_side_px;            // of the texture
    int jpeg_quality;
    int n_lights; // KHR_lights_punctual: the strongest groups of lights, at most this many; 0: none
    int n_threads;
} sheen_gltf_options;

typedef struct sheen_gltf {
    uint8_t *glb;
    size_t glb_bytes;
    sheen_image panorama;
    sheen_surface_picture surface; // mesh and base colour (linear) as the file has them
    float *tangent;                // [charts' vertices][4], frame obj; NULL: none
    sheen_image normals;           // in tangent space, 0..1; no data: none
    sheen_image specular; // weight of what is mirrored, three times, to SHEEN_GLTF_MOST_WEIGHT; no data: 1
    size_t n_triangles;
    int side_px, n_lights;
    double roughness, f0, specular_factor, specular_colour;
    double moved_m;  // how far simplifying moved the surface
    double dome_lin; // light added from everywhere, so that no base colour is beyond white
    double clipped;  // share of the base colour that was beyond 0..1 all the same
    double R_gltf_obj[3][3], t_gltf_obj[3]; // y up, metres; the object's foot at the origin
    double middle_gltf[3];                  // of the object: what views look at
} sheen_gltf;

// EARG: nothing to make, or too much for glTF; ENOMEM.
sheen_status sheen_gltf_make(sheen_gltf *out, const sheen_model *model, const sheen_gltf_options *options,
                             sheen_err *err);
void sheen_gltf_release(sheen_gltf *g);

#ifdef __cplusplus
}
#endif
#endif
