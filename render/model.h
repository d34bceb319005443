// SPDX-License-Identifier: Apache-2.0
// model.h - what a fit found and a renderer needs: mesh, global texture, lights, k_S, sigma.
//
// In a session: model/model.json (parameters and lights), model/texture.exr (atlas), model/normals.exr (where there is a normal map),
// the session's mesh.
#ifndef SHEEN_RENDER_MODEL_H
#define SHEEN_RENDER_MODEL_H

#include "base/json.h"
#include "base/json_write.h"
#include "base/mesh.h"
#include "base/session.h"
#include "render/gloss.h"
#include "render/irradiance.h"
#include "render/lamp.h"
#include "render/lobe.h"
#include "render/normal_map.h"
#include "render/surroundings.h"
#include "render/texture.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_model {
    char method[24]; // "paper"
    sheen_mesh mesh; // frame obj
    sheen_texture texture;
    sheen_texture normals; // beyond the paper: offsets of the mesh's normals (normal_map.h); empty: none
    // Lights stand still in `world`: the board's frame; where the object turned, the board's frame in the first
    // photograph, in which the camera stands still, too.
    sheen_moving moving;
    double rt_world_obj[6]; // where the object stands in the first photograph (rt_board_obj)
    double rt_world_cam[6]; // of an object that turned: where the camera stood all the time
    int frequency;          // of the geodesic hemisphere that the lights are nodes of
    size_t n_hemisphere;    // N_L
    uint32_t *node;         // [lights.count] index into that hemisphere
    float *radiance;        // [lights.count] L_l
    sheen_lights lights;    // directions in world; weight = (2 pi / N_L) L_l
    double k_s, sigma_rad;
    // Beyond the paper: lamps, added to the nodes' light (see lamp.h for what they add)
    sheen_lamp *lamps; // [n_lamps] frame world
    size_t n_lamps;
    double lamp_origin_world[3];     // their directions and distances are from here
    double lobe_tail, lobe_fresnel;  // of the lamps' lobe, whose sigma is sigma_rad
    sheen_gloss gloss;               // how strongly each colour of texture shines (beyond the paper)
    int shadows;                     // 1: the mesh hides lights from its own surface (beyond the paper)
    sheen_irradiance irradiance;     // of an object that turned: the light on its texture (beyond the paper)
    sheen_surroundings surroundings; // what is mirrored besides the lights (beyond the paper)
    double light_rgb[3];             // average light colour, Y = 1: the specular layer is I_S times this
} sheen_model;

void sheen_model_init(sheen_model *m);
void sheen_model_release(sheen_model *m);
// Makes room for n lights (node, radiance and lights' arrays). ENOMEM.
sheen_status sheen_model_set_lights(sheen_model *m, size_t n, sheen_err *err);

// Where the object stands under the lights when the session's camera, or another beside it, sees it at rt_cam_obj: where the
// object turned, as the camera sees it turned under lights that stand still; else always the same. (To let the lights turn
// with the object instead, draw with the model's own rt_world_obj.)
void sheen_model_place(double rt_world_obj[6], const sheen_model *m, const double rt_cam_obj[6]);
// Replaces the lamps by a copy of lamps[n]. ENOMEM.
sheen_status sheen_model_set_lamps(sheen_model *m, const sheen_lamp *lamps, size_t n, sheen_err *err);
sheen_lobe_shape sheen_model_lobe(const sheen_model *m);
// Highlights of all lights times rgb.
void sheen_model_scale_highlights(sheen_model *m, const double rgb[3]);

// Into a folder (an unfinished model/ that the caller renames to its place): model.json and texture.exr. s:
// the session whose mesh was fitted; its digest goes into model.json. `extra` (may be NULL) adds members to
// model.json: the fit's report.
sheen_status sheen_model_save(const sheen_model *m, const sheen_session *s, const char *dir,
                              void (*extra)(void *self, sheen_json_writer *w), void *self, sheen_err *err);
// Reads a session's model and mesh; every number is checked. EDATA: the session has no model yet. EFORMAT:
// damaged, or the mesh is not the one that was fitted.
sheen_status sheen_model_load(sheen_model *m, const sheen_session *s, sheen_err *err);
// The members of model.json that name no file (method, lights, reflectance, surroundings), into an open object and
// out of one; read numbers are checked, a board's picture is left to the caller. EFORMAT, ENOMEM.
void sheen_model_put_numbers(sheen_json_writer *w, const sheen_model *m);
sheen_status sheen_model_get_numbers(sheen_model *m, const sheen_json *root, sheen_err *err);
// model.json alone from memory (lights and parameters; texture and mesh are left empty), and how many
// triangles and texels an edge it says the texture has.
sheen_status sheen_model_parse(sheen_model *m, const void *data, size_t size_bytes, size_t *n_triangles,
                               int *texels_per_edge, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
