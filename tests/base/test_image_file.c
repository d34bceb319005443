// SPDX-License-Identifier: Apache-2.0
// test_image_file.c - picture files: round trips, every format's variants, cut and lying files.
#include "tests/base/damaged_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"

#define CORPUS TEST_CORPUS

// A raster with a different value in each sample.
static sheen_raster make_raster(int width_px, int height_px, int n_channels, int bits)
{
    sheen_err err;
    sheen_raster r;
    uint64_t seed = 7;
    assert_ok(sheen_raster_init(&r, width_px, height_px, n_channels, bits, &err), err);
    const int n = width_px * height_px * n_channels;
    for (int i = 0; i < n; i++) {
        if (bits == 8)
            ((uint8_t *)r.data)[i] = (uint8_t)(256 * test_random(&seed));
        else if (bits == 16)
            ((uint16_t *)r.data)[i] = (uint16_t)(65536 * test_random(&seed));
        else
            ((float *)r.data)[i] = (float)(100 * test_random(&seed) - 10);
    }
    return r;
}

static void assert_same_raster(const sheen_raster *got, const sheen_raster *want)
{
    assert_int_equal(got->width_px, want->width_px);
    assert_int_equal(got->height_px, want->height_px);
    assert_int_equal(got->n_channels, want->n_channels);
    assert_int_equal(got->bits, want->bits);
    assert_memory_equal(got->data, want->data,
                        (size_t)want->width_px * (size_t)want->height_px * (size_t)want->n_channels *
                            (size_t)want->bits / 8);
}

// Whatever the length to which a file is cut, it is refused as malformed, and nothing is left in *out.
static void assert_cuts_refused(const uint8_t *data, size_t size_bytes)
{
    for (size_t n = 0; n < size_bytes; n++) {
        sheen_err err;
        sheen_raster r = {.width_px = 99};
        uint8_t *copy = malloc(n ? n : 1); // its own allocation: a read beyond it is seen
        assert_non_null(copy);
        memcpy(copy, data, n);
        const sheen_status s = sheen_raster_parse(&r, copy, n, &err);
        free(copy);
        if (s != SHEEN_EFORMAT)
            fail_msg("cut to %zu of %zu bytes: status %d", n, size_bytes, (int)s);
        assert_null(r.data);
        assert_int_equal(r.width_px, 0);
    }
}

static void assert_probe(const uint8_t *data, size_t size_bytes, int width_px, int height_px)
{
    sheen_err err;
    int w = 0, h = 0;
    assert_ok(sheen_raster_probe(&w, &h, data, size_bytes, &err), err);
    assert_int_equal(w, width_px);
    assert_int_equal(h, height_px);
}

static void png_round_trips(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "a.png");
    for (int n_channels = 1; n_channels <= 4; n_channels++)
        for (int bits = 8; bits <= 16; bits += 8) {
            sheen_err err;
            sheen_raster r = make_raster(13, 9, n_channels, bits), back;
            assert_ok(sheen_png_write(path, &r, &err), err);
            assert_ok(sheen_raster_load(&back, path, &err), err);
            assert_same_raster(&back, &r);
            sheen_raster_release(&back);
            sheen_raster_release(&r);
            size_t size_bytes;
            uint8_t *data = test_file_read(path, &size_bytes);
            assert_probe(data, size_bytes, 13, 9);
            assert_cuts_refused(data, size_bytes);
            free(data);
        }
}

// The corpus of the fuzz targets holds one small file of each kind, all of the same 7 x 5 picture.
static void png_variants_agree(void **state)
{
    (void)state;
    sheen_err err;
    sheen_raster plain, other;
    assert_ok(sheen_raster_load(&plain, CORPUS "png/rgb8.png", &err), err);
    assert_int_equal(plain.n_channels, 3);
    assert_ok(sheen_raster_load(&other, CORPUS "png/rgb8-interlaced.png", &err), err);
    assert_same_raster(&other, &plain);
    sheen_raster_release(&other);
    assert_ok(sheen_raster_load(&other, CORPUS "png/text-chunk.png", &err), err);
    assert_same_raster(&other, &plain);
    sheen_raster_release(&other);
    sheen_raster_release(&plain);

    static const struct {
        const char *path;
        int n_channels, bits;
    } cases[] = {{CORPUS "png/palette.png", 3, 8},
                 {CORPUS "png/grey16.png", 1, 16},
                 {CORPUS "png/grey1.png", 1, 8},
                 {CORPUS "png/grey-alpha.png", 2, 8},
                 {CORPUS "png/rgba16.png", 4, 16}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_ok(sheen_raster_load(&other, cases[i].path, &err), err);
        assert_int_equal(other.n_channels, cases[i].n_channels);
        assert_int_equal(other.bits, cases[i].bits);
        assert_int_equal(other.width_px, 7);
        assert_int_equal(other.height_px, 5);
        sheen_raster_release(&other);
    }
}

