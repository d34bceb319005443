// SPDX-License-Identifier: Apache-2.0
// image_jpeg.c - JPEG through libjpeg-turbo: baseline and progressive, grey or colour, 8 bits.
//
// libjpeg decodes what it can and warns; here a warning that means lost picture is an error, so that half a
// frame never passes for a whole one. EXIF's orientation is left alone: a camera model holds for the sensor's
// rows. The Huffman tables that MJPEG cameras leave out are put in by the library.
#include "base/image_file.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>

#include <jerror.h>

#include "base/file.h"
#include "base/image_codec.h"

// A block of 8x8 samples takes at least one bit, and the finest component has a sample a pixel. (Arithmetic
// coding can go below that for blank pictures of tens of megapixels only.)
enum { MAX_PX_PER_BYTE = 512, MAX_SCANS = 200 };

typedef enum reading { HEADER, RGB_OR_GREY, AS_CODED } reading;

typedef struct reader {
    reading what;
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_progress_mgr progress;
    jmp_buf escape;
    sheen_raster raster;
    sheen_status status;
    char message[JMSG_LENGTH_MAX];
    sheen_err *err;
} reader;

static sheen_status status_of(int code)
{
    switch (code) {
    case JERR_OUT_OF_MEMORY:
        return SHEEN_ENOMEM;
    case JERR_BAD_PRECISION:
    case JERR_SOF_UNSUPPORTED:
    case JERR_ARITH_NOTIMPL:
    case JERR_CONVERSION_NOTIMPL:
        return SHEEN_EUNSUP;
    default:
        return SHEEN_EFORMAT;
    }
}

static void on_error(j_common_ptr jpeg)
{
    reader *r = jpeg->client_data;
    jpeg->err->format_message(jpeg, r->message);
    r->status = status_of(jpeg->err->msg_code);
    longjmp(r->escape, 1);
}

// Negative levels are warnings. Some concern only things that are not used here.
static void on_message(j_common_ptr jpeg, int level)
{
    if (level >= 0)
        return;
    switch (jpeg->err->msg_code) {
    case JWRN_EXTRANEOUS_DATA: // padding between segments, as some cameras leave
    case JWRN_JFIF_MAJOR:
    case JWRN_ADOBE_XFORM:
    case JWRN_BOGUS_ICC:
        return;
    default:
        on_error(jpeg);
    }
}

static void print_nothing(j_common_ptr jpeg)
{
    (void)jpeg;
}

// A progressive file may hold thousands of scans of nothing, each of which costs a pass over the picture.
static void on_progress(j_common_ptr jpeg)
{
    reader *r = jpeg->client_data;
    if (r->jpeg.input_scan_number <= MAX_SCANS)
        return;
    snprintf(r->message, sizeof r->message, "more than %d scans", MAX_SCANS);
    r->status = SHEEN_EFORMAT;
    longjmp(r->escape, 1);
}

static void set_output(reader *r)
{
    const J_COLOR_SPACE coded = r->jpeg.jpeg_color_space;
    r->jpeg.out_color_space = coded == JCS_GRAYSCALE                      ? JCS_GRAYSCALE
                              : coded == JCS_YCbCr && r->what == AS_CODED ? JCS_YCbCr
                                                                          : JCS_RGB;
    r->jpeg.dct_method = JDCT_ISLOW;
}

static void read_rows(reader *r)
{
    const size_t row_bytes = (size_t)r->raster.width_px * (size_t)r->raster.n_channels;
    while (r->jpeg.output_scanline < r->jpeg.output_height) {
        JSAMPROW row = (JSAMPROW)r->raster.data + row_bytes * r->jpeg.output_scanline;
        jpeg_read_scanlines(&r->jpeg, &row, 1);
    }
}

