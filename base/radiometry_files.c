// SPDX-License-Identifier: Apache-2.0
// radiometry_files.c - radiometry/ of a session: what was measured, stored and found again for a frame.
//
// A measurement is a description (as a frame has one) that names its data by their digest: data first, then the
// description in one step, then the old data are removed. Whoever reads in between finds one or the other whole.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/radiometry_private.h"
#include "base/session_private.h"

enum { SIDECAR_MAX_BYTES = 1 << 20, MAX_DARKS = 100 };
static const size_t data_max_bytes = (size_t)1 << 30;
static const float least_white =
    0.125f; // of the brightest: where a flat field is darker, it is not followed further
static const char *const names[SHEEN_MEASURE_COUNT] = {"dark", "flat", "response"};

static sheen_status path_of(char out[SHEEN_PATH_MAX], const sheen_session *s, const char *name,
                            const char *ending, sheen_err *err)
{
    char file[160];
    snprintf(file, sizeof file, SHEEN_SESSION_RADIOMETRY "/%s%s", name, ending);
    return sheen_session_path(out, s, file, err);
}

static bool has(const sheen_session *s, const char *name)
{
    char path[SHEEN_PATH_MAX];
    return !path_of(path, s, name, ".json", NULL) && sheen_file_exists(path);
}

static void name_of(char name[32], sheen_measure kind, int i)
{
    if (kind == SHEEN_MEASURE_DARK)
        snprintf(name, 32, "%s-%d", names[kind], i);
    else
        snprintf(name, 32, "%s", names[kind]);
}

static sheen_status read_description(sheen_frame_info *f, const sheen_session *s, const char *name,
                                     sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    uint8_t *data;
    size_t size_bytes;
    sheen_status st = path_of(path, s, name, ".json", err);
    if (!st)
        st = sheen_file_read(&data, &size_bytes, path, SIDECAR_MAX_BYTES, err);
    if (st)
        return st;
    snprintf(f->name, sizeof f->name, "%s", name);
    st = sheen_frame_info_parse(f, data, size_bytes, err);
    free(data);
    if (!st && (strncmp(f->file, name, strlen(name)) != 0 || strchr(f->file, '/')))
        st = sheen_fail(err, SHEEN_EFORMAT, "its data cannot be in '%s'", f->file);
    return st ? sheen_wrap(err, st, "'%s' is damaged: measure it again, or remove the file", path) : SHEEN_OK;
}

static sheen_status read_data(sheen_raster *out, const sheen_session *s, const sheen_frame_info *f,
                              sheen_err *err)
{
    char path[SHEEN_PATH_MAX], digest[33];
    uint8_t *data;
    size_t size_bytes;
    *out = (sheen_raster){0};
    sheen_status st = path_of(path, s, f->file, "", err);
    if (!st)
        st = sheen_file_read(&data, &size_bytes, path, data_max_bytes, err);
    if (st)
        return st;
    sheen_digest(digest, data, size_bytes);
    st = strcmp(digest, f->payload_digest) != 0
             ? sheen_fail(err, SHEEN_EFORMAT, "'%s' is not what was measured: measure it again", path)
             : sheen_raster_parse(out, data, size_bytes, err);
    free(data);
    return st;
}

// A raster of codes of the size that its description states.
static sheen_status read_codes(sheen_raster *out, const sheen_session *s, const sheen_frame_info *f,
                               sheen_err *err)
{
    sheen_status st = read_data(out, s, f, err);
    if (!st && (out->bits != 16 || out->width_px != f->width_px || out->height_px != f->height_px ||
                (out->n_channels != 1 && out->n_channels != 3)))
        st = sheen_fail(err, SHEEN_EFORMAT,
                        "'%s' is not of the size or kind that it should be: measure again", f->file);
    if (st)
        sheen_raster_release(out);
    return st;
}

// The dark frame among the session's that belongs to frame f. There may be none only where there are no dark frames.
static sheen_status load_dark(sheen_raster *out, const sheen_session *s, const sheen_frame_info *f,
                              sheen_err *err)
{
    sheen_err why = {0};
    char name[32];
    int n = 0;
    for (int i = 0; i < MAX_DARKS; i++) {
        sheen_frame_info dark;
        name_of(name, SHEEN_MEASURE_DARK, i);
        if (!has(s, name))
            break;
        sheen_status st = read_description(&dark, s, name, err);
        if (st)
            return st;
        if (!sheen_measure_belongs(SHEEN_MEASURE_DARK, &dark, f, &why))
            return read_codes(out, s, &dark, err);
        n++;
    }
    return n ? sheen_fail(err, SHEEN_EDATA,
                          "no dark frame of the session was taken as this frame was (%s): cover the lens and "
                          "give 'sheen capture' its --dark, or remove the files dark-* in '%.200s/%s'",
                          why.msg, s->path, SHEEN_SESSION_RADIOMETRY)
             : SHEEN_OK;
}

