// SPDX-License-Identifier: Apache-2.0
// pixel_format.c - the table of raw formats, their sizes and curves, and the way from bytes to samples.
#include "base/pixel_format.h"

#include <math.h>
#include <stdlib.h>

#include <linux/videodev2.h>

#include "base/pixel_parts.h"

// clang-format off
#define BAYER(bits, bytes4, packed, rg, gr, gb, bg)                                                                  \
    {rg, SHEEN_PIXEL_BAYER, bits, packed, 0, bytes4}, {gr, SHEEN_PIXEL_BAYER, bits, packed, 1, bytes4},              \
    {gb, SHEEN_PIXEL_BAYER, bits, packed, 2, bytes4}, {bg, SHEEN_PIXEL_BAYER, bits, packed, 3, bytes4}

static const sheen_pixel_format formats[] = {
    {V4L2_PIX_FMT_YUYV, SHEEN_PIXEL_YUYV, 8, false, 0, 8},
    {V4L2_PIX_FMT_NV12, SHEEN_PIXEL_NV12, 8, false, 0, 4},
    {V4L2_PIX_FMT_GREY, SHEEN_PIXEL_GREY, 8, false, 0, 4},
    {V4L2_PIX_FMT_Y10, SHEEN_PIXEL_GREY, 10, false, 0, 8},
    {V4L2_PIX_FMT_Y12, SHEEN_PIXEL_GREY, 12, false, 0, 8},
    {V4L2_PIX_FMT_Y16, SHEEN_PIXEL_GREY, 16, false, 0, 8},
    {V4L2_PIX_FMT_RGB24, SHEEN_PIXEL_RGB, 8, false, 0, 12},
    {V4L2_PIX_FMT_BGR24, SHEEN_PIXEL_RGB, 8, false, 2, 12},
    BAYER(8, 4, false, V4L2_PIX_FMT_SRGGB8, V4L2_PIX_FMT_SGRBG8, V4L2_PIX_FMT_SGBRG8, V4L2_PIX_FMT_SBGGR8),
    BAYER(10, 8, false, V4L2_PIX_FMT_SRGGB10, V4L2_PIX_FMT_SGRBG10, V4L2_PIX_FMT_SGBRG10, V4L2_PIX_FMT_SBGGR10),
    BAYER(10, 5, true, V4L2_PIX_FMT_SRGGB10P, V4L2_PIX_FMT_SGRBG10P, V4L2_PIX_FMT_SGBRG10P, V4L2_PIX_FMT_SBGGR10P),
    BAYER(12, 8, false, V4L2_PIX_FMT_SRGGB12, V4L2_PIX_FMT_SGRBG12, V4L2_PIX_FMT_SGBRG12, V4L2_PIX_FMT_SBGGR12),
    BAYER(12, 6, true, V4L2_PIX_FMT_SRGGB12P, V4L2_PIX_FMT_SGRBG12P, V4L2_PIX_FMT_SGBRG12P, V4L2_PIX_FMT_SBGGR12P),
    BAYER(14, 8, false, V4L2_PIX_FMT_SRGGB14, V4L2_PIX_FMT_SGRBG14, V4L2_PIX_FMT_SGBRG14, V4L2_PIX_FMT_SBGGR14),
    BAYER(16, 8, false, V4L2_PIX_FMT_SRGGB16, V4L2_PIX_FMT_SGRBG16, V4L2_PIX_FMT_SGBRG16, V4L2_PIX_FMT_SBGGR16),
};
// clang-format on

static const sheen_pixel_format *find(uint32_t fourcc)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (formats[i].fourcc == fourcc)
            return &formats[i];
    return NULL;
}

bool sheen_pixels_known(uint32_t fourcc)
{
    return find(fourcc) != NULL;
}

// Sides that the format's groups of pixels allow.
static bool sides_fit(const sheen_pixel_format *f, int width_px, int height_px)
{
    if (width_px < 1 || height_px < 1 || width_px > SHEEN_IMAGE_MAX_SIDE_PX ||
        height_px > SHEEN_IMAGE_MAX_SIDE_PX)
        return false;
    if (f->kind == SHEEN_PIXEL_BAYER && (width_px < 2 || height_px < 2))
        return false;
    if (f->kind == SHEEN_PIXEL_NV12 && height_px % 2)
        return false;
    if (f->packed)
        return width_px % (f->bits == 10 ? 4 : 2) == 0;
    return width_px % 2 == 0 || (f->kind != SHEEN_PIXEL_YUYV && f->kind != SHEEN_PIXEL_NV12);
}

static size_t row_bytes(const sheen_pixel_format *f, int width_px)
{
    return (size_t)width_px * (size_t)f->row_bytes / 4;
}

