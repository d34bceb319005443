// SPDX-License-Identifier: Apache-2.0
// image_exr.c - OpenEXR through the library's C interface: half, float or whole numbers, scan lines or tiles, any
// compression that it decodes; written as scan lines with ZIP.
//
// Of a file with several layers the first that has R, G, B (or Y) is read, of several parts the first. The
// picture is the display window; where the data window leaves it uncovered it is zero.
#include "base/image_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <OpenEXR/openexr.h>

#include "base/file.h"
#include "base/image_codec.h"

enum { MAX_RATIO = 2000, FREE_BYTES = 64 << 20 };

typedef struct stream {
    const uint8_t *data;
    size_t size_bytes;
    sheen_bytes written;
    char message[160]; // the first: the cause, what follows are consequences
} stream;

static int64_t give_bytes(exr_const_context_t exr, void *self, void *out, uint64_t n_bytes, uint64_t offset,
                          exr_stream_error_func_ptr_t fail)
{
    (void)exr;
    (void)fail; // a short count is an error to the library
    const stream *f = self;
    if (offset >= f->size_bytes)
        return 0;
    const uint64_t left = f->size_bytes - offset, n = n_bytes < left ? n_bytes : left;
    memcpy(out, f->data + offset, n);
    return (int64_t)n;
}

static int64_t take_bytes(exr_const_context_t exr, void *self, const void *from, uint64_t n_bytes,
                          uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    stream *f = self;
    if (sheen_bytes_put(&f->written, offset, from, n_bytes))
        return (int64_t)n_bytes;
    fail(exr, EXR_ERR_OUT_OF_MEMORY, "out of memory");
    return -1;
}

static int64_t size_of(exr_const_context_t exr, void *self)
{
    (void)exr;
    const stream *f = self;
    return (int64_t)f->size_bytes;
}

static void on_error(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)code;
    void *self = NULL;
    if (!exr || exr_get_user_data(exr, &self) || !self)
        return;
    stream *f = self;
    if (!f->message[0])
        snprintf(f->message, sizeof f->message, "%s", message ? message : "");
}

static sheen_status fail_exr(const stream *f, exr_result_t code, sheen_err *err)
{
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory for OpenEXR");
    const bool unsupported = code == EXR_ERR_FEATURE_NOT_IMPLEMENTED;
    return sheen_fail(err, unsupported ? SHEEN_EUNSUP : SHEEN_EFORMAT, "OpenEXR cannot be decoded: %s",
                      f->message[0] ? f->message : exr_get_default_error_message(code));
}

typedef struct reader {
    stream file;
    exr_context_t exr;
    exr_storage_t storage;
    exr_attr_box2i_t data_window, display_window;
    int channels[4], n_channels; // indices in the file's list, in the order of the raster
    sheen_raster raster;         // of the data window
    exr_decode_pipeline_t pipeline;
    bool has_pipeline;
    float *scratch; // [n_channels][lines][width] of one chunk
    size_t scratch_count;
    sheen_err *err;
} reader;

static sheen_status open_reader(reader *r)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_error;
    init.user_data = &r->file;
    init.read_fn = give_bytes;
    init.size_fn = size_of;
    init.max_image_width = init.max_image_height = SHEEN_IMAGE_MAX_SIDE_PX;
    init.max_tile_width = init.max_tile_height = SHEEN_IMAGE_MAX_SIDE_PX;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t code = exr_start_read(&r->exr, "memory", &init);
    return code ? fail_exr(&r->file, code, r->err) : SHEEN_OK;
}

static sheen_status check_window(const exr_attr_box2i_t *w, sheen_err *err)
{
    const int64_t width_px = (int64_t)w->max.x - w->min.x + 1, height_px = (int64_t)w->max.y - w->min.y + 1;
    const uint32_t far = UINT32_MAX;
    return sheen_image_check_sides(width_px < 1     ? 0
                                   : width_px > far ? far
                                                    : (uint32_t)width_px,
                                   height_px < 1     ? 0
                                   : height_px > far ? far
                                                     : (uint32_t)height_px,
                                   err);
}

