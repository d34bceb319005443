// SPDX-License-Identifier: Apache-2.0
// camera_private.h - what camera.c asks of camera_mrcal.c alone.
#ifndef SHEEN_BASE_CAMERA_PRIVATE_H
#define SHEEN_BASE_CAMERA_PRIVATE_H

#include "base/camera.h"

// A .cameramodel without its comments.
sheen_status sheen_camera_parse_mrcal(sheen_camera *cam, const void *data, size_t size_bytes, sheen_err *err);

#endif