static void png_of_light_is_coded_and_clipped(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "lin.png");
    sheen_err err;
    float light[] = {0, 0.21404114f, 1, 0.5f, -3, 7, NAN, 2};
    const sheen_image lin = {light, 2, 1, 4};
    assert_ok(sheen_png_write_srgb(path, &lin, &err), err);
    sheen_raster back;
    assert_ok(sheen_raster_load(&back, path, &err), err);
    static const uint8_t want[] = {0, 128, 255, 128, 0, 255, 0, 255}; // alpha stays linear
    assert_int_equal(back.n_channels, 4);
    assert_memory_equal(back.data, want, sizeof want);
    sheen_raster_release(&back);
}

// A smooth picture, which JPEG keeps.
static sheen_raster make_smooth(int n_channels)
{
    sheen_err err;
    sheen_raster r;
    assert_ok(sheen_raster_init(&r, 21, 18, n_channels, 8, &err), err);
    for (int y = 0; y < 18; y++)
        for (int x = 0; x < 21; x++)
            for (int c = 0; c < n_channels; c++)
                ((uint8_t *)r.data)[(y * 21 + x) * n_channels + c] = (uint8_t)(40 + 6 * x + 3 * y + 10 * c);
    return r;
}

static void jpeg_round_trips_closely(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "a.jpg");
    for (int n_channels = 1; n_channels <= 3; n_channels += 2) {
        sheen_err err;
        sheen_raster r = make_smooth(n_channels), back;
        assert_ok(sheen_jpeg_write(path, &r, 98, &err), err);
        assert_ok(sheen_raster_load(&back, path, &err), err);
        assert_int_equal(back.n_channels, n_channels);
        assert_int_equal(back.width_px, 21);
        for (int i = 0; i < 21 * 18 * n_channels; i++)
            assert_close(((uint8_t *)back.data)[i], ((uint8_t *)r.data)[i], 4);
        sheen_raster_release(&back);
        sheen_raster_release(&r);
        size_t size_bytes;
        uint8_t *data = test_file_read(path, &size_bytes);
        assert_probe(data, size_bytes, 21, 18);
        assert_cuts_refused(data, size_bytes);
        free(data);
    }
}

static void jpeg_variants(void **state)
{
    (void)state;
    sheen_err err;
    sheen_raster plain, other;
    assert_ok(sheen_raster_load(&plain, CORPUS "jpeg/colour-444.jpg", &err), err);
    assert_ok(sheen_raster_load(&other, CORPUS "jpeg/mjpeg-no-huffman-tables.jpg", &err), err);
    assert_same_raster(&other, &plain);
    sheen_raster_release(&other);
    assert_ok(sheen_raster_load(&other, CORPUS "jpeg/padding-after-end.jpg", &err), err);
    assert_same_raster(&other, &plain);
    sheen_raster_release(&other);
    sheen_raster_release(&plain);
    size_t size_bytes;
    uint8_t *data = test_file_read(CORPUS "jpeg/progressive.jpg", &size_bytes);
    assert_ok(sheen_raster_parse(&other, data, size_bytes, &err), err);
    sheen_raster_release(&other);
    assert_cuts_refused(data, size_bytes);
    free(data);
}

// TIFF, byte by byte. Pixels come last, so that every cut loses something.
typedef struct tiff {
    uint8_t data[4096];
    size_t size_bytes;
    bool big_endian;
} tiff;

static void put(tiff *t, uint32_t x, int n_bytes)
{
    for (int i = 0; i < n_bytes; i++)
        t->data[t->size_bytes++] = (uint8_t)(x >> 8 * (t->big_endian ? n_bytes - 1 - i : i));
}

typedef struct tag {
    uint32_t id, value; // one value; the id 0 ends a list
} tag;