static sheen_status check_belongs(sheen_measure kind, const sheen_frame_info *a, const sheen_frame_info *f,
                                  const sheen_session *s, sheen_err *err)
{
    sheen_err why;
    if (!sheen_measure_belongs(kind, a, f, &why))
        return SHEEN_OK;
    return sheen_fail(err, SHEEN_EDATA,
                      "the session's %s does not belong to this frame (%s): measure it anew with 'sheen "
                      "capture --%s', or remove the files %s* in '%.200s/%s'",
                      kind == SHEEN_MEASURE_FLAT ? "flat field" : "response curve", why.msg, names[kind],
                      names[kind], s->path, SHEEN_SESSION_RADIOMETRY);
}

static sheen_status load_response(sheen_radiometry *r, const sheen_session *s, const sheen_frame_info *f,
                                  sheen_err *err)
{
    sheen_frame_info info;
    sheen_raster raster;
    if (!has(s, names[SHEEN_MEASURE_RESPONSE]))
        return SHEEN_OK;
    sheen_status st = read_description(&info, s, names[SHEEN_MEASURE_RESPONSE], err);
    if (!st)
        st = check_belongs(SHEEN_MEASURE_RESPONSE, &info, f, s, err);
    if (!st)
        st = read_data(&raster, s, &info, err);
    if (st)
        return st;
    const float *light = raster.data;
    bool good = raster.bits == 32 && raster.n_channels == 1 && raster.height_px == 1 && raster.width_px >= 2;
    for (int i = 0; good && i < raster.width_px; i++)
        good = isfinite(light[i]) && light[i] >= (i ? light[i - 1] : 0);
    st = good ? sheen_image_init(&r->response, raster.width_px, 1, 1, err)
              : sheen_fail(err, SHEEN_EFORMAT, "'%s' is no curve: measure it again", info.file);
    if (!st)
        memcpy(r->response.data, light, (size_t)raster.width_px * sizeof *light);
    r->response_residual = info.bracket.residual;
    sheen_raster_release(&raster);
    return st;
}

// Gain of each channel by itself, so that the colour of the white does not matter: the brightest part, noise aside
// (all but a thousandth of the pixels lie below), over the pixel.
static void gain_of(sheen_image *flat)
{
    enum { N_BINS = 4096 };
    const size_t n = (size_t)flat->width_px * (size_t)flat->height_px;
    for (size_t c = 0; c < 3; c++) {
        size_t counts[N_BINS] = {0}, above = 0;
        int bin = N_BINS - 1;
        for (size_t i = 0; i < n; i++)
            counts[(int)fminf(flat->data[3 * i + c] * (float)N_BINS, (float)(N_BINS - 1))]++;
        while (bin > 0 && (above += counts[bin]) <= n / 1000)
            bin--;
        const float white = (float)(bin + 1) / (float)N_BINS;
        for (size_t i = 0; i < n; i++) {
            const float share = flat->data[3 * i + c] / white;
            flat->data[3 * i + c] = 1 / fminf(1, fmaxf(least_white, share));
        }
    }
}

static sheen_status load_flat(sheen_radiometry *r, const sheen_session *s, const sheen_frame_info *f,
                              sheen_err *err)
{
    sheen_frame_info info;
    sheen_raster codes;
    sheen_radiometry by = {
        .response = r->response}; // lent; the dark is that of the flat field's own settings
    if (!has(s, names[SHEEN_MEASURE_FLAT]))
        return SHEEN_OK;
    sheen_status st = read_description(&info, s, names[SHEEN_MEASURE_FLAT], err);
    if (!st)
        st = check_belongs(SHEEN_MEASURE_FLAT, &info, f, s, err);
    if (!st)
        st = read_codes(&codes, s, &info, err);
    if (st)
        return st;
    st = load_dark(&by.dark, s, &info, err);
    if (st)
        st = sheen_wrap(err, st, "the flat field cannot be used");
    if (!st)
        st = sheen_radiometry_light(&r->gain, &by, &info, &codes, err);
    if (!st)
        gain_of(&r->gain);
    sheen_raster_release(&codes);
    sheen_raster_release(&by.dark);
    return st;
}

sheen_status sheen_radiometry_load(sheen_radiometry *r, const sheen_session *s, const sheen_frame_info *f,
                                   sheen_err *err)
{
    char dir[SHEEN_PATH_MAX];
    *r = (sheen_radiometry){.response_residual = (double)NAN};
    sheen_status st = sheen_session_path(dir, s, SHEEN_SESSION_RADIOMETRY, err);
    if (st || !sheen_dir_exists(dir))
        return st;
    if (!f->bracket.n_exposures) { // else these were applied to each exposure
        st = load_response(r, s, f, err);
        if (!st)
            st = load_dark(&r->dark, s, f, err);
    }
    if (!st)
        st = load_flat(r, s, f, err);
    if (st)
        sheen_radiometry_release(r);
    return st;
}

