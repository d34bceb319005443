// SPDX-License-Identifier: Apache-2.0
// image_file.c - tells image formats apart and hands over to the one library that reads each.
#include "base/image_file.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_codec.h"

enum { MAX_FILE_BYTES = 1 << 30 };

typedef struct codec {
    const char *magic;
    size_t magic_bytes;
    sheen_status (*parse)(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err);
    sheen_status (*probe)(int *width_px, int *height_px, const void *data, size_t size_bytes, sheen_err *err);
} codec;

static const codec codecs[] = {
    {"\x89PNG\r\n\x1a\n", 8, sheen_png_parse, sheen_png_probe},
    {"\xff\xd8\xff", 3, sheen_jpeg_parse, sheen_jpeg_probe},
    {"II*\0", 4, sheen_tiff_parse, sheen_tiff_probe},
    {"MM\0*", 4, sheen_tiff_parse, sheen_tiff_probe},
    {"II+\0", 4, sheen_tiff_parse, sheen_tiff_probe}, // BigTIFF
    {"MM\0+", 4, sheen_tiff_parse, sheen_tiff_probe},
    {"\x76\x2f\x31\x01", 4, sheen_exr_parse, sheen_exr_probe},
    {"#?RADIANCE", 10, sheen_hdr_parse, sheen_hdr_probe},
    {"#?RGBE", 6, sheen_hdr_parse, sheen_hdr_probe},
};

// NULL: none of the formats.
static const codec *find_codec(const void *data, size_t size_bytes)
{
    for (size_t i = 0; i < sizeof codecs / sizeof *codecs; i++)
        if (size_bytes >= codecs[i].magic_bytes && !memcmp(data, codecs[i].magic, codecs[i].magic_bytes))
            return &codecs[i];
    return NULL;
}

static sheen_status fail_unknown(size_t size_bytes, sheen_err *err)
{
    if (!size_bytes)
        return sheen_fail(err, SHEEN_EFORMAT, "the file is empty");
    return sheen_fail(err, SHEEN_EFORMAT,
                      "not a picture that is read here: neither PNG, JPEG, TIFF, OpenEXR nor Radiance");
}

sheen_status sheen_raster_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err)
{
    *out = (sheen_raster){0};
    const codec *c = find_codec(data, size_bytes);
    return c ? c->parse(out, data, size_bytes, err) : fail_unknown(size_bytes, err);
}

sheen_status sheen_raster_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                                sheen_err *err)
{
    const codec *c = find_codec(data, size_bytes);
    return c ? c->probe(width_px, height_px, data, size_bytes, err) : fail_unknown(size_bytes, err);
}

sheen_status sheen_raster_load(sheen_raster *out, const char *path, sheen_err *err)
{
    *out = (sheen_raster){0};
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_FILE_BYTES, err);
    if (s)
        return s;
    s = sheen_raster_parse(out, data, size_bytes, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}

sheen_status sheen_image_check_sides(uint32_t width_px, uint32_t height_px, sheen_err *err)
{
    if (width_px < 1 || height_px < 1 || width_px > SHEEN_IMAGE_MAX_SIDE_PX ||
        height_px > SHEEN_IMAGE_MAX_SIDE_PX)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "its size of %lu x %lu px is out of range: sides are 1 to %d px",
                          (unsigned long)width_px, (unsigned long)height_px, SHEEN_IMAGE_MAX_SIDE_PX);
    return SHEEN_OK;
}

sheen_status sheen_image_check_claim(double decoded_bytes, size_t size_bytes, double max_ratio,
                                     double free_bytes, sheen_err *err)
{
    if (decoded_bytes > free_bytes && decoded_bytes > max_ratio * (double)size_bytes)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "the file's %zu bytes cannot hold the %.0f MB of picture that its header claims",
                          size_bytes, decoded_bytes / 1e6);
    return SHEEN_OK;
}