// Tags from 256 on, in order; all are LONG, but SHORT where the standard wants it. `extra_bytes` follow the tags.
static void begin_tiff(tiff *t, bool big_endian, const tag *tags, size_t extra_bytes, uint32_t *pixels_at)
{
    uint32_t n = 0;
    while (tags[n].id)
        n++;
    *t = (tiff){.big_endian = big_endian};
    put(t, big_endian ? 0x4d4d : 0x4949, 2);
    put(t, 42, 2);
    put(t, 8, 4);
    put(t, n, 2);
    *pixels_at = 8 + 2 + 12 * n + 4 + (uint32_t)extra_bytes;
    for (uint32_t i = 0; i < n; i++) {
        const bool is_long = tags[i].id == 256 || tags[i].id == 257 || tags[i].id == 273 ||
                             tags[i].id == 278 || tags[i].id == 279 ||
                             (tags[i].id >= 322 && tags[i].id <= 325);
        const bool is_offset = tags[i].id == 273 || tags[i].id == 324;
        put(t, tags[i].id, 2);
        put(t, is_long ? 4 : 3, 2);
        put(t, 1, 4);
        put(t, is_offset ? *pixels_at : tags[i].value, is_long ? 4 : 2);
        if (!is_long)
            put(t, 0, 2);
    }
    put(t, 0, 4);
}

static void tiff_of_all_depths_and_orders(void **state)
{
    (void)state;
    for (int big = 0; big < 2; big++)
        for (int bits = 8; bits <= 32; bits *= 2) {
            const uint32_t n_bytes = 4 * 3 * 3 * (uint32_t)bits / 8, format = bits == 32 ? 3 : 1;
            const tag tags[] = {{256, 4}, {257, 3}, {258, (uint32_t)bits}, {259, 1}, {262, 2},      {273, 0},
                                {277, 3}, {278, 3}, {279, n_bytes},        {284, 1}, {339, format}, {0, 0}};
            sheen_raster want = make_raster(4, 3, 3, bits), got;
            tiff t;
            uint32_t pixels_at;
            begin_tiff(&t, big, tags, 0, &pixels_at);
            assert_int_equal(t.size_bytes, pixels_at);
            for (int i = 0; i < 36; i++) {
                uint32_t x;
                memcpy(&x, (uint32_t *)want.data + i * (bits == 32), sizeof x);
                put(&t,
                    bits == 8    ? ((uint8_t *)want.data)[i]
                    : bits == 16 ? ((uint16_t *)want.data)[i]
                                 : x,
                    bits / 8);
            }
            sheen_err err;
            assert_ok(sheen_raster_parse(&got, t.data, t.size_bytes, &err), err);
            assert_same_raster(&got, &want);
            assert_probe(t.data, t.size_bytes, 4, 3);
            assert_cuts_refused(t.data, t.size_bytes);
            sheen_raster_release(&got);
            sheen_raster_release(&want);
        }
}

static void tiff_white_is_zero_and_tiles(void **state)
{
    (void)state;
    const tag inverted[] = {{256, 2}, {257, 1}, {258, 8}, {259, 1}, {262, 0},
                            {273, 0}, {277, 1}, {278, 1}, {279, 2}, {0, 0}};
    tiff t;
    uint32_t pixels_at;
    begin_tiff(&t, false, inverted, 0, &pixels_at);
    put(&t, 255, 1);
    put(&t, 10, 1);
    sheen_err err;
    sheen_raster r;
    assert_ok(sheen_raster_parse(&r, t.data, t.size_bytes, &err), err);
    assert_int_equal(((uint8_t *)r.data)[0], 0);
    assert_int_equal(((uint8_t *)r.data)[1], 245);
    sheen_raster_release(&r);

    // one tile of 16 x 16 holds a picture of 5 x 3
    const tag tiled[] = {{256, 5},  {257, 3},  {258, 8}, {259, 1},   {262, 1}, {277, 1},
                         {322, 16}, {323, 16}, {324, 0}, {325, 256}, {0, 0}};
    begin_tiff(&t, true, tiled, 0, &pixels_at);
    for (uint32_t i = 0; i < 256; i++)
        put(&t, i, 1);
    assert_ok(sheen_raster_parse(&r, t.data, t.size_bytes, &err), err);
    for (int y = 0; y < 3; y++)
        for (int x = 0; x < 5; x++)
            assert_int_equal(((uint8_t *)r.data)[5 * y + x], 16 * y + x);
    sheen_raster_release(&r);
    assert_cuts_refused(t.data, t.size_bytes);
}

