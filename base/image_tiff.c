// SPDX-License-Identifier: Apache-2.0
// image_tiff.c - TIFF through libtiff, from memory: grey, RGB, either with alpha, palette; 8, 16 bits or float;
// strips or tiles, planes or pixels, whatever compression libtiff was built with.
//
// Messages are caught through handlers that belong to the one open file (libtiff 4.5's open options), not
// through TIFFSetErrorHandler, which is the whole process's.
#include "base/image_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <tiffio.h>

#include "base/image_codec.h"

// Blank pictures code at more than deflate's 1:1040 in zstd or LZMA; below FREE_BYTES nobody asks.
enum { MAX_RATIO = 2000, FREE_BYTES = 64 << 20 };

typedef struct reader {
    TIFF *tiff;
    const uint8_t *data;
    uint64_t size_bytes, at_bytes;
    uint32_t width_px, height_px;
    uint16_t n_samples, bits, photometric, planar;
    sheen_raster raster;
    bool is_damaged; // libjpeg inside libtiff only warns
    char message[160];
    sheen_err *err;
} reader;

static tmsize_t give_bytes(thandle_t handle, void *out, tmsize_t n)
{
    reader *r = handle;
    if (n <= 0 || r->at_bytes >= r->size_bytes)
        return 0;
    const uint64_t left = r->size_bytes - r->at_bytes;
    const uint64_t n_bytes = (uint64_t)n < left ? (uint64_t)n : left;
    memcpy(out, r->data + r->at_bytes, n_bytes);
    r->at_bytes += n_bytes;
    return (tmsize_t)n_bytes;
}

static tmsize_t take_nothing(thandle_t handle, void *from, tmsize_t n)
{
    (void)handle;
    (void)from;
    (void)n;
    return -1;
}

static toff_t seek(thandle_t handle, toff_t offset, int whence)
{
    reader *r = handle;
    const uint64_t from = whence == SEEK_CUR ? r->at_bytes : whence == SEEK_END ? r->size_bytes : 0;
    r->at_bytes = from + offset; // beyond the end nothing is given
    return r->at_bytes;
}

static int close_nothing(thandle_t handle)
{
    (void)handle;
    return 0;
}

static toff_t size_of(thandle_t handle)
{
    const reader *r = handle;
    return r->size_bytes;
}

static int on_error(TIFF *tiff, void *self, const char *module, const char *fmt, va_list args)
    SHEEN_PRINTF(4, 0);
static int on_warning(TIFF *tiff, void *self, const char *module, const char *fmt, va_list args)
    SHEEN_PRINTF(4, 0);

// The first message is the cause; what follows are consequences.
static int on_error(TIFF *tiff, void *self, const char *module, const char *fmt, va_list args)
{
    reader *r = self;
    (void)tiff;
    (void)module;
    if (!r->message[0])
        vsnprintf(r->message, sizeof r->message, fmt, args);
    return 1; // dealt with: the process's handler is not called
}

static int on_warning(TIFF *tiff, void *self, const char *module, const char *fmt, va_list args)
{
    reader *r = self;
    (void)tiff;
    if (module && !strcmp(module, "JPEGLib")) {
        r->is_damaged = true;
        if (!r->message[0])
            vsnprintf(r->message, sizeof r->message, fmt, args);
    }
    return 1;
}

static sheen_status fail_decode(const reader *r)
{
    return sheen_fail(r->err, SHEEN_EFORMAT, "TIFF cannot be decoded: %s",
                      r->message[0] ? r->message : "damaged or cut short");
}

static sheen_status open_tiff(reader *r)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (!options)
        return sheen_fail(r->err, SHEEN_ENOMEM, "out of memory for libtiff");
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, r);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, r);
    // Its own buffers: a strip may be the whole picture.
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, (tmsize_t)MAX_RATIO * (tmsize_t)r->size_bytes + FREE_BYTES);
    r->tiff = TIFFClientOpenExt("memory", "rm", r, give_bytes, take_nothing, seek, close_nothing, size_of,
                                NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return r->tiff ? SHEEN_OK : fail_decode(r);
}

static sheen_status read_size(reader *r)
{
    if (!TIFFGetField(r->tiff, TIFFTAG_IMAGEWIDTH, &r->width_px) ||
        !TIFFGetField(r->tiff, TIFFTAG_IMAGELENGTH, &r->height_px))
        return sheen_fail(r->err, SHEEN_EFORMAT, "TIFF has no size");
    return sheen_image_check_sides(r->width_px, r->height_px, r->err);
}

