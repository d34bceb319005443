// SPDX-License-Identifier: Apache-2.0
// session_frames.c - the frames of a session: listing, adding, reading back.
//
// A frame is a payload file and its sidecar. The payload is written first; a frame counts only once
// both are there, so a cut between the two leaves a file that nothing refers to.
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/radiometry.h"
#include "base/session_private.h"

enum { SIDECAR_MAX_BYTES = 1 << 20 };
static const size_t payload_max_bytes = (size_t)2 << 30;
static const size_t mask_max_bytes = (size_t)256 << 20;

// Path of "<folder>/<name><suffix>".
static sheen_status path_in(char out[SHEEN_PATH_MAX], const sheen_session *s, const char *folder,
                            const char *name, const char *suffix, sheen_err *err)
{
    char file[160];
    snprintf(file, sizeof file, "%s/%s%s", folder, name, suffix);
    return sheen_session_path(out, s, file, err);
}

static sheen_status read_sidecar(sheen_frame_info *f, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    uint8_t *data;
    size_t size_bytes;
    sheen_status st = path_in(path, s, SHEEN_SESSION_FRAMES, f->name, ".json", err);
    if (!st)
        st = sheen_file_read(&data, &size_bytes, path, SIDECAR_MAX_BYTES, err);
    if (st)
        return st;
    st = sheen_frame_info_parse(f, data, size_bytes, err);
    free(data);
    const size_t n = strlen(f->name);
    if (!st && (strncmp(f->file, f->name, n) != 0 || f->file + n + 1 != sheen_path_extension(f->file)))
        st = sheen_fail(err, SHEEN_EFORMAT, "it belongs to '%s'", f->file);
    return st ? sheen_wrap(
                    err, st,
                    "the description of a frame, '%s', is damaged (remove it and import the frame again)",
                    path)
              : SHEEN_OK;
}

static int compare_frames(const void *a, const void *b)
{
    return strcmp(((const sheen_frame_info *)a)->name, ((const sheen_frame_info *)b)->name);
}

sheen_status sheen_session_list_frames(sheen_session *s, sheen_err *err)
{
    assert(!s->frames);
    char dir[SHEEN_PATH_MAX];
    sheen_names names = {0};
    sheen_status st = sheen_session_path(dir, s, SHEEN_SESSION_FRAMES, err);
    if (st || !sheen_dir_exists(dir))
        return st;
    st = sheen_dir_list(&names, dir, ".json", err);
    if (st)
        return st;
    s->frames = calloc(names.count + 1, sizeof *s->frames);
    if (!s->frames) {
        st = sheen_fail_memory(err, (double)names.count * sizeof *s->frames, "the list of frames");
        goto done;
    }
    for (size_t i = 0; i < names.count; i++) {
        sheen_frame_info *f = &s->frames[s->n_frames];
        const size_t n = strlen(names.names[i]) - 5;
        if (n >= sizeof f->name)
            continue; // no name that a frame may have: not ours
        memcpy(f->name, names.names[i], n);
        f->name[n] = 0;
        if (!sheen_frame_name_ok(f->name))
            continue;
        st = read_sidecar(f, s, err);
        if (st)
            goto done;
        char payload[SHEEN_PATH_MAX];
        if (!path_in(payload, s, SHEEN_SESSION_FRAMES, f->file, "", NULL) && sheen_file_exists(payload))
            s->n_frames++;
    }
    // Files came sorted with their ending: "a-b.json" before "a.json", but "a" comes before "a-b".
    qsort(s->frames, s->n_frames, sizeof *s->frames, compare_frames);

done:
    sheen_names_release(&names);
    return st;
}

