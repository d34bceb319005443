// SPDX-License-Identifier: Apache-2.0
// simpler_model.h - the same model on a mesh of fewer triangles.
#ifndef SHEEN_RENDER_SIMPLER_MODEL_H
#define SHEEN_RENDER_SIMPLER_MODEL_H

#include "render/model.h"

#ifdef __cplusplus
extern "C" {
#endif

// *out is m, lent, with a mesh of about max_triangles (simplify.h), a texture that holds what the original surface shows there, and
// a normal map that keeps its normals. Released by sheen_simpler_model_release, before m. *moved_m: how far
// the surface moved, about. EARG, ENOMEM, EUNSUP.
sheen_status sheen_simpler_model_make(sheen_model *out, const sheen_model *m, size_t max_triangles,
                                      double *moved_m, sheen_err *err);
void sheen_simpler_model_release(sheen_model *simpler);

#ifdef __cplusplus
}
#endif
#endif