// Files of other programs: the same picture in each layout and compression.
static void tiff_variants_agree(void **state)
{
    (void)state;
    static const char *const paths[] = {CORPUS "tiff/lzw.tif", CORPUS "tiff/zip.tif",
                                        CORPUS "tiff/planes.tif", CORPUS "tiff/tiles.tif",
                                        CORPUS "tiff/big.tif"};
    sheen_err err;
    sheen_raster plain, other;
    assert_ok(sheen_raster_load(&plain, CORPUS "tiff/rgb8.tif", &err), err);
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        assert_ok(sheen_raster_load(&other, paths[i], &err), err);
        assert_same_raster(&other, &plain);
        sheen_raster_release(&other);
    }
    assert_ok(sheen_raster_load(&other, CORPUS "tiff/palette.tif", &err), err);
    assert_int_equal(other.n_channels, 3);
    sheen_raster_release(&other);
    assert_ok(sheen_raster_load(&other, CORPUS "tiff/rgba.tif", &err), err);
    assert_int_equal(other.n_channels, 4);
    sheen_raster_release(&other);
    sheen_raster_release(&plain);
}

static void exr_round_trips(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "a.exr");
    for (int n_channels = 1; n_channels <= 4; n_channels++)
        for (int half = 0; half < 2; half++) {
            sheen_err err;
            sheen_raster want = make_raster(11, 37, n_channels, 32), back; // more than two chunks of 16 lines
            const sheen_image img = {want.data, 11, 37, n_channels};
            assert_ok(sheen_exr_write(path, &img, NULL, half, &err), err);
            assert_ok(sheen_raster_load(&back, path, &err), err);
            assert_int_equal(back.bits, 32);
            assert_int_equal(back.n_channels, n_channels);
            for (int i = 0; i < 11 * 37 * n_channels; i++) {
                const float x = ((float *)want.data)[i];
                assert_close(((float *)back.data)[i], x, half ? 0x1p-11 * fabs((double)x) + 1e-7 : 0);
            }
            size_t size_bytes;
            uint8_t *data = test_file_read(path, &size_bytes);
            assert_probe(data, size_bytes, 11, 37);
            assert_cuts_refused(data, size_bytes);
            free(data);
            sheen_raster_release(&back);
            sheen_raster_release(&want);
        }
}

static void exr_half_clamps_and_keeps_names(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "b.exr");
    sheen_err err;
    float light[] = {1e9f, -1e9f, 0.5f};
    const sheen_image img = {light, 1, 1, 3};
    sheen_raster back;
    static const char *const layer[] = {"View.R", "View.G", "View.B"};
    assert_ok(sheen_exr_write(path, &img, layer, true, &err), err);
    assert_ok(sheen_raster_load(&back, path, &err), err);
    assert_close(((float *)back.data)[0], 65504, 0);
    assert_close(((float *)back.data)[1], -65504, 0);
    assert_close(((float *)back.data)[2], 0.5, 0);
    sheen_raster_release(&back);
    static const char *const twice[] = {"R", "G", "R"};
    assert_int_equal(sheen_exr_write(path, &img, twice, true, &err), SHEEN_EARG);
    assert_non_null(strstr(err.msg, "channels want distinct names"));
    static const char *const unknown[] = {"u", "v", "w"};
    assert_ok(sheen_exr_write(path, &img, unknown, false, &err), err);
    assert_fails(sheen_raster_load(&back, path, &err), err, SHEEN_EUNSUP,
                 "OpenEXR file has no channels R, G, B or Y");
}

