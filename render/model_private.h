// SPDX-License-Identifier: Apache-2.0
// model_private.h - what the reader and the writer of model.json share.
#ifndef SHEEN_RENDER_MODEL_PRIVATE_H
#define SHEEN_RENDER_MODEL_PRIVATE_H

#include "render/model.h"

#define SHEEN_MODEL_SCHEMA "sheen-model"
enum { SHEEN_MODEL_VERSION = 3 }; // 2: with lamps; 3: with a normal map or gloss by colour
#define SHEEN_MODEL_FILE "model.json"
#define SHEEN_MODEL_TEXTURE_FILE "texture.exr"

// Every number of a model that is not the mesh's or the texture's. Fails with `code`.
sheen_status sheen_model_check(const sheen_model *m, sheen_status code, sheen_err *err);

// The members beyond the paper (model_surroundings.c): checked, put, board.exr saved, got, and the picture read.
sheen_status sheen_model_check_surroundings(const sheen_surroundings *e, sheen_status code, sheen_err *err);
void sheen_model_put_surroundings(sheen_json_writer *w, const sheen_model *m);
sheen_status sheen_model_save_board(const sheen_model *m, const char *dir, sheen_err *err);
sheen_status sheen_model_get_surroundings(sheen_model *m, const sheen_json *root, sheen_err *err);
sheen_status sheen_model_load_surroundings(sheen_model *m, const char *dir, const sheen_json *root,
                                           sheen_err *err);

// The light on a texture that turned (model_irradiance.c), with the place of the camera.
sheen_status sheen_model_check_irradiance(const sheen_irradiance *e, sheen_status code, sheen_err *err);
void sheen_model_put_irradiance(sheen_json_writer *w, const sheen_model *m);
sheen_status sheen_model_get_irradiance(sheen_model *m, const sheen_json *root, sheen_err *err);

// The lamps (model_lamps.c): checked, written where there are any, parsed.
sheen_status sheen_model_check_lamps(const sheen_model *m, sheen_status code, sheen_err *err);
void sheen_model_write_lamps(sheen_json_writer *w, const sheen_model *m);
sheen_status sheen_model_parse_lamps(sheen_model *m, const sheen_json *root, sheen_err *err);

// The normal map (model_normals.c): named in model.json where there is one (parsed: 0 texels an edge where there is none), its picture saved,
// and read once the mesh is there.
void sheen_model_put_normals(sheen_json_writer *w, const sheen_model *m);
sheen_status sheen_model_parse_normals(int *texels_per_edge, const sheen_json *root, sheen_err *err);
sheen_status sheen_model_save_normals(const sheen_model *m, const char *dir, sheen_err *err);
sheen_status sheen_model_load_normals(sheen_model *m, const char *dir, const sheen_json *root,
                                      sheen_err *err);

// A texture's picture: saved (model.c), and read, `in` naming its file (model_parse.c).
sheen_status sheen_model_save_atlas(const sheen_texture *t, const char *path, sheen_err *err);
sheen_status sheen_model_load_atlas(sheen_texture *t, const char *dir, const sheen_json *in,
                                    size_t n_triangles, int texels_per_edge, sheen_err *err);

// How strongly each colour of texture shines (model_gloss.c).
sheen_status sheen_model_check_gloss(const sheen_gloss *g, sheen_status code, sheen_err *err);
void sheen_model_put_gloss(sheen_json_writer *w, const sheen_gloss *g);
sheen_status sheen_model_get_gloss(sheen_gloss *g, const sheen_json *root, sheen_err *err);

// Nodes of the geodesic hemisphere of a frequency.
size_t sheen_model_hemisphere_size(int frequency);

#endif