static sheen_status read_header(reader *r)
{
    exr_result_t code = exr_get_storage(r->exr, 0, &r->storage);
    if (!code)
        code = exr_get_data_window(r->exr, 0, &r->data_window);
    if (!code)
        code = exr_get_display_window(r->exr, 0, &r->display_window);
    if (code)
        return fail_exr(&r->file, code, r->err);
    if (r->storage != EXR_STORAGE_SCANLINE && r->storage != EXR_STORAGE_TILED)
        return sheen_fail(r->err, SHEEN_EUNSUP, "a deep OpenEXR file is not supported: save it flattened");
    exr_compression_t compression = EXR_COMPRESSION_NONE;
    code = exr_get_compression(r->exr, 0, &compression);
    if (code)
        return fail_exr(&r->file, code, r->err);
    if (compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB)
        return sheen_fail(r->err, SHEEN_EUNSUP,
                          "OpenEXR with DWA compression is not supported: save it with ZIP");
    const sheen_status s = check_window(&r->data_window, r->err);
    return s ? s : check_window(&r->display_window, r->err);
}

// The channel "<layer><name>", or -1.
static int find_channel(const exr_attr_chlist_t *list, const char *layer, size_t layer_length,
                        const char *name)
{
    for (int i = 0; i < list->num_channels; i++) {
        const char *full = list->entries[i].name.str;
        if (!strncmp(full, layer, layer_length) && !strcmp(full + layer_length, name))
            return i;
    }
    return -1;
}

// R G B [A], or Y [A], of one layer; the layer's name ends with a dot or is empty.
static bool choose_layer(reader *r, const exr_attr_chlist_t *list, const char *layer, size_t layer_length)
{
    static const char *const rgb[] = {"R", "G", "B"}, *const y[] = {"Y"};
    for (int kind = 0; kind < 2; kind++) {
        const char *const *names = kind ? y : rgb;
        const int n = kind ? 1 : 3;
        r->n_channels = 0;
        for (int i = 0; i < n; i++) {
            const int at = find_channel(list, layer, layer_length, names[i]);
            if (at >= 0)
                r->channels[r->n_channels++] = at;
        }
        if (r->n_channels < n)
            continue;
        const int alpha = find_channel(list, layer, layer_length, "A");
        if (alpha >= 0)
            r->channels[r->n_channels++] = alpha;
        return true;
    }
    return false;
}

static sheen_status choose_channels(reader *r)
{
    const exr_attr_chlist_t *list = NULL;
    const exr_result_t code = exr_get_channels(r->exr, 0, &list);
    if (code)
        return fail_exr(&r->file, code, r->err);
    bool found = choose_layer(r, list, "", 0);
    for (int i = 0; !found && i < list->num_channels; i++) {
        const char *name = list->entries[i].name.str, *dot = strrchr(name, '.');
        if (dot)
            found = choose_layer(r, list, name, (size_t)(dot + 1 - name));
    }
    if (!found && list->num_channels == 1) { // a mask or a depth by any name
        r->channels[0] = 0;
        r->n_channels = 1;
        found = true;
    }
    if (!found)
        return sheen_fail(r->err, SHEEN_EUNSUP, "OpenEXR file has no channels R, G, B or Y");
    for (int i = 0; i < r->n_channels; i++) {
        const exr_attr_chlist_entry_t *c = &list->entries[r->channels[i]];
        if (c->x_sampling != 1 || c->y_sampling != 1)
            return sheen_fail(r->err, SHEEN_EUNSUP, "subsampled OpenEXR channel '%.40s' is not supported",
                              c->name.str);
    }
    if (r->n_channels == 1 && find_channel(list, "", 0, "RY") >= 0)
        return sheen_fail(r->err, SHEEN_EUNSUP, "luminance-chroma OpenEXR is not supported: save it as RGB");
    return SHEEN_OK;
}

