// SPDX-License-Identifier: Apache-2.0
// normals.h - the step of the refined method that estimates a normal map from the highlights, and from the
// shading where the object turned under its lights.
#ifndef SHEEN_FIT_NORMALS_H
#define SHEEN_FIT_NORMALS_H

#include "fit/refined_state.h"

// Improves r->f->model.normals given everything else; r->lights and r->shading are the model's, and are not any more afterwards where the
// normals have changed (*changed = 1): call sheen_refined_light_views. The first call decides on how freely normals may change by how views left out
// are predicted by the others, and keeps none where the mesh's own predict as well; later calls go on with it. The result does not depend on the
// number of threads. ENOMEM, ECANCEL.
sheen_status sheen_refined_normals(sheen_refined_state *r, int *changed, sheen_err *err);

#endif
