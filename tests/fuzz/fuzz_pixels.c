// SPDX-License-Identifier: Apache-2.0
// fuzz_pixels.c - any bytes as a camera's frame: five of them choose format, sides, row length and colour, the rest are the
// payload. What develops has the size that was asked for (a JPEG its own), and no byte beyond the payload is read.
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "base/pixel_format.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    static const uint32_t formats[] = {
        V4L2_PIX_FMT_YUYV,     V4L2_PIX_FMT_NV12,     V4L2_PIX_FMT_GREY,    V4L2_PIX_FMT_Y10,
        V4L2_PIX_FMT_RGB24,    V4L2_PIX_FMT_BGR24,    V4L2_PIX_FMT_SRGGB8,  V4L2_PIX_FMT_SBGGR10,
        V4L2_PIX_FMT_SGRBG10P, V4L2_PIX_FMT_SGBRG12P, V4L2_PIX_FMT_SRGGB16, V4L2_PIX_FMT_MJPEG,
    };
    if (size_bytes < 5)
        return 0;
    sheen_pixel_layout l = {.fourcc = formats[data[0] % (sizeof formats / sizeof *formats)]};
    l.width_px = data[1];
    l.height_px = data[2];
    l.stride_bytes = data[3] % 2 ? (int)sheen_pixels_stride(l.fourcc, l.width_px) : 2 * data[3];
    l.color = (sheen_colorimetry){data[4] % 13, data[4] / 13 % 9, data[4] % 11, data[4] / 64 % 3};
    const size_t payload_bytes = size_bytes - 5;
    uint8_t *payload = malloc(payload_bytes + 1); // its own: the sanitizer knows where it ends
    if (!payload)
        return 0;
    uint8_t *start = payload + 1;
    memcpy(start, data + 5, payload_bytes);
    sheen_raster r;
    sheen_err err;
    if (!sheen_payload_develop(&r, start, payload_bytes, &l, &err)) {
        if (sheen_pixels_known(l.fourcc) && (r.width_px != l.width_px || r.height_px != l.height_px ||
                                             r.bits != 16 || sheen_pixels_size(&l) > payload_bytes))
            abort();
        sheen_raster_release(&r);
    }
    free(payload);
    return 0;
}