// The first place whose name is not before `name`.
static size_t insert_at(const sheen_session *s, const char *name)
{
    size_t lo = 0, hi = s->n_frames;
    while (lo < hi) {
        const size_t mid = (lo + hi) / 2;
        if (strcmp(s->frames[mid].name, name) < 0)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

const sheen_frame_info *sheen_session_find(const sheen_session *s, const char *name)
{
    const size_t i = insert_at(s, name);
    return i < s->n_frames && !strcmp(s->frames[i].name, name) ? &s->frames[i] : NULL;
}

// Room for one more in the list.
static sheen_status reserve(sheen_session *s, sheen_err *err)
{
    sheen_frame_info *frames = realloc(s->frames, (s->n_frames + 1) * sizeof *frames);
    if (!frames)
        return sheen_fail_memory(err, (double)(s->n_frames + 1) * sizeof *frames, "the list of frames");
    s->frames = frames;
    return SHEEN_OK;
}

sheen_status sheen_session_write_frame(const sheen_session *s, sheen_frame_info *info, const char *extension,
                                       const void *payload, size_t size_bytes, sheen_err *err)
{
    char payload_path[SHEEN_PATH_MAX], sidecar_path[SHEEN_PATH_MAX];
    if (!sheen_frame_name_ok(info->name))
        return sheen_fail(err, SHEEN_EARG, "'%s' is no name for a frame: use letters, digits, '.', '_', '-'",
                          info->name);
    if (!sheen_frame_extension_ok(extension))
        return sheen_fail(err, SHEEN_EARG, "'%.20s' is no ending for a frame's file", extension);
    snprintf(info->file, sizeof info->file, "%s.%s", info->name, extension);
    sheen_digest(info->payload_digest, payload, size_bytes);
    sheen_status st = path_in(payload_path, s, SHEEN_SESSION_FRAMES, info->file, "", err);
    if (!st)
        st = path_in(sidecar_path, s, SHEEN_SESSION_FRAMES, info->name, ".json", err);
    if (!st)
        st = sheen_file_write(payload_path, payload, size_bytes, err);
    if (st)
        return st;
    st = sheen_frame_info_save(info, sidecar_path, err);
    if (st)
        sheen_file_remove(payload_path, NULL);
    return st;
}

sheen_status sheen_session_enter_frame(sheen_session *s, const sheen_frame_info *info, sheen_err *err)
{
    const sheen_status st = reserve(s, err);
    if (st)
        return st;
    const size_t i = insert_at(s, info->name);
    memmove(s->frames + i + 1, s->frames + i, (s->n_frames - i) * sizeof *s->frames);
    s->frames[i] = *info;
    s->n_frames++;
    return SHEEN_OK;
}

sheen_status sheen_session_add_frame(sheen_session *s, sheen_frame_info *info, const char *extension,
                                     const void *payload, size_t size_bytes, sheen_err *err)
{
    if (sheen_session_find(s, info->name))
        return sheen_fail(err, SHEEN_EARG, "the session has a frame '%s' already", info->name);
    sheen_status st = reserve(s, err); // first: nothing can fail any more once the sidecar stands
    if (!st)
        st = sheen_session_write_frame(s, info, extension, payload, size_bytes, err);
    return st ? st : sheen_session_enter_frame(s, info, err);
}

sheen_status sheen_session_add_mask(const sheen_session *s, const char *folder, const char *name,
                                    const void *png, size_t size_bytes, sheen_err *err)
{
    char dir[SHEEN_PATH_MAX], path[SHEEN_PATH_MAX];
    sheen_status st = sheen_session_path(dir, s, folder, err);
    if (!st)
        st = sheen_dir_make(dir, err);
    if (!st)
        st = path_in(path, s, folder, name, ".png", err);
    return st ? st : sheen_file_write(path, png, size_bytes, err);
}

void sheen_session_next_name(const sheen_session *s, char name[64])
{
    size_t free_number = 0; // one past the highest number in use
    for (size_t i = 0; i < s->n_frames; i++) {
        char *end;
        const unsigned long number = strtoul(s->frames[i].name, &end, 10);
        if (!*end && strspn(s->frames[i].name, "0123456789") >= 6 && number >= free_number &&
            number < 100000000)
            free_number = number + 1;
    }
    snprintf(name, 64, "%06zu", free_number);
}

int sheen_frame_round(const sheen_frame_info *f)
{
    char *end;
    const long round = f->name[0] == 'r' ? strtol(f->name + 1, &end, 10) : 0;
    return round > 0 && round < 1000 && *end == '-' ? (int)round : 0;
}

size_t sheen_session_count_role(const sheen_session *s, sheen_role role)
{
    size_t n = 0;
    for (size_t i = 0; i < s->n_frames; i++)
        n += s->frames[i].role == role;
    return n;
}

sheen_status sheen_session_payload(uint8_t **data_out, size_t *size_bytes, const sheen_session *s,
                                   const sheen_frame_info *f, sheen_err *err)
{
    char path[SHEEN_PATH_MAX], digest[33];
    *data_out = NULL;
    sheen_status st = path_in(path, s, SHEEN_SESSION_FRAMES, f->file, "", err);
    if (!st)
        st = sheen_file_read(data_out, size_bytes, path, payload_max_bytes, err);
    if (st)
        return st;
    sheen_digest(digest, *data_out, *size_bytes);
    if (!strcmp(digest, f->payload_digest))
        return SHEEN_OK;
    free(*data_out);
    *data_out = NULL;
    return sheen_fail(err, SHEEN_EFORMAT,
                      "'%s' is not what was recorded (its digest differs): import it again from the original",
                      path);
}

static sheen_status fail_size(const sheen_frame_info *f, int width_px, int height_px, sheen_err *err)
{
    return sheen_fail(err, SHEEN_EFORMAT, "frame '%s' is %d x %d px, its description says %d x %d", f->name,
                      width_px, height_px, f->width_px, f->height_px);
}

sheen_status sheen_session_raster(sheen_raster *out, const sheen_session *s, const sheen_frame_info *f,
                                  sheen_err *err)
{
    *out = (sheen_raster){0};
    uint8_t *data;
    size_t size_bytes;
    sheen_status st = sheen_session_payload(&data, &size_bytes, s, f, err);
    if (st)
        return st;
    const sheen_pixel_layout layout = {f->fourcc, f->width_px, f->height_px, f->stride_bytes, f->color};
    st = sheen_payload_develop(out, data, size_bytes, &layout, err);
    free(data);
    if (st)
        return sheen_wrap(err, st, "cannot read frame '%s'", f->name);
    if (out->width_px != f->width_px || out->height_px != f->height_px) {
        st = fail_size(f, out->width_px, out->height_px, err);
        sheen_raster_release(out);
    }
    return st;
}

sheen_status sheen_session_grey(sheen_image *out, const sheen_session *s, const sheen_frame_info *f,
                                sheen_err *err)
{
    sheen_raster raster;
    sheen_status st = sheen_session_raster(&raster, s, f, err);
    if (st)
        return st;
    st = sheen_image_from_grey(out, &raster, f->transfer, err);
    sheen_raster_release(&raster);
    return st;
}

sheen_status sheen_session_image(sheen_image *out, const sheen_session *s, const sheen_frame_info *f,
                                 sheen_err *err)
{
    *out = (sheen_image){0};
    sheen_radiometry r;
    uint8_t *data = NULL;
    size_t size_bytes = 0;
    sheen_status st = sheen_radiometry_load(&r, s, f, err);
    if (st)
        return sheen_wrap(err, st, "cannot turn frame '%s' into light", f->name);
    st = sheen_session_payload(&data, &size_bytes, s, f, err);
    if (!st && (st = sheen_radiometry_develop(out, &r, f, data, size_bytes, err)))
        st = sheen_wrap(err, st, "cannot read frame '%s'", f->name);
    free(data);
    sheen_radiometry_release(&r);
    if (!st && (out->width_px != f->width_px || out->height_px != f->height_px)) {
        st = fail_size(f, out->width_px, out->height_px, err);
        sheen_image_release(out);
    }
    return st;
}

sheen_status sheen_session_mask(sheen_image *out, const sheen_session *s, const sheen_frame_info *f,
                                sheen_err *err)
{
    *out = (sheen_image){0};
    char path[SHEEN_PATH_MAX];
    uint8_t *data;
    size_t size_bytes;
    sheen_status st = path_in(path, s, SHEEN_SESSION_MASKS, f->name, ".png", err);
    if (st || !sheen_file_exists(path))
        return st;
    st = sheen_file_read(&data, &size_bytes, path, mask_max_bytes, err);
    if (st)
        return st;
    st = sheen_mask_parse(out, data, size_bytes, f->width_px, f->height_px, err);
    free(data);
    return st ? sheen_wrap(err, st, "cannot use the mask '%s'", path) : SHEEN_OK;
}

sheen_status sheen_mask_parse(sheen_image *out, const void *data, size_t size_bytes, int width_px,
                              int height_px, sheen_err *err)
{
    sheen_raster raster;
    sheen_image rgb = {0};
    *out = (sheen_image){0};
    sheen_status st = sheen_raster_parse(&raster, data, size_bytes, err);
    if (st)
        return st;
    if (raster.width_px != width_px || raster.height_px != height_px) {
        st = sheen_fail(err, SHEEN_EFORMAT, "it is %d x %d px and its frame %d x %d", raster.width_px,
                        raster.height_px, width_px, height_px);
        goto done;
    }
    // A share of coverage is no light: code values are taken as they are, whatever the picture claims.
    st = sheen_image_from_raster(&rgb, &raster, SHEEN_TRANSFER_LINEAR, err);
    if (!st)
        st = sheen_image_init(out, width_px, height_px, 1, err);
    if (st)
        goto done;
    const size_t n = (size_t)width_px * (size_t)height_px;
    for (size_t i = 0; i < n; i++)
        out->data[i] = rgb.data[3 * i];

done:
    sheen_image_release(&rgb);
    sheen_raster_release(&raster);
    return st;
}
