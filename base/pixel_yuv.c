// SPDX-License-Identifier: Apache-2.0
// pixel_yuv.c - Y'CbCr with shared chroma into R'G'B'.
//
// With Kr, Kb of the matrix: R' = Y' + 2 (1 - Kr) Cr, B' = Y' + 2 (1 - Kb) Cb, and Y' = Kr R' + (1 - Kr - Kb) G' + Kb B'.
// Limited range has Y' in 16..235 and chroma in 16..240, full range uses all codes.
#include <linux/videodev2.h>
#include <math.h>

#include "base/pixel_parts.h"

static bool coefficients(float *kr, float *kb, uint32_t encoding)
{
    switch (encoding) {
    case V4L2_YCBCR_ENC_601:
    case V4L2_YCBCR_ENC_XV601:
        *kr = 0.299f;
        *kb = 0.114f;
        return true;
    case V4L2_YCBCR_ENC_709:
    case V4L2_YCBCR_ENC_XV709:
        *kr = 0.2126f;
        *kb = 0.0722f;
        return true;
    case V4L2_YCBCR_ENC_BT2020:
        *kr = 0.2627f;
        *kb = 0.0593f;
        return true;
    case V4L2_YCBCR_ENC_SMPTE240M:
        *kr = 0.212f;
        *kb = 0.087f;
        return true;
    default:
        return false;
    }
}

sheen_status sheen_yuv_matrix_of(sheen_yuv_matrix *m, const sheen_colorimetry *color, sheen_err *err)
{
    float kr = 0, kb = 0;
    uint32_t encoding = color->ycbcr_enc, quantization = color->quantization;
    if (encoding == V4L2_YCBCR_ENC_DEFAULT)
        encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(color->colorspace);
    if (quantization == V4L2_QUANTIZATION_DEFAULT)
        quantization = V4L2_MAP_QUANTIZATION_DEFAULT(0, color->colorspace, encoding);
    if (!coefficients(&kr, &kb, encoding))
        return sheen_fail(err, SHEEN_EUNSUP, "V4L2's colour encoding %lu is not supported",
                          (unsigned long)encoding);
    const bool limited = quantization == V4L2_QUANTIZATION_LIM_RANGE;
    const float kg = 1 - kr - kb;
    m->y_offset = limited ? 16 : 0;
    m->y_scale = 65535.0f / (limited ? 219.0f : 255.0f);
    m->c_scale = 65535.0f / (limited ? 224.0f : 255.0f);
    m->v_red = 2 * (1 - kr);
    m->u_blue = 2 * (1 - kb);
    m->u_green = -2 * (1 - kb) * kb / kg;
    m->v_green = -2 * (1 - kr) * kr / kg;
    return SHEEN_OK;
}

static uint16_t clip(float x)
{
    return x <= 0 ? 0 : x >= 65535 ? 65535 : (uint16_t)lrintf(x);
}

// u and v in codes about 128.
static void put(uint16_t rgb[3], float y_code, float u_code, float v_code, const sheen_yuv_matrix *m)
{
    const float y = (y_code - m->y_offset) * m->y_scale;
    const float u = (u_code - 128) * m->c_scale, v = (v_code - 128) * m->c_scale;
    rgb[0] = clip(y + m->v_red * v);
    rgb[1] = clip(y + m->u_green * u + m->v_green * v);
    rgb[2] = clip(y + m->u_blue * u);
}

void sheen_ycbcr_develop(uint16_t *rgb, const uint8_t *ycbcr, size_t n_px, const sheen_yuv_matrix *m)
{
    for (size_t i = 0; i < 3 * n_px; i += 3)
        put(rgb + i, ycbcr[i], ycbcr[i + 1], ycbcr[i + 2], m);
}

// Chroma stands where every other luma sample does, from the first on; between two of them is their mean.
void sheen_yuyv_develop(uint16_t *rgb, const uint8_t *data, const sheen_pixel_layout *l,
                        const sheen_yuv_matrix *m)
{
    for (int y = 0; y < l->height_px; y++) {
        const uint8_t *row = data + (size_t)y * (size_t)l->stride_bytes;
        for (int x = 0; x < l->width_px; x++, rgb += 3) {
            const uint8_t *here = row + 4 * (x / 2);
            const uint8_t *next = x % 2 && x + 1 < l->width_px ? here + 4 : here;
            put(rgb, here[x % 2 * 2], 0.5f * (float)(here[1] + next[1]), 0.5f * (float)(here[3] + next[3]),
                m);
        }
    }
}

static int clamp(int i, int n)
{
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

// A chroma sample stands amid its four luma samples: each of those takes 9/16 of it and the rest of its neighbours.
void sheen_nv12_develop(uint16_t *rgb, const uint8_t *data, const sheen_pixel_layout *l,
                        const sheen_yuv_matrix *m)
{
    const size_t stride = (size_t)l->stride_bytes;
    const uint8_t *chroma = data + stride * (size_t)l->height_px;
    const int w = l->width_px / 2, h = l->height_px / 2;
    for (int y = 0; y < l->height_px; y++) {
        const uint8_t *near_row = chroma + stride * (size_t)(y / 2);
        const uint8_t *far_row = chroma + stride * (size_t)clamp(y / 2 + (y % 2 ? 1 : -1), h);
        for (int x = 0; x < l->width_px; x++, rgb += 3) {
            const int near_x = 2 * (x / 2), far_x = 2 * clamp(x / 2 + (x % 2 ? 1 : -1), w);
            float uv[2];
            for (int c = 0; c < 2; c++)
                uv[c] = (float)(9 * near_row[near_x + c] + 3 * near_row[far_x + c] + 3 * far_row[near_x + c] +
                                far_row[far_x + c]) /
                        16;
            put(rgb, data[stride * (size_t)y + (size_t)x], uv[0], uv[1], m);
        }
    }
}
