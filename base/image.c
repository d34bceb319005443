// SPDX-License-Identifier: Apache-2.0
// image.c - pictures in memory: allocation, sampling, and code values turned into light and back.
#include "base/image.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static bool sides_fit(int width_px, int height_px)
{
    return width_px >= 1 && height_px >= 1 && width_px <= SHEEN_IMAGE_MAX_SIDE_PX &&
           height_px <= SHEEN_IMAGE_MAX_SIDE_PX;
}

// Pages that calloc gives are not in memory before they are written to: a picture that turns out to be
// broken after a few rows has cost only those rows.
static sheen_status allocate(void **data_out, int width_px, int height_px, int n_channels,
                             size_t sample_bytes, sheen_err *err)
{
    if (!sides_fit(width_px, height_px))
        return sheen_fail(err, SHEEN_EARG, "a picture of %d x %d px is out of range: sides are 1 to %d px",
                          width_px, height_px, SHEEN_IMAGE_MAX_SIDE_PX);
    if (n_channels < 1 || n_channels > 4)
        return sheen_fail(err, SHEEN_EARG, "a picture has 1 to 4 channels, not %d", n_channels);
    const size_t n = (size_t)width_px * (size_t)height_px * (size_t)n_channels;
    *data_out = calloc(n, sample_bytes);
    if (!*data_out)
        return sheen_fail_memory(err, (double)n * (double)sample_bytes, "a picture");
    return SHEEN_OK;
}

sheen_status sheen_image_init(sheen_image *img, int width_px, int height_px, int n_channels, sheen_err *err)
{
    *img = (sheen_image){0};
    void *data = NULL;
    const sheen_status s = allocate(&data, width_px, height_px, n_channels, sizeof(float), err);
    if (!s)
        *img = (sheen_image){data, width_px, height_px, n_channels};
    return s;
}

void sheen_image_release(sheen_image *img)
{
    free(img->data);
    *img = (sheen_image){0};
}

sheen_status sheen_raster_init(sheen_raster *r, int width_px, int height_px, int n_channels, int bits,
                               sheen_err *err)
{
    *r = (sheen_raster){0};
    if (bits != 8 && bits != 16 && bits != 32)
        return sheen_fail(err, SHEEN_EARG, "a picture has 8, 16 or 32 bits a sample, not %d", bits);
    void *data = NULL;
    const sheen_status s = allocate(&data, width_px, height_px, n_channels, (size_t)bits / 8, err);
    if (!s)
        *r = (sheen_raster){data, width_px, height_px, n_channels, bits};
    return s;
}

void sheen_raster_release(sheen_raster *r)
{
    free(r->data);
    *r = (sheen_raster){0};
}

// On the last column or row the neighbour beyond has no weight: any pixel may stand in for it.
int sheen_image_bilinear(float *out, const sheen_image *img, double x_px, double y_px)
{
    const int right = img->width_px - 1, bottom = img->height_px - 1;
    if (!(x_px >= 0 && y_px >= 0 && x_px <= right && y_px <= bottom)) // NaN too
        return 0;
    const int x = (int)x_px, y = (int)y_px;
    const float fx = (float)(x_px - x), fy = (float)(y_px - y);
    const int dx = x < right, dy = y < bottom;
    const float *p00 = sheen_image_at(img, x, y), *p10 = sheen_image_at(img, x + dx, y);
    const float *p01 = sheen_image_at(img, x, y + dy), *p11 = sheen_image_at(img, x + dx, y + dy);
    for (int c = 0; c < img->n_channels; c++) {
        const float top = p00[c] + fx * (p10[c] - p00[c]);
        const float low = p01[c] + fx * (p11[c] - p01[c]);
        out[c] = top + fy * (low - top);
    }
    return 1;
}

static const char *const transfer_names[SHEEN_TRANSFER_COUNT] = {"srgb", "linear", "rec709", "gamma22"};

const char *sheen_transfer_name(sheen_transfer t)
{
    assert(t < SHEEN_TRANSFER_COUNT);
    return transfer_names[t];
}

sheen_status sheen_transfer_from_name(sheen_transfer *out, const char *name, sheen_err *err)
{
    for (int i = 0; i < SHEEN_TRANSFER_COUNT; i++)
        if (!strcmp(name, transfer_names[i])) {
            *out = (sheen_transfer)i;
            return SHEEN_OK;
        }
    return sheen_fail(err, SHEEN_EARG, "unknown transfer '%.40s': use srgb, linear, rec709 or gamma22", name);
}