// All from one 9 x 35 picture of (x + 9 y) (0.5, 0.25, 0.125) + (0, 0, 1), by the OpenEXR project's own writer.
static void exr_variants(void **state)
{
    (void)state;
    static const char *const paths[] = {CORPUS "exr/compression-none.exr",
                                        CORPUS "exr/compression-rle.exr",
                                        CORPUS "exr/compression-zips.exr",
                                        CORPUS "exr/compression-piz.exr",
                                        CORPUS "exr/tiled.exr",
                                        CORPUS "exr/mipmap.exr"};
    sheen_err err;
    sheen_raster r;
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        assert_ok(sheen_raster_load(&r, paths[i], &err), err);
        const float *p = r.data;
        for (int k = 0; k < 9 * 35; k++, p += r.n_channels) {
            assert_close(p[0], 0.5 * k, 0);
            assert_close(p[1], 0.25 * k, 0);
            assert_close(p[2], 0.125 * k + 1, 0);
        }
        sheen_raster_release(&r);
    }
    // display window (-3, 0) to (8, 20), data window (2, 5) to (10, 39) with the picture's first pixel
    assert_ok(sheen_raster_load(&r, CORPUS "exr/window.exr", &err), err);
    assert_int_equal(r.width_px, 12);
    assert_int_equal(r.height_px, 21);
    for (int y = 0; y < 21; y++)
        for (int x = 0; x < 12; x++) {
            const bool covered = x - 3 >= 2 && y >= 5;
            const double want = covered ? 0.5 * ((x - 5) + 9 * (y - 5)) : 0;
            assert_close(((float *)r.data)[(y * 12 + x) * 3], want, 0);
        }
    sheen_raster_release(&r);
}

static sheen_status load_picture(const char *path, sheen_err *err)
{
    sheen_raster r;
    const sheen_status s = sheen_raster_load(&r, path, err);
    assert_null(r.data);
    return s;
}

static void says_what_is_wrong(void **state)
{
    (void)state;
    static const test_damaged_file files[] = {
        {"png/claims-30000x30000.png", SHEEN_EFORMAT,
         "the file's 69 bytes cannot hold the 2700 MB of picture that its header claims"},
        {"png/claims-side-too-long.png", SHEEN_EFORMAT, "PNG cannot be decoded: Invalid IHDR data"},
        {"png/cut-in-data.png", SHEEN_EFORMAT, "PNG cannot be decoded: the file is cut short"},
        {"png/rows-missing.png", SHEEN_EFORMAT, "PNG cannot be decoded: Not enough image data"},
        {"png/end-missing.png", SHEEN_EFORMAT, "PNG cannot be decoded: the file is cut short"},
        {"jpeg/claims-30000x30000.jpg", SHEEN_EFORMAT, NULL},
        {"jpeg/end-marker-missing.jpg", SHEEN_EFORMAT, "JPEG cannot be decoded: Premature end of JPEG file"},
        {"jpeg/cmyk.jpg", SHEEN_EUNSUP, "a CMYK JPEG is not supported: save it as RGB"},
        {"jpeg/12-bit.jpg", SHEEN_EUNSUP, "JPEG cannot be decoded: Unsupported JPEG data precision 12"},
        {"jpeg/lossless.jpg", SHEEN_EUNSUP,
         "JPEG cannot be decoded: Unsupported JPEG process: SOF type 0xc3"},
        {"tiff/claims-30000x30000.tif", SHEEN_EFORMAT, NULL},
        {"tiff/tiles-huge.tif", SHEEN_EFORMAT, NULL},
        {"tiff/strip-beyond-end.tif", SHEEN_EFORMAT, NULL},
        {"tiff/no-size.tif", SHEEN_EFORMAT, NULL},
        {"tiff/cmyk.tif", SHEEN_EUNSUP, "a TIFF of colour type 5 is not supported: save it as RGB or grey"},
        {"exr/claims-30000x30000.exr", SHEEN_EFORMAT, NULL},
        {"exr/compression-dwaa.exr", SHEEN_EUNSUP,
         "OpenEXR with DWA compression is not supported: save it with ZIP"},
        {"exr/luminance-chroma.exr", SHEEN_EUNSUP,
         "luminance-chroma OpenEXR is not supported: save it as RGB"},
        {"exr/display-window-huge.exr", SHEEN_EFORMAT, NULL},
        {"hdr/cut.hdr", SHEEN_EFORMAT, "Radiance picture is cut short or damaged in row 1 of 2"},
        {"hdr/run-beyond-row.hdr", SHEEN_EFORMAT, "Radiance picture is cut short or damaged in row 0 of 1"},
        {"hdr/width-differs.hdr", SHEEN_EFORMAT, "Radiance picture is cut short or damaged in row 0 of 1"},
        {"hdr/zero-length.hdr", SHEEN_EFORMAT, "Radiance picture is cut short or damaged in row 0 of 1"},
        {"hdr/repeats-nothing.hdr", SHEEN_EFORMAT, "Radiance picture is cut short or damaged in row 0 of 1"},
        {"hdr/claims-30000x30000.hdr", SHEEN_EFORMAT,
         "the file's 8 bytes cannot hold the 3600 MB of picture that its header claims"},
        {"hdr/xyze.hdr", SHEEN_EUNSUP, "a Radiance picture of format '32-bit_rle_xyze' is not supported"},
        {"hdr/upside-down.hdr", SHEEN_EUNSUP,
         "a Radiance picture with rows in the order '+Y +X' is not supported"},
        {"hdr/no-size.hdr", SHEEN_EFORMAT, "Radiance picture has no line with its size"},
        {"hdr/exposure-none.hdr", SHEEN_EFORMAT, "Radiance header's exposure '-1' is none"},
        {"hdr/header-open.hdr", SHEEN_EFORMAT, "Radiance header is cut short"},
        {"obj/tetrahedron.obj", SHEEN_EFORMAT,
         "not a picture that is read here: neither PNG, JPEG, TIFF, OpenEXR nor Radiance"},
    };
    test_damaged_files(files, sizeof files / sizeof *files, load_picture);
    sheen_err err;
    sheen_raster r;
    assert_int_equal(sheen_raster_parse(&r, "", 0, &err), SHEEN_EFORMAT);
    assert_string_equal(err.msg, "the file is empty");
    assert_int_equal(sheen_raster_load(&r, "/nowhere/a.png", &err), SHEEN_EIO);
    assert_string_equal(err.msg, "cannot open '/nowhere/a.png': No such file or directory");
    assert_int_equal(sheen_raster_parse(&r, "GIF89a", 6, NULL), SHEEN_EFORMAT); // err may be NULL
}