// Points the library's channels to planes of the scratch memory, one after the other; those that are not wanted
// share one more. (Version 3.1 mixes up the channels of half RGBA when it is to interleave them itself, and writes
// through null pointers when it is to leave one of four out.)
static exr_result_t set_planes(reader *r, const exr_chunk_info_t *chunk)
{
    const size_t plane = (size_t)chunk->width * (size_t)chunk->height;
    const size_t count = plane * (size_t)(r->n_channels + 1);
    if (count > r->scratch_count) {
        free(r->scratch);
        r->scratch_count = 0;
        r->scratch = malloc(count * sizeof *r->scratch);
        if (!r->scratch)
            return EXR_ERR_OUT_OF_MEMORY;
        r->scratch_count = count;
    }
    for (int i = 0; i < r->pipeline.channel_count; i++) {
        exr_coding_channel_info_t *c = &r->pipeline.channels[i];
        if (c->width < 0 || c->width > chunk->width || c->height < 0 || c->height > chunk->height)
            return EXR_ERR_BAD_CHUNK_LEADER;
        c->decode_to_ptr = (uint8_t *)(r->scratch + (size_t)r->n_channels * plane);
        c->user_pixel_stride = sizeof(float);
        c->user_line_stride = chunk->width * (int32_t)sizeof(float);
        c->user_bytes_per_element = sizeof(float);
        c->user_data_type = EXR_PIXEL_FLOAT;
    }
    for (int i = 0; i < r->n_channels; i++) {
        if (r->channels[i] >= r->pipeline.channel_count)
            return EXR_ERR_INVALID_ATTR;
        exr_coding_channel_info_t *c = &r->pipeline.channels[r->channels[i]];
        if (c->width != chunk->width || c->height != chunk->height)
            return EXR_ERR_BAD_CHUNK_LEADER;
        c->decode_to_ptr = (uint8_t *)(r->scratch + (size_t)i * plane);
    }
    return EXR_ERR_SUCCESS;
}

// Decodes one chunk to (x, y) of the raster.
static exr_result_t decode_chunk(reader *r, const exr_chunk_info_t *chunk, int x, int y)
{
    if (chunk->width < 1 || chunk->height < 1 || chunk->width > r->raster.width_px - x ||
        chunk->height > r->raster.height_px - y)
        return EXR_ERR_BAD_CHUNK_LEADER;
    exr_result_t code = r->has_pipeline ? exr_decoding_update(r->exr, 0, chunk, &r->pipeline)
                                        : exr_decoding_initialize(r->exr, 0, chunk, &r->pipeline);
    if (!code)
        code = set_planes(r, chunk);
    if (!code && !r->has_pipeline)
        code = exr_decoding_choose_default_routines(r->exr, 0, &r->pipeline);
    if (code)
        return code;
    r->has_pipeline = true;
    code = exr_decoding_run(r->exr, 0, &r->pipeline);
    if (code)
        return code;
    const size_t n_channels = (size_t)r->n_channels, width = (size_t)chunk->width,
                 height = (size_t)chunk->height;
    for (size_t i = 0; i < n_channels; i++)
        for (size_t line = 0; line < height; line++) {
            const float *from = r->scratch + (i * height + line) * width;
            const size_t at = ((size_t)y + line) * (size_t)r->raster.width_px + (size_t)x;
            float *to = (float *)r->raster.data + at * n_channels + i;
            for (size_t k = 0; k < width; k++)
                to[k * n_channels] = from[k];
        }
    return EXR_ERR_SUCCESS;
}

static exr_result_t decode_lines(reader *r)
{
    int32_t n_lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(r->exr, 0, &n_lines);
    if (!code && n_lines < 1)
        code = EXR_ERR_INVALID_ATTR;
    for (int y = 0; !code && y < r->raster.height_px; y += n_lines) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(r->exr, 0, r->data_window.min.y + y, &chunk);
        if (!code)
            code = decode_chunk(r, &chunk, 0, y);
    }
    return code;
}

static exr_result_t decode_tiles(reader *r)
{
    int32_t tile_w = 0, tile_h = 0;
    exr_result_t code = exr_get_tile_sizes(r->exr, 0, 0, 0, &tile_w, &tile_h);
    if (!code && (tile_w < 1 || tile_h < 1))
        code = EXR_ERR_INVALID_ATTR;
    for (int y = 0, row = 0; !code && y < r->raster.height_px; y += tile_h, row++)
        for (int x = 0, col = 0; !code && x < r->raster.width_px; x += tile_w, col++) {
            exr_chunk_info_t chunk;
            code = exr_read_tile_chunk_info(r->exr, 0, col, row, 0, 0, &chunk);
            if (!code)
                code = decode_chunk(r, &chunk, x, y);
        }
    return code;
}

static sheen_status decode(reader *r)
{
    const int width_px = r->data_window.max.x - r->data_window.min.x + 1;
    const int height_px = r->data_window.max.y - r->data_window.min.y + 1;
    const double decoded_bytes = (double)width_px * height_px * r->n_channels * sizeof(float);
    sheen_status s = sheen_image_check_claim(decoded_bytes, r->file.size_bytes, MAX_RATIO, FREE_BYTES,
                                             r->err);
    if (!s)
        s = sheen_raster_init(&r->raster, width_px, height_px, r->n_channels, 32, r->err);
    if (s)
        return s;
    const exr_result_t code = r->storage == EXR_STORAGE_TILED ? decode_tiles(r) : decode_lines(r);
    return code ? fail_exr(&r->file, code, r->err) : SHEEN_OK;
}

