// SPDX-License-Identifier: Apache-2.0
// pixel_parts.h - what the pixel_*.c files share among themselves.
#ifndef SHEEN_BASE_PIXEL_PARTS_H
#define SHEEN_BASE_PIXEL_PARTS_H

#include "base/pixel_format.h"

typedef enum sheen_pixel_kind {
    SHEEN_PIXEL_YUYV,
    SHEEN_PIXEL_NV12,
    SHEEN_PIXEL_GREY,
    SHEEN_PIXEL_RGB,
    SHEEN_PIXEL_BAYER
} sheen_pixel_kind;

typedef struct sheen_pixel_format {
    uint32_t fourcc;
    sheen_pixel_kind kind;
    int bits;      // of a sample; 10 to 16 stand in two bytes, the low one first, if not packed
    bool packed;   // MIPI's way: the high bytes of a group, then their low bits
    int red;       // mosaics: place of red in the 2 x 2 cell, x + 2 y. RGB: byte of red
    int row_bytes; // of 4 pixels
} sheen_pixel_format;

// One row of single samples into 16 bits each, full scale 65535.
void sheen_pixels_unpack(uint16_t *out, const uint8_t *row, int width_px, const sheen_pixel_format *f);

// A mosaic of width x height samples into RGB: Malvar, He, Cutler, "High-quality linear interpolation for demosaicing
// of Bayer-patterned color images" (ICASSP 2004). red: as above. Sides of 2 and more.
void sheen_bayer_develop(uint16_t *rgb, const uint16_t *mosaic, int width_px, int height_px, int red);

// How Y'CbCr becomes R'G'B' of full scale 65535. EUNSUP for a matrix that is not linear.
typedef struct sheen_yuv_matrix {
    float y_offset, y_scale, c_scale, v_red, u_green, v_green, u_blue;
} sheen_yuv_matrix;
sheen_status sheen_yuv_matrix_of(sheen_yuv_matrix *m, const sheen_colorimetry *color, sheen_err *err);
void sheen_yuyv_develop(uint16_t *rgb, const uint8_t *data, const sheen_pixel_layout *l,
                        const sheen_yuv_matrix *m);
void sheen_nv12_develop(uint16_t *rgb, const uint8_t *data, const sheen_pixel_layout *l,
                        const sheen_yuv_matrix *m);
// Y', Cb, Cr of each pixel in turn.
void sheen_ycbcr_develop(uint16_t *rgb, const uint8_t *ycbcr, size_t n_px, const sheen_yuv_matrix *m);

// Grey and RGB of 16 bits in limited range (video levels) are spread to the full one.
void sheen_pixels_spread_limited(sheen_raster *r);

#endif