static void writers_refuse_what_they_cannot_write(void **state)
{
    (void)state;
    uint8_t bytes[64] = {0};
    const sheen_raster wide = {bytes, 2, 2, 3, 32}, rgba = {bytes, 2, 2, 4, 8}, grey16 = {bytes, 2, 2, 1, 16};
    const sheen_raster good = {bytes, 2, 2, 3, 8};
    sheen_err err;
    assert_int_equal(sheen_png_write("x.png", &wide, &err), SHEEN_EARG);
    assert_string_equal(err.msg, "cannot write 'x.png': a PNG has 1 to 4 channels of 8 or 16 bits");
    assert_int_equal(sheen_jpeg_write("x.jpg", &rgba, 90, &err), SHEEN_EARG);
    assert_string_equal(err.msg, "cannot write 'x.jpg': a JPEG has 1 or 3 channels of 8 bits");
    assert_int_equal(sheen_jpeg_write("x.jpg", &grey16, 90, &err), SHEEN_EARG);
    assert_int_equal(sheen_jpeg_write("x.jpg", &good, 0, &err), SHEEN_EARG);
    assert_string_equal(err.msg, "cannot write 'x.jpg': JPEG quality is 1 to 100, not 0");
    assert_int_equal(sheen_png_write("/nowhere/x.png", &good, &err), SHEEN_EIO);
    assert_int_equal(sheen_jpeg_write("/nowhere/x.jpg", &good, 90, &err), SHEEN_EIO);
    const sheen_image img = {(float *)(void *)bytes, 1, 1, 2};
    assert_int_equal(sheen_png_write_srgb("x.png", &img, &err), SHEEN_EARG);
    assert_string_equal(err.msg, "cannot write 'x.png': an sRGB PNG has 1, 3 or 4 channels");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(png_round_trips, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test(png_variants_agree),
        cmocka_unit_test_setup_teardown(png_of_light_is_coded_and_clipped, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(jpeg_round_trips_closely, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test(jpeg_variants),
        cmocka_unit_test(tiff_of_all_depths_and_orders),
        cmocka_unit_test(tiff_white_is_zero_and_tiles),
        cmocka_unit_test(tiff_variants_agree),
        cmocka_unit_test_setup_teardown(exr_round_trips, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(exr_half_clamps_and_keeps_names, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(exr_variants),
        cmocka_unit_test(says_what_is_wrong),
        cmocka_unit_test(writers_refuse_what_they_cannot_write),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