// The name under which it is stored: that of what it replaces, else the next one.
static sheen_status choose_name(char name[32], const sheen_session *s, sheen_measure kind,
                                const sheen_frame_info *taken, sheen_err *err)
{
    name_of(name, kind, 0);
    for (int i = 0; kind == SHEEN_MEASURE_DARK && has(s, name); i++) {
        sheen_frame_info other;
        if (i == MAX_DARKS)
            return sheen_fail(err, SHEEN_EARG, "the session has %d dark frames: remove those of '%.200s/%s'",
                              MAX_DARKS, s->path, SHEEN_SESSION_RADIOMETRY);
        if (!read_description(&other, s, name, NULL) && !sheen_measure_belongs(kind, &other, taken, NULL))
            return SHEEN_OK;
        name_of(name, kind, i + 1);
    }
    return SHEEN_OK;
}

sheen_status sheen_radiometry_store(const sheen_session *s, sheen_measure kind, const sheen_frame_info *taken,
                                    const sheen_raster *codes, const sheen_image *response, sheen_err *err)
{
    char dir[SHEEN_PATH_MAX], path[SHEEN_PATH_MAX], name[32];
    sheen_frame_info info = *taken, old;
    uint8_t *data = NULL;
    size_t size_bytes;
    sheen_status st = sheen_session_path(dir, s, SHEEN_SESSION_RADIOMETRY, err);
    if (!st)
        st = sheen_dir_make(dir, err);
    if (!st)
        st = choose_name(name, s, kind, taken, err);
    if (!st)
        st = codes ? sheen_png_encode(&data, &size_bytes, codes, err)
                   : sheen_exr_encode(&data, &size_bytes, response, NULL, false, err);
    if (st)
        return st;
    const bool replaces = has(s, name) && !read_description(&old, s, name, NULL);
    sheen_digest(info.payload_digest, data, size_bytes);
    snprintf(info.file, sizeof info.file, "%s-%.8s.%s", name, info.payload_digest, codes ? "png" : "exr");
    st = path_of(path, s, info.file, "", err);
    if (!st)
        st = sheen_file_write(path, data, size_bytes, err);
    free(data);
    if (!st)
        st = path_of(path, s, name, ".json", err);
    if (!st)
        st = sheen_frame_info_save(&info, path, err);
    if (!st && replaces && strcmp(old.file, info.file) != 0 && !path_of(path, s, old.file, "", NULL))
        sheen_file_remove(path, NULL);
    return st;
}

static sheen_status copy_file(const sheen_session *to, const sheen_session *from, const char *name,
                              const char *ending, sheen_err *err)
{
    char to_path[SHEEN_PATH_MAX], from_path[SHEEN_PATH_MAX];
    sheen_status st = path_of(to_path, to, name, ending, err);
    if (!st)
        st = path_of(from_path, from, name, ending, err);
    return st ? st : sheen_file_copy(to_path, from_path, err);
}

sheen_status sheen_radiometry_copy(const sheen_session *to, const sheen_session *from, sheen_err *err)
{
    char dir[SHEEN_PATH_MAX], name[32];
    sheen_status st = sheen_session_path(dir, to, SHEEN_SESSION_RADIOMETRY, err);
    for (int kind = 0; kind < SHEEN_MEASURE_COUNT && !st; kind++)
        for (int i = 0; i < (kind == SHEEN_MEASURE_DARK ? MAX_DARKS : 1) && !st; i++) {
            sheen_frame_info info;
            name_of(name, (sheen_measure)kind, i);
            if (!has(from, name))
                break;
            if (has(to, name))
                continue;
            st = sheen_dir_make(dir, err);
            if (!st)
                st = read_description(&info, from, name, err);
            if (!st)
                st = copy_file(to, from, info.file, "", err);
            if (!st)
                st = copy_file(to, from, name, ".json", err);
        }
    return st;
}

sheen_status sheen_radiometry_digest(char hex[33], const sheen_session *s, sheen_err *err)
{
    enum { MAX_TEXT = (MAX_DARKS + 2) * 48 };
    char text[MAX_TEXT] = "", path[SHEEN_PATH_MAX], name[32], digest[33];
    size_t n = 0;
    hex[0] = 0;
    for (int kind = 0; kind < SHEEN_MEASURE_COUNT; kind++)
        for (int i = 0; i < (kind == SHEEN_MEASURE_DARK ? MAX_DARKS : 1); i++) {
            name_of(name, (sheen_measure)kind, i);
            if (!has(s, name))
                break;
            sheen_status st = path_of(path, s, name, ".json", err);
            if (!st)
                st = sheen_file_digest(digest, path, err);
            if (st)
                return st;
            n += (size_t)snprintf(text + n, sizeof text - n, "%s %s\n", name, digest);
        }
    if (n)
        sheen_digest(hex, text, n);
    return SHEEN_OK;
}