// Between setjmp and the end only *r changes.
static sheen_status read_all(reader *r, const void *data, size_t size_bytes)
{
    if (setjmp(r->escape))
        return sheen_fail(r->err, r->status, "JPEG cannot be decoded: %s", r->message);
    jpeg_create_decompress(&r->jpeg);
    r->jpeg.progress = &r->progress;
    jpeg_mem_src(&r->jpeg, data, (unsigned long)size_bytes);
    jpeg_read_header(&r->jpeg, TRUE);
    const uint32_t width_px = r->jpeg.image_width, height_px = r->jpeg.image_height;
    r->status = sheen_image_check_sides(width_px, height_px, r->err);
    if (r->status || r->what == HEADER) {
        r->raster.width_px = (int)width_px;
        r->raster.height_px = (int)height_px;
        return r->status;
    }
    if (r->jpeg.jpeg_color_space == JCS_CMYK || r->jpeg.jpeg_color_space == JCS_YCCK)
        return sheen_fail(r->err, SHEEN_EUNSUP, "a CMYK JPEG is not supported: save it as RGB");
    r->status = sheen_image_check_claim((double)width_px * height_px, size_bytes, MAX_PX_PER_BYTE, 1e5,
                                        r->err);
    if (r->status)
        return r->status;
    set_output(r);
    jpeg_start_decompress(&r->jpeg);
    r->status = sheen_raster_init(&r->raster, (int)r->jpeg.output_width, (int)r->jpeg.output_height,
                                  r->jpeg.output_components, 8, r->err);
    if (r->status)
        return r->status;
    read_rows(r);
    jpeg_finish_decompress(&r->jpeg); // looks for the end marker
    return SHEEN_OK;
}

static sheen_status read_jpeg(sheen_raster *out, bool *is_ycbcr, const void *data, size_t size_bytes,
                              reading what, sheen_err *err)
{
    *out = (sheen_raster){0};
    *is_ycbcr = false;
    if (!size_bytes)
        return sheen_fail(err, SHEEN_EFORMAT, "the file is empty");
    reader *r = calloc(1, sizeof *r);
    if (!r)
        return sheen_fail_memory(err, sizeof *r, "libjpeg");
    r->what = what;
    r->err = err;
    r->jpeg.err = jpeg_std_error(&r->errors);
    r->jpeg.client_data = r;
    r->errors.error_exit = on_error;
    r->errors.emit_message = on_message;
    r->errors.output_message = print_nothing;
    r->progress.progress_monitor = on_progress;
    const sheen_status s = read_all(r, data, size_bytes);
    *is_ycbcr = r->jpeg.out_color_space == JCS_YCbCr;
    jpeg_destroy_decompress(&r->jpeg);
    if (s)
        sheen_raster_release(&r->raster);
    *out = r->raster;
    free(r);
    return s;
}

sheen_status sheen_jpeg_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err)
{
    bool is_ycbcr;
    return read_jpeg(out, &is_ycbcr, data, size_bytes, RGB_OR_GREY, err);
}

sheen_status sheen_jpeg_parse_coded(sheen_raster *out, bool *is_ycbcr_out, const void *data,
                                    size_t size_bytes, sheen_err *err)
{
    return read_jpeg(out, is_ycbcr_out, data, size_bytes, AS_CODED, err);
}

sheen_status sheen_jpeg_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                              sheen_err *err)
{
    sheen_raster size;
    bool is_ycbcr;
    const sheen_status s = read_jpeg(&size, &is_ycbcr, data, size_bytes, HEADER, err);
    if (!s) {
        *width_px = size.width_px;
        *height_px = size.height_px;
    }
    return s;
}

typedef struct writer {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_destination_mgr destination; // libjpeg's own leaks its memory after an error
    jmp_buf escape;
    sheen_bytes bytes;
    uint8_t buffer[4096];
    char message[JMSG_LENGTH_MAX];
} writer;

static void begin_bytes(j_compress_ptr jpeg)
{
    writer *w = jpeg->client_data;
    w->destination.next_output_byte = w->buffer;
    w->destination.free_in_buffer = sizeof w->buffer;
}