// From the data window's raster to the display window's.
static sheen_status fit_display_window(reader *r)
{
    const exr_attr_box2i_t *from = &r->data_window, *to = &r->display_window;
    if (!memcmp(from, to, sizeof *from))
        return SHEEN_OK;
    const int width_px = to->max.x - to->min.x + 1, height_px = to->max.y - to->min.y + 1;
    const double bytes = (double)width_px * height_px * r->n_channels * sizeof(float);
    sheen_status s = sheen_image_check_claim(bytes, r->file.size_bytes, MAX_RATIO, FREE_BYTES, r->err);
    sheen_raster whole = {0};
    if (!s)
        s = sheen_raster_init(&whole, width_px, height_px, r->n_channels, 32, r->err);
    if (s)
        return s;
    const int left = from->min.x > to->min.x ? from->min.x : to->min.x;
    const int right = from->max.x < to->max.x ? from->max.x : to->max.x;
    const int top = from->min.y > to->min.y ? from->min.y : to->min.y;
    const int low = from->max.y < to->max.y ? from->max.y : to->max.y;
    const size_t n_channels = (size_t)r->n_channels;
    for (int y = top; y <= low && left <= right; y++) {
        const size_t in = (size_t)(y - from->min.y) * (size_t)r->raster.width_px +
                          (size_t)(left - from->min.x);
        const size_t out = (size_t)(y - to->min.y) * (size_t)width_px + (size_t)(left - to->min.x);
        memcpy((float *)whole.data + out * n_channels, (const float *)r->raster.data + in * n_channels,
               (size_t)(right - left + 1) * n_channels * sizeof(float));
    }
    sheen_raster_release(&r->raster);
    r->raster = whole;
    return SHEEN_OK;
}

static void close_reader(reader *r)
{
    if (r->pipeline.context)
        exr_decoding_destroy(r->exr, &r->pipeline);
    if (r->exr)
        exr_finish(&r->exr);
    free(r->scratch);
}

sheen_status sheen_exr_parse(sheen_raster *out, const void *data, size_t size_bytes, sheen_err *err)
{
    *out = (sheen_raster){0};
    reader r = {.file = {.data = data, .size_bytes = size_bytes}, .err = err};
    sheen_status s = open_reader(&r);
    if (!s)
        s = read_header(&r);
    if (!s)
        s = choose_channels(&r);
    if (!s)
        s = decode(&r);
    if (!s)
        s = fit_display_window(&r);
    close_reader(&r);
    if (s)
        sheen_raster_release(&r.raster);
    *out = r.raster;
    return s;
}

sheen_status sheen_exr_probe(int *width_px, int *height_px, const void *data, size_t size_bytes,
                             sheen_err *err)
{
    reader r = {.file = {.data = data, .size_bytes = size_bytes}, .err = err};
    sheen_status s = open_reader(&r);
    if (!s)
        s = read_header(&r);
    close_reader(&r);
    if (!s) {
        *width_px = r.display_window.max.x - r.display_window.min.x + 1;
        *height_px = r.display_window.max.y - r.display_window.min.y + 1;
    }
    return s;
}

typedef struct writer {
    stream file;
    exr_context_t exr;
    const sheen_image *img;
    const char *const *names;
    bool half;
    float *lines; // one chunk's, clamped to what half can hold
} writer;

static exr_result_t write_header(writer *w)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_error;
    init.user_data = &w->file;
    init.write_fn = take_bytes;
    int part = 0;
    exr_result_t code = exr_start_write(&w->exr, "memory", EXR_WRITE_FILE_DIRECTLY, &init);
    if (!code)
        code = exr_add_part(w->exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!code)
        code = exr_initialize_required_attr_simple(w->exr, part, w->img->width_px, w->img->height_px,
                                                   EXR_COMPRESSION_ZIP);
    for (int c = 0; !code && c < w->img->n_channels; c++)
        code = exr_add_channel(w->exr, part, w->names[c], w->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return code ? code : exr_write_header(w->exr);
}

