// SPDX-License-Identifier: Apache-2.0
// gltf_view.h - what a program that keeps to glTF 2.0 shows of an exported model: how far it is from the model is then known.
#ifndef SHEEN_RENDER_GLTF_VIEW_H
#define SHEEN_RENDER_GLTF_VIEW_H

#include "base/camera.h"
#include "render/gltf.h"

#ifdef __cplusplus
extern "C" {
#endif

// Linear RGB, one sample a pixel, as large as the camera's picture; background_rgb where the object is not. ENOMEM.
sheen_status sheen_gltf_view(sheen_image *out, const sheen_gltf *g, const sheen_camera *cam,
                             const double rt_cam_obj[6], const float background_rgb[3], int n_threads,
                             sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
