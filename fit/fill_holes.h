// SPDX-License-Identifier: Apache-2.0
// fill_holes.h - surface that no photograph saw takes on the colour of what lies about it.
#ifndef SHEEN_FIT_FILL_HOLES_H
#define SHEEN_FIT_FILL_HOLES_H

#include "base/mesh.h"
#include "render/texture.h"

// Colours of the seen texels are gathered at the mesh's vertices and spread along its edges to vertices without any; unseen texels
// take what their triangle's corners have. n_views of them stays 0: they are told from what was seen, counted and marked as
// before. Nothing changes where no texel was seen at all. ENOMEM.
sheen_status sheen_fill_holes(sheen_texture *t, const sheen_mesh *mesh, sheen_err *err);

#endif
