// SPDX-License-Identifier: Apache-2.0
// image.h - pictures in memory: as decoded (sheen_raster) and as linear light (sheen_image).
//
// Pixel (0,0) is the centre of the top-left pixel. Rows run from the top; channels are
// interleaved R, G, B. fit and render see sheen_image only.
#ifndef SHEEN_BASE_IMAGE_H
#define SHEEN_BASE_IMAGE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_IMAGE_MAX_SIDE_PX = 32768 };

// Linear light, float; [height_px][width_px][n_channels].
typedef struct sheen_image {
    float *data;
    int width_px, height_px, n_channels;
} sheen_image;

// Allocates, all zero. n_channels 1 to 4. EARG for sides outside 1..32768, ENOMEM.
sheen_status sheen_image_init(sheen_image *img, int width_px, int height_px, int n_channels, sheen_err *err);
void sheen_image_release(sheen_image *img);

static inline float *sheen_image_at(const sheen_image *img, int x, int y)
{
    return img->data + ((size_t)y * (size_t)img->width_px + (size_t)x) * (size_t)img->n_channels;
}

// Bilinear sample of all channels at (x, y) px; false (out untouched) where a neighbour
// would lie outside the image.
int sheen_image_bilinear(float *out, const sheen_image *img, double x_px, double y_px);

// How numbers in a file stand for light.
typedef enum sheen_transfer {
    SHEEN_TRANSFER_SRGB,   // IEC 61966-2-1
    SHEEN_TRANSFER_LINEAR, // full scale = 1
    SHEEN_TRANSFER_REC709, // ITU-R BT.709, as video cameras claim
    SHEEN_TRANSFER_GAMMA22,
    SHEEN_TRANSFER_COUNT
} sheen_transfer;

const char *sheen_transfer_name(sheen_transfer t); // "srgb", "linear", "rec709", "gamma22"
sheen_status sheen_transfer_from_name(sheen_transfer *out, const char *name, sheen_err *err);
// Code value (0..1) to light (0..1 and, for linear, beyond), and back.
float sheen_transfer_decode(sheen_transfer t, float code);
float sheen_transfer_encode(sheen_transfer t, float light);

// A file as decoded: interleaved samples of 8 or 16 bits (native order, full scale 255 or
// 65535) or 32-bit float. n_channels: 1 grey, 2 grey+alpha, 3 RGB, 4 RGBA.
typedef struct sheen_raster {
    void *data;
    int width_px, height_px, n_channels, bits;
} sheen_raster;

sheen_status sheen_raster_init(sheen_raster *r, int width_px, int height_px, int n_channels, int bits,
                               sheen_err *err);
void sheen_raster_release(sheen_raster *r);

// RGB (3 channels; grey is repeated) in linear light. Alpha is dropped. Float rasters are
// linear whatever `transfer` says; NaN becomes 0, and more than 1e9 (either way) is 1e9.
sheen_status sheen_image_from_raster(sheen_image *out, const sheen_raster *r, sheen_transfer transfer,
                                     sheen_err *err);
// The same by a measured curve instead: light at n_light (2 and more) codes evenly from 0 to 1, straight between them.
sheen_status sheen_image_from_curve(sheen_image *out, const sheen_raster *r, const float *light, int n_light,
                                    sheen_err *err);

// 8-bit sRGB of a linear image of 1, 3 or 4 channels, clipped to 0..1; alpha stays linear. ENOMEM.
sheen_status sheen_raster_from_linear(sheen_raster *out, const sheen_image *lin, sheen_err *err);

// One channel of 8-bit luma as a detector wants it: perceptual code values (linear and float
// input is sRGB-coded after scaling its 99.5th percentile to white where it is darker).
// out holds width_px * height_px bytes.
void sheen_raster_grey(uint8_t *out, const sheen_raster *r, sheen_transfer transfer);
// The same as an image of one channel, 0..1: brightness in equal steps for the eye.
sheen_status sheen_image_from_grey(sheen_image *out, const sheen_raster *r, sheen_transfer transfer,
                                   sheen_err *err);

// Y of linear RGB by Rec. 709, the Y of the paper's YCrCb.
static inline float sheen_luminance(const float rgb[3])
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

#ifdef __cplusplus
}
#endif
#endif
