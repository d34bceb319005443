// SPDX-License-Identifier: Apache-2.0
// panorama_lamps.h - a panorama as the light on a model: relighting.
#ifndef SHEEN_RENDER_PANORAMA_LAMPS_H
#define SHEEN_RENDER_PANORAMA_LAMPS_H

#include "render/model.h"

#ifdef __cplusplus
extern "C" {
#endif

// Replaces what a model mirrors (nodes, lamps, room, board) by a panorama: equirectangular, twice as wide as high, radiance in
// units of the photographs' white, frame env as in panorama.h with the board's x, z and -y as its x, y and z. It becomes at most n_lamps
// lamps at infinity, each as wide as what it stands for; a surface of reflectance f0 mirrors them. The
// texture stays: it holds the light that was on the object. EDATA: not such a picture, or all black. ENOMEM.
sheen_status sheen_model_light_by_panorama(sheen_model *m, const sheen_image *panorama, size_t n_lamps,
                                           double f0, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
