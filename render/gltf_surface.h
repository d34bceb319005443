// SPDX-License-Identifier: Apache-2.0
// gltf_surface.h - an exported surface as a reader of the file sees it: places, normals and pictures. Used inside render only.
#ifndef SHEEN_RENDER_GLTF_SURFACE_H
#define SHEEN_RENDER_GLTF_SURFACE_H

#include "render/gltf.h"

// Tangents of the charts' vertices, [n_vertices][4], frame obj: unit, square to the mesh's normal, towards the picture's right;
// the fourth number, 1 or -1: normal x tangent times it is towards the picture's top. The caller frees *out. ENOMEM.
sheen_status sheen_gltf_tangents(float **out, const sheen_surface_picture *p, sheen_err *err);
// The normal map in tangent space, coded as 0..1, from surface.n_obj, with g->tangent; half as large a picture where its
// texels are at least twice as large as those of the colours. Nothing where the model has no map. ENOMEM.
sheen_status sheen_gltf_normal_picture(sheen_image *out, const sheen_gltf *g, const sheen_model *model,
                                       sheen_err *err);
// Irradiance of g->panorama by the direction of the normal, as a small panorama. ENOMEM.
sheen_status sheen_gltf_irradiance(sheen_image *out, const sheen_image *panorama, sheen_err *err);

void sheen_gltf_to_env(float v_env[3], const sheen_gltf *g, const float v_obj[3]);
// Point and unit normal, with the normal picture, at a place of the exported mesh.
void sheen_gltf_surface_at(float p_obj[3], float n_obj[3], const sheen_gltf *g, const sheen_chart_place *at);
// A picture of the surface, of any size, at a place; n_channels numbers.
void sheen_gltf_picture_at(float *out, const sheen_gltf *g, const sheen_image *picture,
                           const sheen_chart_place *at);

#endif