// What of TIFF's variety is read; the rest has its sentence.
static sheen_status read_layout(reader *r)
{
    uint16_t format = SAMPLEFORMAT_UINT, compression = COMPRESSION_NONE;
    TIFFGetFieldDefaulted(r->tiff, TIFFTAG_BITSPERSAMPLE, &r->bits);
    TIFFGetFieldDefaulted(r->tiff, TIFFTAG_SAMPLESPERPIXEL, &r->n_samples);
    TIFFGetFieldDefaulted(r->tiff, TIFFTAG_PLANARCONFIG, &r->planar);
    TIFFGetFieldDefaulted(r->tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(r->tiff, TIFFTAG_COMPRESSION, &compression);
    if (!TIFFGetField(r->tiff, TIFFTAG_PHOTOMETRIC, &r->photometric))
        r->photometric = r->n_samples >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    if (r->photometric == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG) {
        TIFFSetField(r->tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
        r->photometric = PHOTOMETRIC_RGB;
    }
    const bool is_grey = r->photometric == PHOTOMETRIC_MINISBLACK || r->photometric == PHOTOMETRIC_MINISWHITE;
    const bool is_palette = r->photometric == PHOTOMETRIC_PALETTE;
    if (!is_grey && !is_palette && r->photometric != PHOTOMETRIC_RGB)
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "a TIFF of colour type %u is not supported: save it as RGB or grey",
                          r->photometric);
    const bool is_float = format == SAMPLEFORMAT_IEEEFP;
    if (!((format == SAMPLEFORMAT_UINT && (r->bits == 8 || r->bits == 16)) || (is_float && r->bits == 32)) ||
        (is_palette && r->bits != 8))
        return sheen_fail(
            r->err, SHEEN_EUNSUP,
            "a TIFF of %u bits a sample, format %u, is not supported: save it with 8 or 16 bits or float",
            r->bits, format);
    if (is_palette ? r->n_samples != 1 : r->n_samples < (is_grey ? 1 : 3) || r->n_samples > (is_grey ? 2 : 4))
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "a TIFF of %u samples a pixel and colour type %u is not supported", r->n_samples,
                          r->photometric);
    if (r->planar != PLANARCONFIG_CONTIG && r->planar != PLANARCONFIG_SEPARATE)
        return sheen_fail(r->err, SHEEN_EFORMAT, "TIFF has planar configuration %u", r->planar);
    return SHEEN_OK;
}

// Spreads n_px pixels of a plane, or copies those of interleaved data, to (x, y) of the picture.
static void place(reader *r, uint32_t x, uint32_t y, uint16_t plane, const uint8_t *from, uint32_t n_px)
{
    const size_t sample_bytes = (size_t)r->bits / 8, pixel_bytes = sample_bytes * r->n_samples;
    uint8_t *to = (uint8_t *)r->raster.data + ((size_t)y * r->width_px + x) * pixel_bytes;
    if (r->planar == PLANARCONFIG_CONTIG) {
        memcpy(to, from, n_px * pixel_bytes);
        return;
    }
    to += plane * sample_bytes;
    for (uint32_t i = 0; i < n_px; i++)
        memcpy(to + i * pixel_bytes, from + i * sample_bytes, sample_bytes);
}

static sheen_status read_lines(reader *r)
{
    const uint16_t n_planes = r->planar == PLANARCONFIG_CONTIG ? 1 : r->n_samples;
    const size_t line_bytes = (size_t)r->width_px * r->bits / 8 * (r->n_samples / n_planes);
    if ((size_t)TIFFScanlineSize(r->tiff) != line_bytes)
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "a TIFF with subsampled colour is not supported: save it as RGB");
    uint8_t *line = calloc(line_bytes, 1); // some decoders leave gaps without a word
    if (!line)
        return sheen_fail_memory(r->err, (double)line_bytes, "a line of TIFF");
    bool ok = true;
    for (uint16_t plane = 0; plane < n_planes && ok; plane++)
        for (uint32_t y = 0; y < r->height_px && ok; y++) {
            ok = TIFFReadScanline(r->tiff, line, y, plane) == 1 && !r->is_damaged;
            if (ok)
                place(r, 0, y, plane, line, r->width_px);
        }
    free(line);
    return ok ? SHEEN_OK : fail_decode(r);
}