size_t sheen_pixels_stride(uint32_t fourcc, int width_px)
{
    const sheen_pixel_format *f = find(fourcc);
    return f && sides_fit(f, width_px, 2) ? row_bytes(f, width_px) : 0;
}

size_t sheen_pixels_size(const sheen_pixel_layout *l)
{
    const sheen_pixel_format *f = find(l->fourcc);
    if (!f || !sides_fit(f, l->width_px, l->height_px) || l->stride_bytes < 0 ||
        (size_t)l->stride_bytes < row_bytes(f, l->width_px))
        return 0;
    const size_t n_rows = (size_t)l->height_px + (f->kind == SHEEN_PIXEL_NV12 ? (size_t)l->height_px / 2 : 0);
    return (n_rows - 1) * (size_t)l->stride_bytes + row_bytes(f, l->width_px);
}

sheen_status sheen_pixels_transfer(sheen_transfer *out, uint32_t fourcc, const sheen_colorimetry *color,
                                   sheen_err *err)
{
    const sheen_pixel_format *f = find(fourcc);
    uint32_t curve = color->xfer_func;
    if (curve == V4L2_XFER_FUNC_DEFAULT)
        curve = f && f->kind == SHEEN_PIXEL_BAYER ? (uint32_t)V4L2_XFER_FUNC_NONE
                                                  : (uint32_t)V4L2_MAP_XFER_FUNC_DEFAULT(color->colorspace);
    switch (curve) {
    case V4L2_XFER_FUNC_709:
    case V4L2_XFER_FUNC_SMPTE240M: // within half a percent of it
        *out = SHEEN_TRANSFER_REC709;
        return SHEEN_OK;
    case V4L2_XFER_FUNC_SRGB:
        *out = SHEEN_TRANSFER_SRGB;
        return SHEEN_OK;
    case V4L2_XFER_FUNC_OPRGB:
        *out = SHEEN_TRANSFER_GAMMA22;
        return SHEEN_OK;
    case V4L2_XFER_FUNC_NONE:
        *out = SHEEN_TRANSFER_LINEAR;
        return SHEEN_OK;
    default:
        return sheen_fail(err, SHEEN_EUNSUP, "V4L2's transfer function %lu is not supported",
                          (unsigned long)curve);
    }
}

// A code of `bits` bits to 16 so that the largest becomes 65535.
static uint16_t widen(uint32_t code, int bits)
{
    const uint32_t max = (UINT32_C(1) << bits) - 1;
    const uint32_t c = code > max ? max : code;
    return (uint16_t)((c * UINT32_C(65535) + max / 2) / max);
}

void sheen_pixels_unpack(uint16_t *out, const uint8_t *row, int width_px, const sheen_pixel_format *f)
{
    const int group = f->bits == 10 ? 4 : 2, low_bits = f->bits - 8;
    for (int x = 0; x < width_px; x++) {
        uint32_t code;
        if (f->packed) {
            const uint8_t *g = row + x / group * (group + 1);
            const uint32_t low = (uint32_t)g[group] >> (low_bits * (x % group)) & ((1u << low_bits) - 1);
            code = (uint32_t)g[x % group] << low_bits | low;
        } else if (f->bits == 8)
            code = row[x];
        else
            code = (uint32_t)row[2 * x] | (uint32_t)row[2 * x + 1] << 8;
        out[x] = widen(code, f->bits);
    }
}

void sheen_pixels_spread_limited(sheen_raster *r)
{
    uint16_t *v = r->data;
    const size_t n = (size_t)r->width_px * (size_t)r->height_px * (size_t)r->n_channels;
    for (size_t i = 0; i < n; i++) {
        const float y = ((float)v[i] / 65535 - 16 / 255.0f) * (255 / 219.0f);
        v[i] = y <= 0 ? 0 : y >= 1 ? 65535 : (uint16_t)lrintf(y * 65535);
    }
}

static void develop_plain(sheen_raster *out, const uint8_t *data, const sheen_pixel_layout *l,
                          const sheen_pixel_format *f)
{
    uint16_t *to = out->data;
    for (int y = 0; y < l->height_px; y++) {
        const uint8_t *row = data + (size_t)y * (size_t)l->stride_bytes;
        if (f->kind == SHEEN_PIXEL_GREY)
            sheen_pixels_unpack(to + (size_t)y * (size_t)l->width_px, row, l->width_px, f);
        else
            for (int x = 0; x < l->width_px; x++)
                for (int c = 0; c < 3; c++)
                    *to++ = widen(row[3 * x + (f->red ? 2 - c : c)], 8);
    }
    const bool limited = l->color.quantization == V4L2_QUANTIZATION_LIM_RANGE;
    if (limited)
        sheen_pixels_spread_limited(out);
}

