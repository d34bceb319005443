// SPDX-License-Identifier: Apache-2.0
// image_png.c - PNG through libpng: read with any depth, palette or interlace; written with 8 or 16 bits.
//
// libpng reports errors by longjmp. All that must survive one lies in a `reader` or `writer` that belongs to the
// calling function; functions which call setjmp have no locals that change after it.
#include "base/image_file.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_codec.h"

// Deflate codes at most 258 bytes with two bits.
enum { MAX_DEFLATE_RATIO = 1040 };

typedef struct reader {
    png_structp png;
    png_infop info;
    const uint8_t *data;
    size_t size_bytes, used_bytes;
    sheen_raster raster;
    sheen_status status;
    char message[120];
    sheen_err *err;
} reader;

static void keep_message(char *out, size_t size_bytes, const char *message)
{
    snprintf(out, size_bytes, "%s", message);
}

static void on_read_error(png_structp png, png_const_charp message)
{
    reader *r = png_get_error_ptr(png);
    keep_message(r->message, sizeof r->message, message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static void give_bytes(png_structp png, png_bytep out, size_t n_bytes)
{
    reader *r = png_get_io_ptr(png);
    if (n_bytes > r->size_bytes - r->used_bytes)
        png_error(png, "the file is cut short");
    memcpy(out, r->data + r->used_bytes, n_bytes);
    r->used_bytes += n_bytes;
}

static sheen_status open_reader(reader *r)
{
    r->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, r, on_read_error, on_warning);
    if (r->png)
        r->info = png_create_info_struct(r->png);
    if (!r->info)
        return sheen_fail(r->err, SHEEN_ENOMEM, "out of memory for libpng");
    png_set_read_fn(r->png, r, give_bytes);
    png_set_user_limits(r->png, SHEEN_IMAGE_MAX_SIDE_PX, SHEEN_IMAGE_MAX_SIDE_PX);
    // Text, profiles and the like are not used: a broken or huge one must not cost anything.
    png_set_keep_unknown_chunks(r->png, PNG_HANDLE_CHUNK_NEVER, NULL, -1);
    return SHEEN_OK;
}

// Asks libpng for 8- or 16-bit grey, grey+alpha, RGB or RGBA in the machine's byte order.
static void set_transforms(reader *r)
{
    png_set_expand(r->png); // palette to RGB, 1, 2, 4 bits to 8, transparent colour to alpha
    if (png_get_bit_depth(r->png, r->info) == 16 && sheen_is_little_endian())
        png_set_swap(r->png);
}

static void read_rows(reader *r, int n_passes)
{
    const size_t row_bytes = png_get_rowbytes(r->png, r->info);
    for (int pass = 0; pass < n_passes; pass++)
        for (int y = 0; y < r->raster.height_px; y++)
            png_read_row(r->png, (png_bytep)r->raster.data + row_bytes * (size_t)y, NULL);
}

// Between setjmp and the end only *r changes.
static sheen_status read_all(reader *r, bool header_only)
{
    if (setjmp(png_jmpbuf(r->png)))
        return sheen_fail(r->err, SHEEN_EFORMAT, "PNG cannot be decoded: %s", r->message);
    png_read_info(r->png, r->info);
    const uint32_t width_px = png_get_image_width(r->png, r->info);
    const uint32_t height_px = png_get_image_height(r->png, r->info);
    r->status = sheen_image_check_sides(width_px, height_px, r->err);
    if (r->status || header_only) {
        r->raster.width_px = (int)width_px;
        r->raster.height_px = (int)height_px;
        return r->status;
    }
    const double packed_bytes = (double)png_get_rowbytes(r->png, r->info) * height_px;
    r->status = sheen_image_check_claim(packed_bytes, r->size_bytes, MAX_DEFLATE_RATIO, 1e5, r->err);
    if (r->status)
        return r->status;
    set_transforms(r);
    const int n_passes = png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
    r->status = sheen_raster_init(&r->raster, (int)width_px, (int)height_px,
                                  png_get_channels(r->png, r->info), png_get_bit_depth(r->png, r->info),
                                  r->err);
    if (r->status)
        return r->status;
    read_rows(r, n_passes);
    png_read_end(r->png, NULL); // checks that the end is there
    return SHEEN_OK;
}

static sheen_status read_png(sheen_raster *out, const void *data, size_t size_bytes, bool header_only,
                             sheen_err *err)
{
    *out = (sheen_raster){0};
    reader r = {.data = data, .size_bytes = size_bytes, .err = err};
    sheen_status s = open_reader(&r);
    if (!s)
        s = read_all(&r, header_only);
    png_destroy_read_struct(&r.png, &r.info, NULL);
    if (s)
        sheen_raster_release(&r.raster);
    *out = r.raster;
    return s;
}

sheen_status sheen_png_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err)
{
    return read_png(out, data, size_bytes, false, err);
}

