// SPDX-License-Identifier: Apache-2.0
// fuzz_opencv_yaml.c - any bytes as a calibration in YAML: what is read is a camera.
#include <stdlib.h>

#include "base/pose_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_camera cam;
    if (!sheen_opencv_yaml_parse(&cam, data, size_bytes, 640, 480, &err) && sheen_camera_check(&cam, &err))
        abort();
    return 0;
}