static sheen_status develop(sheen_raster *out, const uint8_t *data, const sheen_pixel_layout *l,
                            const sheen_pixel_format *f, sheen_err *err)
{
    if (f->kind == SHEEN_PIXEL_YUYV || f->kind == SHEEN_PIXEL_NV12) {
        sheen_yuv_matrix m;
        const sheen_status s = sheen_yuv_matrix_of(&m, &l->color, err);
        if (!s && f->kind == SHEEN_PIXEL_YUYV)
            sheen_yuyv_develop(out->data, data, l, &m);
        else if (!s)
            sheen_nv12_develop(out->data, data, l, &m);
        return s;
    }
    develop_plain(out, data, l, f);
    return SHEEN_OK;
}

// The format of a payload that is whole, and an empty raster for it.
static sheen_status begin(const sheen_pixel_format **f, sheen_raster *out, size_t size_bytes,
                          const sheen_pixel_layout *layout, sheen_err *err)
{
    *out = (sheen_raster){0};
    *f = find(layout->fourcc);
    if (!*f)
        return sheen_fail(err, SHEEN_EUNSUP,
                          "raw data of this format cannot be developed: V4L2's code 0x%08lx",
                          (unsigned long)layout->fourcc);
    const size_t needed_bytes = sheen_pixels_size(layout);
    if (!needed_bytes)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "no raw frame of this format is %d x %d px with rows of %d bytes", layout->width_px,
                          layout->height_px, layout->stride_bytes);
    if (size_bytes < needed_bytes)
        return sheen_fail(err, SHEEN_EFORMAT, "the raw frame is cut short: %zu of %zu bytes", size_bytes,
                          needed_bytes);
    const bool one = (*f)->kind == SHEEN_PIXEL_GREY || (*f)->kind == SHEEN_PIXEL_BAYER;
    return sheen_raster_init(out, layout->width_px, layout->height_px, one ? 1 : 3, 16, err);
}

bool sheen_pixels_is_mosaic(uint32_t fourcc)
{
    const sheen_pixel_format *f = find(fourcc);
    return f && f->kind == SHEEN_PIXEL_BAYER;
}

sheen_status sheen_pixels_mosaic(sheen_raster *out, const void *data, size_t size_bytes,
                                 const sheen_pixel_layout *layout, sheen_err *err)
{
    const sheen_pixel_format *f;
    const sheen_status s = begin(&f, out, size_bytes, layout, err);
    if (s)
        return s;
    if (f->kind != SHEEN_PIXEL_BAYER) {
        sheen_raster_release(out);
        return sheen_fail(err, SHEEN_EUNSUP, "the format is no mosaic");
    }
    const size_t w = (size_t)layout->width_px;
    for (size_t y = 0; y < (size_t)layout->height_px; y++)
        sheen_pixels_unpack((uint16_t *)out->data + y * w,
                            (const uint8_t *)data + y * (size_t)layout->stride_bytes, layout->width_px, f);
    return SHEEN_OK;
}

sheen_status sheen_mosaic_develop(sheen_raster *out, const sheen_raster *mosaic, uint32_t fourcc,
                                  sheen_err *err)
{
    const sheen_pixel_format *f = find(fourcc);
    *out = (sheen_raster){0};
    if (!f || f->kind != SHEEN_PIXEL_BAYER)
        return sheen_fail(err, SHEEN_EUNSUP, "the format is no mosaic");
    const sheen_status s = sheen_raster_init(out, mosaic->width_px, mosaic->height_px, 3, 16, err);
    if (!s)
        sheen_bayer_develop(out->data, mosaic->data, mosaic->width_px, mosaic->height_px, f->red);
    return s;
}

sheen_status sheen_pixels_develop(sheen_raster *out, const void *data, size_t size_bytes,
                                  const sheen_pixel_layout *layout, sheen_err *err)
{
    sheen_raster mosaic;
    const sheen_pixel_format *f;
    sheen_status s;
    *out = (sheen_raster){0};
    if (sheen_pixels_is_mosaic(layout->fourcc)) {
        s = sheen_pixels_mosaic(&mosaic, data, size_bytes, layout, err);
        if (!s)
            s = sheen_mosaic_develop(out, &mosaic, layout->fourcc, err);
        sheen_raster_release(&mosaic);
        return s;
    }
    s = begin(&f, out, size_bytes, layout, err);
    if (!s)
        s = develop(out, data, layout, f, err);
    if (s)
        sheen_raster_release(out);
    return s;
}