float sheen_transfer_decode(sheen_transfer t, float code)
{
    if (t == SHEEN_TRANSFER_LINEAR)
        return code;
    if (!(code > 0))
        return 0;
    if (code >= 1)
        return 1;
    switch (t) {
    case SHEEN_TRANSFER_SRGB:
        return code <= 0.04045f ? code / 12.92f : powf((code + 0.055f) / 1.055f, 2.4f);
    case SHEEN_TRANSFER_REC709:
        return code < 0.081f ? code / 4.5f : powf((code + 0.099f) / 1.099f, 1 / 0.45f);
    default:
        return powf(code, 2.2f);
    }
}

float sheen_transfer_encode(sheen_transfer t, float light)
{
    if (t == SHEEN_TRANSFER_LINEAR)
        return light;
    if (!(light > 0))
        return 0;
    if (light >= 1)
        return 1;
    switch (t) {
    case SHEEN_TRANSFER_SRGB:
        return light <= 0.0031308f ? light * 12.92f : 1.055f * powf(light, 1 / 2.4f) - 0.055f;
    case SHEEN_TRANSFER_REC709:
        return light < 0.018f ? light * 4.5f : 1.099f * powf(light, 0.45f) - 0.099f;
    default:
        return powf(light, 1 / 2.2f);
    }
}

// Which sample of a pixel stands for red, green, blue: grey is repeated, alpha never used.
static int channel_of(const sheen_raster *r, int c)
{
    return r->n_channels >= 3 ? c : 0;
}

// How codes become light: by a curve with a name, or by a measured one (light not NULL).
typedef struct curve {
    sheen_transfer transfer;
    const float *light;
    int n_light;
} curve;

static float light_of(const curve *by, float code)
{
    if (!by->light)
        return sheen_transfer_decode(by->transfer, code);
    const float at = code * (float)(by->n_light - 1);
    const int i = at < (float)(by->n_light - 2) ? (int)at : by->n_light - 2;
    return by->light[i] + (at - (float)i) * (by->light[i + 1] - by->light[i]);
}

// Code values are few: one table entry each, then one look-up a sample.
static sheen_status convert_coded(float *out, const sheen_raster *r, const curve *by, sheen_err *err)
{
    const size_t n_codes = (size_t)1 << r->bits, n_px = (size_t)r->width_px * (size_t)r->height_px;
    float *table = malloc(n_codes * sizeof *table);
    if (!table)
        return sheen_fail_memory(err, (double)(n_codes * sizeof *table), "a table of code values");
    for (size_t i = 0; i < n_codes; i++)
        table[i] = light_of(by, (float)i / (float)(n_codes - 1));
    const uint8_t *in8 = r->data;
    const uint16_t *in16 = r->data;
    for (size_t i = 0; i < n_px; i++)
        for (int c = 0; c < 3; c++) {
            const size_t at = i * (size_t)r->n_channels + (size_t)channel_of(r, c);
            out[3 * i + (size_t)c] = table[r->bits == 8 ? in8[at] : in16[at]];
        }
    free(table);
    return SHEEN_OK;
}

// Squares and sums of it are still finite: what overflowed in the file is very bright, and no more.
static const float most_light = 1e9f;

static sheen_status image_from(sheen_image *out, const sheen_raster *r, const curve *by, sheen_err *err)
{
    sheen_status s = sheen_image_init(out, r->width_px, r->height_px, 3, err);
    if (s)
        return s;
    if (r->bits != 32) {
        s = convert_coded(out->data, r, by, err);
        if (s)
            sheen_image_release(out);
        return s;
    }
    const float *in = r->data;
    const size_t n_px = (size_t)r->width_px * (size_t)r->height_px;
    for (size_t i = 0; i < n_px; i++)
        for (int c = 0; c < 3; c++) {
            const float light = in[i * (size_t)r->n_channels + (size_t)channel_of(r, c)];
            out->data[3 * i + (size_t)c] = isnan(light) ? 0 : fmaxf(-most_light, fminf(most_light, light));
        }
    return SHEEN_OK;
}

sheen_status sheen_image_from_raster(sheen_image *out, const sheen_raster *r, sheen_transfer transfer,
                                     sheen_err *err)
{
    const curve by = {.transfer = transfer};
    return image_from(out, r, &by, err);
}

sheen_status sheen_image_from_curve(sheen_image *out, const sheen_raster *r, const float *light, int n_light,
                                    sheen_err *err)
{
    const curve by = {.light = light, .n_light = n_light};
    return image_from(out, r, &by, err);
}

