// SPDX-License-Identifier: Apache-2.0
// image_hdr_read.c - Radiance pictures read: header lines, then rows of RGBE pixels, plain or coded by runs of either kind.
//
// A mantissa m with the exponent e stands for (m + 1/2) 2^(e - 136), as Radiance's own programs have it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_codec.h"
#include "base/image_file.h"

enum { MAX_LINE_BYTES = 512, LEAST_RUN_WIDTH = 8, MOST_RUN_WIDTH = 32767 };

typedef struct reader {
    const uint8_t *at, *end;
    int width_px, height_px;
    double exposure; // that the pixels were multiplied by
} reader;

// The next line without its end; false: there is none.
static bool read_line(char line[MAX_LINE_BYTES], reader *r)
{
    const size_t room = (size_t)(r->end - r->at);
    const uint8_t *stop = room ? memchr(r->at, '\n', room) : NULL;
    if (!stop)
        return false;
    const size_t n = (size_t)(stop - r->at), kept = n < MAX_LINE_BYTES ? n : MAX_LINE_BYTES - 1;
    memcpy(line, r->at, kept);
    line[kept] = '\0';
    r->at = stop + 1;
    return true;
}

// One half of the line with the size, such as "-Y 480"; NULL where it is none, else what follows.
static const char *read_side(const char *text, char axis[3], uint32_t *side_px)
{
    char *end = NULL;
    if ((text[0] != '+' && text[0] != '-') || (text[1] != 'X' && text[1] != 'Y') || text[2] != ' ')
        return NULL;
    memcpy(axis, text, 2);
    axis[2] = '\0';
    const unsigned long value = strtoul(text + 3, &end, 10);
    *side_px = value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
    return *end == ' ' ? end + 1 : end;
}

static sheen_status read_size(reader *r, const char *line, sheen_err *err)
{
    char rows[3], columns[3];
    uint32_t height_px = 0, width_px = 0;
    line = read_side(line, rows, &height_px);
    if (!line || !read_side(line, columns, &width_px))
        return sheen_fail(err, SHEEN_EFORMAT, "Radiance picture has no line with its size");
    if (strcmp(rows, "-Y") != 0 || strcmp(columns, "+X") != 0)
        return sheen_fail(err, SHEEN_EUNSUP,
                          "a Radiance picture with rows in the order '%s %s' is not supported", rows,
                          columns);
    const sheen_status s = sheen_image_check_sides(width_px, height_px, err);
    if (s)
        return s;
    r->height_px = (int)height_px;
    r->width_px = (int)width_px;
    return SHEEN_OK;
}

