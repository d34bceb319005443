// SPDX-License-Identifier: Apache-2.0
// gltf_specular.h - how strongly each place of an exported surface mirrors. Used inside render only.
//
// A panorama shines on all of a surface alike: in glTF no place lies in another's shadow or mirrors another one, and k_S is one
// number. Nor are highlights brighter where the surface slants, as a lobe's are (1/cos), since viewers spread the panorama once for
// all directions. What can be said a place is a weight w of all that it mirrors (KHR_materials_specular: specularTexture to 1, beyond
// it specularColorTexture, which leaves the rim as it is) and its own light x (base colour). They are chosen in least squares
// over directions to look from,
//     min over w, x of sum_i q_i |x (1 - w F_i) + w F_i L_i - D - S_i|^2,    0 <= w <= 3 (1 where there is no Fresnel term),
// D and S_i being the model's own texture and mirrored light (shade.h), F and L glTF's (gltf_reflection.h). Directions are
// even over what the place shows, for S and L without the lights, and those in which it mirrors one of the strongest lights; there the
// model's mirror direction goes to where the light stands, glTF's to where the panorama has it. q: the share of the pictures that such a direction has, over
// the squared slope at which sRGB codes what is seen.
#ifndef SHEEN_RENDER_GLTF_SPECULAR_H
#define SHEEN_RENDER_GLTF_SPECULAR_H

#include "render/gltf.h"
#include "render/gltf_write.h"

#define SHEEN_GLTF_MOST_WEIGHT 3.0f

// dark: the panorama without lights. Into g->specular, and into the known pixels of g->surface.rgb, (1 - f0) x for D. lights: of the panorama, frame gltf. ENOMEM.
sheen_status sheen_gltf_fit_specular(sheen_gltf *g, const sheen_model *model, const double rt_world_obj[6],
                                     const sheen_image *dark, const sheen_gltf_light *lights, size_t n_lights,
                                     int n_threads, sheen_err *err);

#endif
