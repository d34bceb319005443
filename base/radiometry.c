// SPDX-License-Identifier: Apache-2.0
// radiometry.c - from codes to light: dark frame off, curve undone, flat field divided out.
//
// What is left once the dark frame d is off is spread by the dark frame's mean D, (x - d) / (1 - D), so that full scale
// stays 1; a value that was saturated stays so, also where the pixel is hot. The gain is 1 and more for the same reason.
#include <math.h>
#include <stdlib.h>

#include "base/radiometry_private.h"

sheen_status sheen_frame_codes(sheen_raster *out, const sheen_frame_info *f, const void *payload,
                               size_t size_bytes, sheen_err *err)
{
    const sheen_pixel_layout layout = {f->fourcc, f->width_px, f->height_px, f->stride_bytes, f->color};
    return sheen_pixels_is_mosaic(f->fourcc) ? sheen_pixels_mosaic(out, payload, size_bytes, &layout, err)
                                             : sheen_payload_develop(out, payload, size_bytes, &layout, err);
}

static const float saturated_from = 0.995f, level_most = 0.5f;

static float less_dark(float x, float dark, float level)
{
    return x >= saturated_from ? 1 : x <= dark ? 0 : (x - dark) / (1 - level);
}

// The mosaic less the dark one.
static sheen_status mosaic_less_dark(sheen_raster *out, const sheen_raster *mosaic, const sheen_raster *dark,
                                     sheen_err *err)
{
    const size_t n = (size_t)mosaic->width_px * (size_t)mosaic->height_px;
    const sheen_status s = sheen_raster_init(out, mosaic->width_px, mosaic->height_px, 1, 16, err);
    if (s)
        return s;
    const uint16_t *x = mosaic->data, *d = dark->data;
    uint16_t *y = out->data;
    uint64_t sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += d[i];
    const float full = 65535, level = fminf(level_most, (float)((double)sum / (double)n) / full);
    for (size_t i = 0; i < n; i++)
        y[i] = (uint16_t)(fminf(1, less_dark((float)x[i] / full, (float)d[i] / full, level)) * full + 0.5f);
    return SHEEN_OK;
}

static void light_less_dark(sheen_image *light, const sheen_image *dark)
{
    const size_t n = (size_t)light->width_px * (size_t)light->height_px * 3;
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (double)dark->data[i];
    const float level = fminf(level_most, (float)(sum / (double)n));
    for (size_t i = 0; i < n; i++)
        light->data[i] = less_dark(light->data[i], dark->data[i], level);
}

static sheen_status light_by_curve(sheen_image *out, const sheen_radiometry *r, const sheen_frame_info *f,
                                   const sheen_raster *codes, sheen_err *err)
{
    return r->response.data ? sheen_image_from_curve(out, codes, r->response.data, r->response.width_px, err)
                            : sheen_image_from_raster(out, codes, f->transfer, err);
}

static sheen_status light_of_mosaic(sheen_image *out, const sheen_radiometry *r, const sheen_frame_info *f,
                                    const sheen_raster *mosaic, sheen_err *err)
{
    sheen_raster less = {0}, rgb = {0};
    sheen_status s = r->dark.data ? mosaic_less_dark(&less, mosaic, &r->dark, err) : SHEEN_OK;
    if (!s)
        s = sheen_mosaic_develop(&rgb, r->dark.data ? &less : mosaic, f->fourcc, err);
    if (!s)
        s = light_by_curve(out, r, f, &rgb, err);
    sheen_raster_release(&less);
    sheen_raster_release(&rgb);
    return s;
}

sheen_status sheen_radiometry_light(sheen_image *out, const sheen_radiometry *r, const sheen_frame_info *f,
                                    const sheen_raster *codes, sheen_err *err)
{
    *out = (sheen_image){0};
    const bool is_mosaic = f->fourcc && sheen_pixels_is_mosaic(f->fourcc);
    if (r->dark.data && (r->dark.width_px != codes->width_px || r->dark.height_px != codes->height_px ||
                         (r->dark.n_channels == 1) != (codes->n_channels == 1)))
        return sheen_fail(err, SHEEN_EFORMAT, "its dark frame is of another size or kind");
    if (is_mosaic)
        return light_of_mosaic(out, r, f, codes, err);
    sheen_image dark = {0};
    sheen_status s = light_by_curve(out, r, f, codes, err);
    if (s || !r->dark.data)
        return s;
    s = light_by_curve(&dark, r, f, &r->dark, err);
    if (!s)
        light_less_dark(out, &dark);
    sheen_image_release(&dark);
    if (s)
        sheen_image_release(out);
    return s;
}

static sheen_status apply_gain(sheen_image *img, const sheen_image *gain, sheen_err *err)
{
    if (gain->width_px != img->width_px || gain->height_px != img->height_px)
        return sheen_fail(err, SHEEN_EFORMAT, "its flat field is %d x %d px and it %d x %d", gain->width_px,
                          gain->height_px, img->width_px, img->height_px);
    const size_t n = (size_t)img->width_px * (size_t)img->height_px * 3;
    for (size_t i = 0; i < n; i++)
        img->data[i] *= gain->data[i];
    return SHEEN_OK;
}

sheen_status sheen_radiometry_develop(sheen_image *out, const sheen_radiometry *r, const sheen_frame_info *f,
                                      const void *payload, size_t size_bytes, sheen_err *err)
{
    static const sheen_radiometry none = {0};
    sheen_raster codes;
    *out = (sheen_image){0};
    sheen_status s = sheen_frame_codes(&codes, f, payload, size_bytes, err);
    if (s)
        return s;
    s = sheen_radiometry_light(out, r && !f->bracket.n_exposures ? r : &none, f, &codes, err);
    sheen_raster_release(&codes);
    if (!s && r && r->gain.data)
        s = apply_gain(out, &r->gain, err);
    if (s)
        sheen_image_release(out);
    return s;
}

void sheen_radiometry_release(sheen_radiometry *r)
{
    sheen_raster_release(&r->dark);
    sheen_image_release(&r->gain);
    sheen_image_release(&r->response);
    *r = (sheen_radiometry){0};
}