static sheen_status read_header(reader *r, sheen_err *err)
{
    char line[MAX_LINE_BYTES];
    r->exposure = 1;
    while (read_line(line, r)) {
        if (!*line)
            return read_line(line, r) ? read_size(r, line, err)
                                      : sheen_fail(err, SHEEN_EFORMAT, "Radiance header is cut short");
        if (!strncmp(line, "FORMAT=", 7) && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
            return sheen_fail(err, SHEEN_EUNSUP, "a Radiance picture of format '%.40s' is not supported",
                              line + 7);
        if (!strncmp(line, "EXPOSURE=", 9)) {
            const double factor = strtod(line + 9, NULL);
            if (!(factor > 0) || !isfinite(factor))
                return sheen_fail(err, SHEEN_EFORMAT, "Radiance header's exposure '%.40s' is none", line + 9);
            r->exposure *= factor;
        }
    }
    return sheen_fail(err, SHEEN_EFORMAT, "Radiance header is cut short");
}

static sheen_status fail_cut(const reader *r, int y, sheen_err *err)
{
    return sheen_fail(err, SHEEN_EFORMAT, "Radiance picture is cut short or damaged in row %d of %d", y,
                      r->height_px);
}

// A row of four planes, each of runs (128 + length, value) and plain stretches (length, values).
static bool read_planes(uint8_t *rgbe, reader *r)
{
    const size_t width = (size_t)r->width_px;
    r->at += 4;
    for (size_t c = 0; c < 4; c++)
        for (size_t x = 0; x < width;) {
            if (r->end - r->at < 2)
                return false;
            const uint8_t code = *r->at++;
            const bool run = code > 128;
            const size_t n = run ? code - 128u : code;
            if (!n || n > width - x || (size_t)(r->end - r->at) < (run ? 1 : n))
                return false;
            for (size_t i = 0; i < n; i++, x++)
                rgbe[4 * x + c] = r->at[run ? 0 : i];
            r->at += run ? 1 : n;
        }
    return true;
}

// A row of pixels, in which 1 1 1 n repeats the one before: n times, 256 n times where it follows another such, and so on.
static bool read_pixels(uint8_t *rgbe, reader *r)
{
    const size_t width = (size_t)r->width_px;
    int shift = 0;
    for (size_t x = 0; x < width;) {
        if (r->end - r->at < 4)
            return false;
        const uint8_t *p = r->at;
        r->at += 4;
        if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
            memcpy(rgbe + 4 * x++, p, 4);
            shift = 0;
            continue;
        }
        const size_t n = shift < 24 ? (size_t)p[3] << shift : SIZE_MAX;
        if (!x || n > width - x)
            return false;
        for (size_t i = 0; i < n; i++, x++)
            memcpy(rgbe + 4 * x, rgbe + 4 * (x - 1), 4);
        shift += 8;
    }
    return true;
}

static bool read_row(uint8_t *rgbe, reader *r)
{
    const uint8_t *p = r->at;
    const bool planes = r->width_px >= LEAST_RUN_WIDTH && r->width_px <= MOST_RUN_WIDTH && r->end - p >= 4 &&
                        p[0] == 2 && p[1] == 2 && p[2] < 128;
    if (planes && (p[2] << 8 | p[3]) != r->width_px)
        return false;
    return planes ? read_planes(rgbe, r) : read_pixels(rgbe, r);
}

static void decode_row(float *rgb, const uint8_t *rgbe, size_t n, double exposure)
{
    for (size_t x = 0; x < n; x++) {
        const double unit = rgbe[4 * x + 3] ? ldexp(1 / exposure, rgbe[4 * x + 3] - 136) : 0;
        for (size_t c = 0; c < 3; c++)
            rgb[3 * x + c] = (float)fmin((rgbe[4 * x + c] + 0.5) * unit, 1e30);
    }
}

sheen_status sheen_hdr_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                             sheen_err *err)
{
    reader r = {.at = data, .end = (const uint8_t *)data + size_bytes};
    const sheen_status s = read_header(&r, err);
    *width_px = r.width_px;
    *height_px = r.height_px;
    return s;
}

sheen_status sheen_hdr_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err)
{
    *out = (sheen_raster){0};
    reader r = {.at = data, .end = (const uint8_t *)data + size_bytes};
    sheen_status s = read_header(&r, err);
    if (!s) // a run of 127 takes two bytes
        s = sheen_image_check_claim(4.0 * r.width_px * r.height_px, (size_t)(r.end - r.at), 64, 1 << 20, err);
    if (!s)
        s = sheen_raster_init(out, r.width_px, r.height_px, 3, 32, err);
    uint8_t *rgbe = s ? NULL : malloc(4 * (size_t)r.width_px);
    if (!s && !rgbe)
        s = sheen_fail_memory(err, 4.0 * r.width_px, "a row of a Radiance picture");
    for (int y = 0; !s && y < r.height_px; y++) {
        if (!read_row(rgbe, &r))
            s = fail_cut(&r, y, err);
        else
            decode_row((float *)out->data + 3 * (size_t)y * (size_t)r.width_px, rgbe, (size_t)r.width_px,
                       r.exposure);
    }
    free(rgbe);
    if (s)
        sheen_raster_release(out);
    return s;
}