static const float *chunk_lines(writer *w, int y, int n_lines)
{
    const float *from = sheen_image_at(w->img, 0, y);
    if (!w->half)
        return from;
    const float max_half = 65504;
    const size_t n = (size_t)n_lines * (size_t)w->img->width_px * (size_t)w->img->n_channels;
    for (size_t i = 0; i < n; i++)
        w->lines[i] = from[i] > max_half ? max_half : from[i] < -max_half ? -max_half : from[i];
    return w->lines;
}

static exr_result_t write_chunk(writer *w, int y, int n_lines)
{
    exr_chunk_info_t chunk;
    exr_result_t code = exr_write_scanline_chunk_info(w->exr, 0, y, &chunk);
    if (code)
        return code;
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    code = exr_encoding_initialize(w->exr, 0, &chunk, &pipeline);
    if (code)
        return code;
    const float *lines = chunk_lines(w, y, n_lines);
    const int32_t pixel_bytes = w->img->n_channels * (int32_t)sizeof(float);
    for (int i = 0; i < pipeline.channel_count; i++) { // sorted by name in the file
        exr_coding_channel_info_t *out = &pipeline.channels[i];
        int c = 0;
        while (strcmp(out->channel_name, w->names[c]))
            c++;
        out->encode_from_ptr = (const uint8_t *)(lines + c);
        out->user_bytes_per_element = sizeof(float);
        out->user_data_type = EXR_PIXEL_FLOAT;
        out->user_pixel_stride = pixel_bytes;
        out->user_line_stride = pixel_bytes * w->img->width_px;
    }
    code = exr_encoding_choose_default_routines(w->exr, 0, &pipeline);
    if (!code)
        code = exr_encoding_run(w->exr, 0, &pipeline);
    exr_encoding_destroy(w->exr, &pipeline);
    return code;
}

static exr_result_t write_all(writer *w)
{
    enum { ZIP_LINES = 16 };
    exr_result_t code = write_header(w);
    if (!code && w->half) {
        w->lines = malloc(ZIP_LINES * (size_t)w->img->width_px * (size_t)w->img->n_channels *
                          sizeof *w->lines);
        code = w->lines ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
    }
    for (int y = 0; !code && y < w->img->height_px; y += ZIP_LINES) {
        const int left = w->img->height_px - y;
        code = write_chunk(w, y, left < ZIP_LINES ? left : ZIP_LINES);
    }
    free(w->lines);
    if (!w->exr)
        return code;
    const exr_result_t finish = exr_finish(&w->exr); // writes the table of chunks
    return code ? code : finish;
}

static bool names_are_distinct(const char *const *names, int n)
{
    for (int i = 0; i < n; i++) {
        if (!names[i] || !names[i][0])
            return false;
        for (int j = 0; j < i; j++)
            if (!strcmp(names[i], names[j]))
                return false;
    }
    return true;
}

sheen_status sheen_exr_encode(uint8_t **data_out, size_t *size_bytes_out, const sheen_image *img,
                              const char *const *channel_names, bool half, sheen_err *err)
{
    static const char *const rgba[] = {"R", "G", "B", "A"}, *const ya[] = {"Y", "A"};
    *data_out = NULL;
    *size_bytes_out = 0;
    if (!img->data || img->n_channels < 1 || img->n_channels > 4)
        return sheen_fail(err, SHEEN_EARG, "a picture has 1 to 4 channels");
    const char *const *names = channel_names ? channel_names : img->n_channels >= 3 ? rgba : ya;
    if (!names_are_distinct(names, img->n_channels))
        return sheen_fail(err, SHEEN_EARG, "channels want distinct names");
    writer w = {.img = img, .names = names, .half = half};
    const exr_result_t code = write_all(&w);
    if (code) {
        free(w.file.written.data);
        return sheen_fail(err, code == EXR_ERR_OUT_OF_MEMORY ? SHEEN_ENOMEM : SHEEN_EARG, "%s",
                          w.file.message[0] ? w.file.message : exr_get_default_error_message(code));
    }
    *data_out = w.file.written.data;
    *size_bytes_out = w.file.written.size_bytes;
    return SHEEN_OK;
}

sheen_status sheen_exr_write(const char *path, const sheen_image *img, const char *const *channel_names,
                             bool half, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_exr_encode(&data, &size_bytes, img, channel_names, half, err);
    if (s)
        return sheen_wrap(err, s, "cannot write '%s'", path);
    s = sheen_file_write(path, data, size_bytes, err);
    free(data);
    return s;
}
