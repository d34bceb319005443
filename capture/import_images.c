// SPDX-License-Identifier: Apache-2.0
// import_images.c - picture files as frames: decoded to see that they are whole, copied byte for byte.
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/image_file.h"
#include "capture/import_job.h"

static const size_t image_max_bytes = (size_t)2 << 30;

static const char *const endings[] = {"png", "jpg", "jpeg", "tif", "tiff", "exr"};

// The ending in lower case where it is a picture's, else NULL.
static const char *picture_ending(const char *path)
{
    const char *ending = sheen_path_extension(path);
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (!strcasecmp(ending, endings[i]))
            return endings[i];
    return NULL;
}

sheen_status sheen_import_name(char name[64], const char *path, sheen_err *err)
{
    const char *base = sheen_path_base(path);
    const char *dot = strrchr(base, '.');
    const size_t n = dot && dot != base ? (size_t)(dot - base) : strlen(base);
    name[0] = 0;
    if (n < 64) {
        memcpy(name, base, n);
        name[n] = 0;
        for (char *c = name; *c; c++)
            if (!isalnum((unsigned char)*c) && !strchr("._-", *c))
                *c = '_';
        if (name[0] == '.')
            name[0] = '_';
    }
    return sheen_frame_name_ok(name)
               ? SHEEN_OK
               : sheen_fail(err, SHEEN_EARG, "'%s' has a name that is too long for a frame: rename it", path);
}

// What a name that is taken means: the same picture again, or a clash.
static sheen_status check_taken(import_job *job, const char *name, const char *path, const uint8_t *data,
                                size_t size_bytes, bool *present, sheen_err *err)
{
    char digest[33];
    const sheen_frame_info *f = sheen_session_find(job->session, name);
    if (!f)
        f = sheen_session_find(&job->staged, name);
    *present = f != NULL;
    if (!f)
        return SHEEN_OK;
    sheen_digest(digest, data, size_bytes);
    if (strcmp(digest, f->payload_digest) != 0)
        return sheen_fail(err, SHEEN_EARG,
                          "a frame '%s' with other content is in the session already: rename '%s'", name,
                          path);
    if (f->role != job->options->role)
        return sheen_fail(err, SHEEN_EARG, "'%s' is in the session already, as a frame of role '%s'", path,
                          sheen_role_name(f->role));
    if (job->options->set_transfer && f->transfer != job->options->transfer)
        return sheen_fail(err, SHEEN_EARG, "'%s' is in the session already, with transfer '%s'", path,
                          sheen_transfer_name(f->transfer));
    return SHEEN_OK;
}

static sheen_status describe(import_job *job, sheen_frame_info *f, const char *path, const uint8_t *data,
                             size_t size_bytes, sheen_err *err)
{
    sheen_raster raster;
    const sheen_status s = sheen_raster_parse(&raster, data, size_bytes, err);
    if (s)
        return sheen_wrap(err, s, "cannot import '%s'", path);
    f->role = job->options->role;
    f->width_px = raster.width_px;
    f->height_px = raster.height_px;
    f->transfer = raster.bits == 32            ? SHEEN_TRANSFER_LINEAR
                  : job->options->set_transfer ? job->options->transfer
                                               : SHEEN_TRANSFER_SRGB;
    snprintf(f->source, sizeof f->source, "%.255s", sheen_path_base(path));
    sheen_raster_release(&raster);
    return SHEEN_OK;
}

static sheen_status import_image(import_job *job, const char *path, sheen_err *err)
{
    const char *ending = picture_ending(path);
    if (!ending)
        return sheen_fail(err, SHEEN_EARG, "'%s' has no picture's ending: use PNG, JPEG, TIFF or EXR files",
                          path);
    sheen_frame_info f;
    uint8_t *data;
    size_t size_bytes;
    bool present = false;
    sheen_frame_info_init(&f);
    sheen_status s = sheen_import_name(f.name, path, err);
    if (!s)
        s = sheen_file_read(&data, &size_bytes, path, image_max_bytes, err);
    if (s)
        return s;
    s = check_taken(job, f.name, path, data, size_bytes, &present, err);
    if (!s && present)
        job->report->n_present++;
    if (!s && !present) {
        s = describe(job, &f, path, data, size_bytes, err);
        if (!s)
            s = sheen_session_add_frame(&job->staged, &f, ending, data, size_bytes, err);
        if (!s)
            job->report->n_frames++;
    }
    free(data);
    return s;
}

static sheen_status import_folder(import_job *job, const char *dir, sheen_err *err)
{
    sheen_names names;
    size_t n_pictures = 0;
    sheen_status s = sheen_dir_list(&names, dir, NULL, err);
    if (s)
        return s;
    for (size_t i = 0; !s && i < names.count; i++) {
        char path[SHEEN_PATH_MAX];
        if (!picture_ending(names.names[i]))
            continue;
        n_pictures++;
        s = sheen_progress_step(&job->options->progress, "pictures", (int)i, (int)names.count, err);
        if (!s)
            s = sheen_path_join(path, dir, names.names[i], err);
        if (!s)
            s = import_image(job, path, err);
    }
    sheen_names_release(&names);
    if (!s && !n_pictures)
        s = sheen_fail(err, SHEEN_EDATA, "no PNG, JPEG, TIFF or EXR files in '%s'", dir);
    return s;
}

sheen_status sheen_import_images(import_job *job, sheen_err *err)
{
    const sheen_import_options *o = job->options;
    sheen_status s = SHEEN_OK;
    for (size_t i = 0; !s && i < o->n_images; i++) {
        s = sheen_progress_step(&o->progress, "pictures", (int)i, (int)o->n_images, err);
        if (!s)
            s = sheen_dir_exists(o->images[i]) ? import_folder(job, o->images[i], err)
                                               : import_image(job, o->images[i], err);
    }
    return s || !o->n_images
               ? s
               : sheen_progress_step(&o->progress, "pictures", (int)o->n_images, (int)o->n_images, err);
}