sheen_status sheen_png_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                             sheen_err *err)
{
    sheen_raster size;
    const sheen_status s = read_png(&size, data, size_bytes, true, err);
    if (!s) {
        *width_px = size.width_px;
        *height_px = size.height_px;
    }
    return s;
}

typedef struct writer {
    png_structp png;
    png_infop info;
    sheen_bytes bytes;
    bool no_memory;
    char message[120];
} writer;

static void on_write_error(png_structp png, png_const_charp message)
{
    writer *w = png_get_error_ptr(png);
    keep_message(w->message, sizeof w->message, message);
    png_longjmp(png, 1);
}

static void take_bytes(png_structp png, png_bytep from, size_t n_bytes)
{
    writer *w = png_get_io_ptr(png);
    if (!sheen_bytes_put(&w->bytes, w->bytes.size_bytes, from, n_bytes)) {
        w->no_memory = true;
        png_error(png, "out of memory");
    }
}

static void flush_nothing(png_structp png)
{
    (void)png;
}

static sheen_status write_all(writer *w, const sheen_raster *r, bool srgb, sheen_err *err)
{
    static const int colour_types[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                       PNG_COLOR_TYPE_RGB_ALPHA};
    w->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, w, on_write_error, on_warning);
    if (w->png)
        w->info = png_create_info_struct(w->png);
    if (!w->info)
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory for libpng");
    if (setjmp(png_jmpbuf(w->png)))
        return sheen_fail(err, w->no_memory ? SHEEN_ENOMEM : SHEEN_EARG, "cannot code a PNG: %s", w->message);
    png_set_write_fn(w->png, w, take_bytes, flush_nothing);
    png_set_user_limits(w->png, SHEEN_IMAGE_MAX_SIDE_PX, SHEEN_IMAGE_MAX_SIDE_PX);
    png_set_IHDR(w->png, w->info, (png_uint_32)r->width_px, (png_uint_32)r->height_px, r->bits,
                 colour_types[r->n_channels - 1], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (srgb)
        png_set_sRGB(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(w->png, w->info);
    if (r->bits == 16 && sheen_is_little_endian())
        png_set_swap(w->png);
    const size_t row_bytes = (size_t)r->width_px * (size_t)r->n_channels * (size_t)r->bits / 8;
    for (int y = 0; y < r->height_px; y++)
        png_write_row(w->png, (png_const_bytep)r->data + row_bytes * (size_t)y);
    png_write_end(w->png, NULL);
    return SHEEN_OK;
}

static sheen_status encode_png(sheen_bytes *out, const sheen_raster *r, bool srgb, sheen_err *err)
{
    if (!r->data || (r->bits != 8 && r->bits != 16) || r->n_channels < 1 || r->n_channels > 4)
        return sheen_fail(err, SHEEN_EARG, "a PNG has 1 to 4 channels of 8 or 16 bits");
    writer w = {0};
    const sheen_status s = write_all(&w, r, srgb, err);
    png_destroy_write_struct(&w.png, &w.info);
    if (s)
        free(w.bytes.data);
    else
        *out = w.bytes;
    return s;
}

static sheen_status write_png(const char *path, const sheen_raster *r, bool srgb, sheen_err *err)
{
    sheen_bytes bytes = {0};
    sheen_status s = encode_png(&bytes, r, srgb, err);
    if (s)
        return sheen_wrap(err, s, "cannot write '%s'", path);
    s = sheen_file_write(path, bytes.data, bytes.size_bytes, err);
    free(bytes.data);
    return s;
}

sheen_status sheen_png_encode(uint8_t **data_out, size_t *size_bytes, const sheen_raster *r, sheen_err *err)
{
    sheen_bytes bytes = {0};
    const sheen_status s = encode_png(&bytes, r, false, err);
    *data_out = bytes.data;
    *size_bytes = bytes.size_bytes;
    return s;
}

sheen_status sheen_png_write(const char *path, const sheen_raster *r, sheen_err *err)
{
    return write_png(path, r, false, err);
}

sheen_status sheen_png_write_srgb(const char *path, const sheen_image *lin, sheen_err *err)
{
    if (!lin->data || (lin->n_channels != 1 && lin->n_channels != 3 && lin->n_channels != 4))
        return sheen_fail(err, SHEEN_EARG, "cannot write '%s': an sRGB PNG has 1, 3 or 4 channels", path);
    sheen_raster r;
    sheen_status s = sheen_raster_from_linear(&r, lin, err);
    if (s)
        return s;
    s = write_png(path, &r, true, err);
    sheen_raster_release(&r);
    return s;
}