static sheen_status read_tiles(reader *r)
{
    uint32_t tile_w = 0, tile_h = 0;
    const uint16_t n_planes = r->planar == PLANARCONFIG_CONTIG ? 1 : r->n_samples;
    TIFFGetField(r->tiff, TIFFTAG_TILEWIDTH, &tile_w);
    TIFFGetField(r->tiff, TIFFTAG_TILELENGTH, &tile_h);
    sheen_status s = sheen_image_check_sides(tile_w, tile_h, r->err);
    if (s)
        return s;
    const size_t line_bytes = (size_t)tile_w * r->bits / 8 * (r->n_samples / n_planes);
    const size_t tile_bytes = line_bytes * tile_h;
    s = sheen_image_check_claim((double)tile_bytes, (size_t)r->size_bytes, MAX_RATIO, FREE_BYTES, r->err);
    if (s)
        return s;
    if ((size_t)TIFFTileSize(r->tiff) != tile_bytes)
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "a TIFF with subsampled colour is not supported: save it as RGB");
    uint8_t *tile = calloc(tile_bytes, 1);
    if (!tile)
        return sheen_fail_memory(r->err, (double)tile_bytes, "a tile of TIFF");
    bool ok = true;
    for (uint16_t plane = 0; plane < n_planes && ok; plane++)
        for (uint32_t y = 0; y < r->height_px && ok; y += tile_h)
            for (uint32_t x = 0; x < r->width_px && ok; x += tile_w) {
                ok = TIFFReadTile(r->tiff, tile, x, y, 0, plane) == (tmsize_t)tile_bytes && !r->is_damaged;
                const uint32_t n_px = r->width_px - x < tile_w ? r->width_px - x : tile_w;
                const uint32_t n_lines = r->height_px - y < tile_h ? r->height_px - y : tile_h;
                for (uint32_t i = 0; ok && i < n_lines; i++)
                    place(r, x, y + i, plane, tile + i * line_bytes, n_px);
            }
    free(tile);
    return ok ? SHEEN_OK : fail_decode(r);
}

// White-is-zero grey, turned round.
static void invert(sheen_raster *raster)
{
    const size_t n_px = (size_t)raster->width_px * (size_t)raster->height_px;
    for (size_t i = 0; i < n_px; i++) {
        const size_t at = i * (size_t)raster->n_channels;
        if (raster->bits == 8)
            ((uint8_t *)raster->data)[at] ^= 0xff;
        else if (raster->bits == 16)
            ((uint16_t *)raster->data)[at] ^= 0xffff;
        else
            ((float *)raster->data)[at] = 1 - ((float *)raster->data)[at];
    }
}

// 8-bit indices to 8-bit RGB. Most writers fill the map's 16 bits, some only the low 8.
static sheen_status apply_palette(reader *r)
{
    uint16_t *map[3];
    if (!TIFFGetField(r->tiff, TIFFTAG_COLORMAP, &map[0], &map[1], &map[2]))
        return sheen_fail(r->err, SHEEN_EFORMAT, "TIFF has no palette");
    uint16_t highest = 0;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 256; i++)
            highest = map[c][i] > highest ? map[c][i] : highest;
    const int shift = highest > 255 ? 8 : 0;
    sheen_raster rgb;
    const sheen_status s = sheen_raster_init(&rgb, r->raster.width_px, r->raster.height_px, 3, 8, r->err);
    if (s)
        return s;
    const size_t n_px = (size_t)rgb.width_px * (size_t)rgb.height_px;
    const uint8_t *index = r->raster.data;
    uint8_t *out = rgb.data;
    for (size_t i = 0; i < n_px; i++)
        for (size_t c = 0; c < 3; c++)
            out[3 * i + c] = (uint8_t)(map[c][index[i]] >> shift);
    sheen_raster_release(&r->raster);
    r->raster = rgb;
    return SHEEN_OK;
}

static sheen_status read_pixels(reader *r)
{
    sheen_status s = read_layout(r);
    if (s)
        return s;
    const double decoded_bytes = (double)r->width_px * r->height_px * r->n_samples * r->bits / 8;
    s = sheen_image_check_claim(decoded_bytes, (size_t)r->size_bytes, MAX_RATIO, FREE_BYTES, r->err);
    if (s)
        return s;
    s = sheen_raster_init(&r->raster, (int)r->width_px, (int)r->height_px, r->n_samples, r->bits, r->err);
    if (s)
        return s;
    s = TIFFIsTiled(r->tiff) ? read_tiles(r) : read_lines(r);
    if (!s && r->photometric == PHOTOMETRIC_MINISWHITE)
        invert(&r->raster);
    if (!s && r->photometric == PHOTOMETRIC_PALETTE)
        s = apply_palette(r);
    return s;
}

sheen_status sheen_tiff_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err)
{
    *out = (sheen_raster){0};
    reader r = {.data = data, .size_bytes = size_bytes, .err = err};
    sheen_status s = open_tiff(&r);
    if (!s)
        s = read_size(&r);
    if (!s)
        s = read_pixels(&r);
    if (r.tiff)
        TIFFClose(r.tiff);
    if (s)
        sheen_raster_release(&r.raster);
    *out = r.raster;
    return s;
}

sheen_status sheen_tiff_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                              sheen_err *err)
{
    reader r = {.data = data, .size_bytes = size_bytes, .err = err};
    sheen_status s = open_tiff(&r);
    if (!s)
        s = read_size(&r);
    if (r.tiff)
        TIFFClose(r.tiff);
    if (!s) {
        *width_px = (int)r.width_px;
        *height_px = (int)r.height_px;
    }
    return s;
}