static boolean take_buffer(j_compress_ptr jpeg)
{
    writer *w = jpeg->client_data;
    if (!sheen_bytes_put(&w->bytes, w->bytes.size_bytes, w->buffer, sizeof w->buffer))
        ERREXIT1(jpeg, JERR_OUT_OF_MEMORY, 0);
    begin_bytes(jpeg);
    return TRUE;
}

static void take_rest(j_compress_ptr jpeg)
{
    writer *w = jpeg->client_data;
    const size_t n_bytes = sizeof w->buffer - w->destination.free_in_buffer;
    if (!sheen_bytes_put(&w->bytes, w->bytes.size_bytes, w->buffer, n_bytes))
        ERREXIT1(jpeg, JERR_OUT_OF_MEMORY, 0);
}

static void on_write_error(j_common_ptr jpeg)
{
    writer *w = jpeg->client_data;
    jpeg->err->format_message(jpeg, w->message);
    longjmp(w->escape, 1);
}

static sheen_status write_all(writer *w, const sheen_raster *r, int quality, sheen_err *err)
{
    if (setjmp(w->escape))
        return sheen_fail(err, status_of(w->errors.msg_code) == SHEEN_ENOMEM ? SHEEN_ENOMEM : SHEEN_EARG,
                          "cannot code a JPEG: %s", w->message);
    jpeg_create_compress(&w->jpeg);
    w->destination.init_destination = begin_bytes;
    w->destination.empty_output_buffer = take_buffer;
    w->destination.term_destination = take_rest;
    w->jpeg.dest = &w->destination;
    w->jpeg.image_width = (JDIMENSION)r->width_px;
    w->jpeg.image_height = (JDIMENSION)r->height_px;
    w->jpeg.input_components = r->n_channels;
    w->jpeg.in_color_space = r->n_channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&w->jpeg);
    jpeg_set_quality(&w->jpeg, quality, TRUE);
    for (int i = 0; i < w->jpeg.num_components; i++)
        w->jpeg.comp_info[i].h_samp_factor = w->jpeg.comp_info[i].v_samp_factor = 1;
    jpeg_start_compress(&w->jpeg, TRUE);
    const size_t row_bytes = (size_t)r->width_px * (size_t)r->n_channels;
    while (w->jpeg.next_scanline < w->jpeg.image_height) {
        JSAMPROW row = (JSAMPROW)r->data + row_bytes * w->jpeg.next_scanline; // libjpeg only reads it
        jpeg_write_scanlines(&w->jpeg, &row, 1);
    }
    jpeg_finish_compress(&w->jpeg);
    return SHEEN_OK;
}

sheen_status sheen_jpeg_encode(uint8_t **out, size_t *size_bytes, const sheen_raster *r, int quality,
                               sheen_err *err)
{
    *out = NULL;
    *size_bytes = 0;
    if (!r->data || r->bits != 8 || (r->n_channels != 1 && r->n_channels != 3))
        return sheen_fail(err, SHEEN_EARG, "a JPEG has 1 or 3 channels of 8 bits");
    if (quality < 1 || quality > 100)
        return sheen_fail(err, SHEEN_EARG, "JPEG quality is 1 to 100, not %d", quality);
    writer *w = calloc(1, sizeof *w);
    if (!w)
        return sheen_fail_memory(err, sizeof *w, "a JPEG");
    w->jpeg.err = jpeg_std_error(&w->errors);
    w->jpeg.client_data = w;
    w->errors.error_exit = on_write_error;
    w->errors.output_message = print_nothing;
    const sheen_status s = write_all(w, r, quality, err);
    if (s) {
        free(w->bytes.data);
    } else {
        *out = w->bytes.data;
        *size_bytes = w->bytes.size_bytes;
    }
    jpeg_destroy_compress(&w->jpeg);
    free(w);
    return s;
}

sheen_status sheen_jpeg_write(const char *path, const sheen_raster *r, int quality, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_jpeg_encode(&data, &size_bytes, r, quality, err);
    if (s)
        return sheen_wrap(err, s, "cannot write '%s'", path);
    s = sheen_file_write(path, data, size_bytes, err);
    free(data);
    return s;
}