// Luma of pixel i as the file codes it, full scale 1; 0 for what is not finite.
static float luma_at(const sheen_raster *r, size_t i)
{
    float rgb[3];
    for (int c = 0; c < 3; c++) {
        const size_t at = i * (size_t)r->n_channels + (size_t)channel_of(r, c);
        if (r->bits == 8)
            rgb[c] = (float)((const uint8_t *)r->data)[at] * (1.0f / 255);
        else if (r->bits == 16)
            rgb[c] = (float)((const uint16_t *)r->data)[at] * (1.0f / 65535);
        else
            rgb[c] = ((const float *)r->data)[at];
    }
    const float y = sheen_luminance(rgb);
    return isfinite(y) ? y : 0;
}

// The value below which all but `n_above` of the pixels lie, or 1 where that is brighter: by a histogram, and
// then one more of the bin that it fell into (good to 1e-6 of full scale, without a sorted copy).
static float luma_with_above(const sheen_raster *r, size_t n_px, size_t n_above)
{
    enum { N_BINS = 1024 };
    float low = 0, width = 1;
    for (int round = 0; round < 2; round++) {
        size_t counts[N_BINS] = {0}, above = 0;
        for (size_t i = 0; i < n_px; i++) {
            const float bin = (luma_at(r, i) - low) / width * (float)N_BINS;
            if (bin >= (float)N_BINS)
                above++;
            else if (bin >= 0)
                counts[(int)bin]++;
        }
        if (above > n_above)
            return low + width; // first round: the picture is bright enough; second: rounding of a bin's edge
        int bin = N_BINS - 1;
        while (bin > 0 && above + counts[bin] <= n_above)
            above += counts[bin--];
        low += width * (float)bin / (float)N_BINS;
        width /= (float)N_BINS;
    }
    return low + width;
}

void sheen_raster_grey(uint8_t *out, const sheen_raster *r, sheen_transfer transfer)
{
    const size_t n_px = (size_t)r->width_px * (size_t)r->height_px;
    if (transfer != SHEEN_TRANSFER_LINEAR && r->bits != 32) { // perceptual already
        for (size_t i = 0; i < n_px; i++)
            out[i] = (uint8_t)(luma_at(r, i) * 255 + 0.5f);
        return;
    }
    enum { N_STEPS = 16384 }; // 5 steps a grey level where sRGB is steepest
    uint8_t coded[N_STEPS + 1];
    for (int i = 0; i <= N_STEPS; i++)
        coded[i] = (uint8_t)(sheen_transfer_encode(SHEEN_TRANSFER_SRGB, (float)i / (float)N_STEPS) * 255 +
                             0.5f);
    const float scale = 1 / luma_with_above(r, n_px, n_px / 200); // 99.5th percentile to white
    for (size_t i = 0; i < n_px; i++) {
        const float light = luma_at(r, i) * scale;
        out[i] = coded[(int)(fminf(fmaxf(light, 0), 1) * (float)N_STEPS + 0.5f)];
    }
}

sheen_status sheen_image_from_grey(sheen_image *out, const sheen_raster *r, sheen_transfer transfer,
                                   sheen_err *err)
{
    const size_t n = (size_t)r->width_px * (size_t)r->height_px;
    uint8_t *grey = malloc(n + 1);
    *out = (sheen_image){0};
    const sheen_status s = grey ? sheen_image_init(out, r->width_px, r->height_px, 1, err)
                                : sheen_fail_memory(err, (double)n, "a picture");
    if (!s) {
        sheen_raster_grey(grey, r, transfer);
        for (size_t i = 0; i < n; i++)
            out->data[i] = (float)grey[i] / 255;
    }
    free(grey);
    return s;
}

sheen_status sheen_raster_from_linear(sheen_raster *out, const sheen_image *lin, sheen_err *err)
{
    const sheen_status s = sheen_raster_init(out, lin->width_px, lin->height_px, lin->n_channels, 8, err);
    const size_t n_channels = (size_t)lin->n_channels;
    const size_t n = s ? 0 : (size_t)lin->width_px * (size_t)lin->height_px * n_channels;
    uint8_t *to = out->data;
    for (size_t i = 0; i < n; i++) {
        const float x = lin->data[i], clipped = x >= 1 ? 1 : x > 0 ? x : 0;
        const float code = i % n_channels == 3 ? clipped
                                               : sheen_transfer_encode(SHEEN_TRANSFER_SRGB, clipped);
        to[i] = (uint8_t)(code * 255 + 0.5f);
    }
    return s;
}
