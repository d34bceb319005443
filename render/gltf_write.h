// SPDX-License-Identifier: Apache-2.0
// gltf_write.h - the file format glTF 2.0 binary (.glb): one mesh, one material, one picture. For gltf.c only.
#ifndef SHEEN_RENDER_GLTF_WRITE_H
#define SHEEN_RENDER_GLTF_WRITE_H

#include <stdbool.h>

#include "render/charts.h"

enum { SHEEN_GLTF_MAX_LIGHTS = 16 };

typedef struct sheen_gltf_light {
    bool near;           // a point light, at `position`; else a directional one
    double direction[3]; // towards it
    double position[3];
    double rgb[3], intensity; // candela of a point light, else lux
    double radius_rad;        // of the largest that it stands for; not written
} sheen_gltf_light;

typedef struct sheen_gltf_parts {
    const char *title;
    const sheen_mesh *mesh;
    const sheen_charts *charts;
    double (*R_gltf_obj)[3]; // not written to
    const double *t_gltf_obj;
    const uint8_t *jpeg;
    size_t jpeg_bytes;
    const float *tangent; // [charts' vertices][4], frame obj; NULL: none
    const uint8_t *normals,
        *specular; // PNG: normalTexture, specularTexture and specularColorTexture; NULL: none
    size_t normals_bytes, specular_bytes;
    double roughness, specular_factor, specular_colour;
    const sheen_gltf_light *lights;
    size_t n_lights;
} sheen_gltf_parts;

// The caller frees *glb. EARG: more than glTF's 4 GB; ENOMEM.
sheen_status sheen_gltf_write(uint8_t **glb, size_t *glb_bytes, const sheen_gltf_parts *parts,
                              sheen_err *err);

#endif
