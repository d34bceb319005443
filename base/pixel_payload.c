// SPDX-License-Identifier: Apache-2.0
// pixel_payload.c - what a camera delivered, whatever its format, developed into codes of R'G'B'.
//
// A JPEG is JFIF's, BT.601 in full range, whatever V4L2 would have as the default of the colorspace: USB video says
// limited range of cameras that all deliver full. Only what a driver or a person says in so many words counts against it.
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

#include "base/image_file.h"
#include "base/pixel_parts.h"

static bool is_picture_file(uint32_t fourcc)
{
    return !fourcc || fourcc == V4L2_PIX_FMT_MJPEG || fourcc == V4L2_PIX_FMT_JPEG;
}

static bool is_jpeg(const void *data, size_t size_bytes)
{
    return size_bytes >= 3 && !memcmp(data, "\xff\xd8\xff", 3);
}

// What is said of a JPEG, with JFIF where nothing is.
static sheen_colorimetry jpeg_color(const sheen_colorimetry *said)
{
    sheen_colorimetry c = *said;
    if (c.ycbcr_enc == V4L2_YCBCR_ENC_DEFAULT)
        c.ycbcr_enc = V4L2_YCBCR_ENC_601;
    if (c.quantization == V4L2_QUANTIZATION_DEFAULT)
        c.quantization = V4L2_QUANTIZATION_FULL_RANGE;
    return c;
}

// Codes of 8 bits into 16 of the full scale 65535: those of Y'CbCr by the matrix, others as they are.
static void widen_codes(uint16_t *out, const sheen_raster *coded, bool is_ycbcr, const sheen_yuv_matrix *m)
{
    const size_t n_px = (size_t)coded->width_px * (size_t)coded->height_px;
    const uint8_t *codes = coded->data;
    if (is_ycbcr) {
        sheen_ycbcr_develop(out, codes, n_px, m);
        return;
    }
    for (size_t i = 0; i < n_px * (size_t)coded->n_channels; i++)
        out[i] = (uint16_t)(codes[i] * 257);
}

static sheen_status develop_jpeg(sheen_raster *out, const void *data, size_t size_bytes,
                                 const sheen_colorimetry *color, sheen_err *err)
{
    sheen_raster coded;
    sheen_yuv_matrix m;
    bool is_ycbcr;
    sheen_status s = sheen_yuv_matrix_of(&m, color, err);
    if (s || (s = sheen_jpeg_parse_coded(&coded, &is_ycbcr, data, size_bytes, err)))
        return s;
    s = sheen_raster_init(out, coded.width_px, coded.height_px, coded.n_channels, 16, err);
    if (!s) {
        widen_codes(out->data, &coded, is_ycbcr, &m);
        if (!is_ycbcr && color->quantization == V4L2_QUANTIZATION_LIM_RANGE)
            sheen_pixels_spread_limited(out);
    }
    sheen_raster_release(&coded);
    return s;
}

sheen_status sheen_payload_develop(sheen_raster *out, const void *data, size_t size_bytes,
                                   const sheen_pixel_layout *layout, sheen_err *err)
{
    *out = (sheen_raster){0};
    if (!is_picture_file(layout->fourcc))
        return sheen_pixels_develop(out, data, size_bytes, layout, err);
    const sheen_colorimetry color = jpeg_color(&layout->color);
    const bool is_jfif = color.quantization == V4L2_QUANTIZATION_FULL_RANGE &&
                         (color.ycbcr_enc == V4L2_YCBCR_ENC_601 || color.ycbcr_enc == V4L2_YCBCR_ENC_XV601);
    return is_jfif || !is_jpeg(data, size_bytes) ? sheen_raster_parse(out, data, size_bytes, err)
                                                 : develop_jpeg(out, data, size_bytes, &color, err);
}
