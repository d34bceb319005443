// SPDX-License-Identifier: Apache-2.0
// fuzz_picture.c - any bytes as a picture of any format: decoded, probed, turned into light and grey.
#include <stdlib.h>

#include "base/image_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_raster raster;
    int width_px, height_px;
    const sheen_status probed = sheen_raster_probe(&width_px, &height_px, data, size_bytes, &err);
    if (sheen_raster_parse(&raster, data, size_bytes, &err))
        return 0;
    // what can be decoded has been told apart and has the size that its header says
    if (probed || width_px != raster.width_px || height_px != raster.height_px)
        abort();
    const size_t n_px = (size_t)width_px * (size_t)height_px;
    uint8_t *grey = malloc(n_px);
    sheen_image image;
    if (grey)
        sheen_raster_grey(grey, &raster, SHEEN_TRANSFER_LINEAR);
    if (!sheen_image_from_raster(&image, &raster, SHEEN_TRANSFER_SRGB, &err))
        sheen_image_release(&image);
    free(grey);
    sheen_raster_release(&raster);
    return 0;
}
