// SPDX-License-Identifier: Apache-2.0
// session_stamp.c - stamps: the digests of what a result was made from, so that it can be told whether it is current.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json_write.h"
#include "base/radiometry.h"
#include "base/session_private.h"

enum { LINE_MAX_BYTES = 320 };

typedef sheen_status line_of(char line[LINE_MAX_BYTES], const sheen_session *s, const sheen_frame_info *f,
                             sheen_err *err);

// "-" where the frame has no mask in this folder.
static sheen_status mask_digest_of(char hex[33], const sheen_session *s, const char *folder,
                                   const sheen_frame_info *f, sheen_err *err)
{
    char file[160], path[SHEEN_PATH_MAX];
    snprintf(file, sizeof file, "%s/%s.png", folder, f->name);
    snprintf(hex, 33, "-");
    const sheen_status st = sheen_session_path(path, s, file, err);
    return st || !sheen_file_exists(path) ? st : sheen_file_digest(hex, path, err);
}

static sheen_status highlights_line(char line[LINE_MAX_BYTES], const sheen_session *s,
                                    const sheen_frame_info *f, sheen_err *err)
{
    char digest[33];
    const sheen_status st = mask_digest_of(digest, s, SHEEN_SESSION_HIGHLIGHTS, f, err);
    snprintf(line, LINE_MAX_BYTES, "%s %s\n", f->name, digest);
    return st;
}

// One line of text with everything about a frame that a stage's result may depend on, the picture and its mask by
// their digests (docs/session-format.md, "Stamps").
static sheen_status frame_line(char line[LINE_MAX_BYTES], const sheen_session *s, const sheen_frame_info *f,
                               sheen_err *err)
{
    char mask_digest[33], angle[40] = "-", color[48] = "";
    const sheen_status st = mask_digest_of(mask_digest, s, SHEEN_SESSION_MASKS, f, err);
    if (isfinite(f->table_measured_deg))
        snprintf(angle, sizeof angle, "%.17g", f->table_measured_deg);
    if (sheen_colorimetry_known(&f->color))
        snprintf(color, sizeof color, " %u.%u.%u.%u", (unsigned)f->color.colorspace,
                 (unsigned)f->color.xfer_func, (unsigned)f->color.ycbcr_enc, (unsigned)f->color.quantization);
    snprintf(line, LINE_MAX_BYTES, "%s %s %s %s %d %d %lu %d %s%s\n", f->name, f->payload_digest, mask_digest,
             sheen_transfer_name(f->transfer), f->width_px, f->height_px, (unsigned long)f->fourcc,
             f->stride_bytes, angle, color);
    return st;
}

// How their numbers become light; "" where the session has measured nothing of its camera.
static sheen_status radiometry_line(char line[LINE_MAX_BYTES], const sheen_session *s, sheen_err *err)
{
    char digest[33];
    const sheen_status st = sheen_radiometry_digest(digest, s, err);
    line[0] = 0;
    if (!st && digest[0])
        snprintf(line, LINE_MAX_BYTES, "radiometry %s\n", digest);
    return st;
}

// "" where the role has no frames.
static sheen_status digest_role(char hex[33], const sheen_session *s, sheen_role role, line_of *line,
                                sheen_err *err)
{
    const size_t n = sheen_session_count_role(s, role);
    sheen_status st = SHEEN_OK;
    hex[0] = 0;
    if (!n)
        return SHEEN_OK;
    const size_t room = (n + 1) * LINE_MAX_BYTES;
    char *text = malloc(room), *end = text;
    if (!text)
        return sheen_fail_memory(err, (double)room, "the digest of the frames");
    for (size_t i = 0; !st && i < s->n_frames; i++)
        if (s->frames[i].role == role) {
            st = line(end, s, &s->frames[i], err);
            end += strlen(end);
        }
    if (!st && line == frame_line) {
        st = radiometry_line(end, s, err);
        end += strlen(end);
    }
    if (!st)
        sheen_digest(hex, text, (size_t)(end - text));
    free(text);
    return st;
}

static sheen_status digest_input(char hex[33], const sheen_session *s, const char *file, sheen_err *err)
{
    static const char frames[] = "frames:", highlights[] = "highlights:";
    const bool is_frames = !strncmp(file, frames, sizeof frames - 1);
    if (is_frames || !strncmp(file, highlights, sizeof highlights - 1)) {
        sheen_role role;
        const sheen_status st = sheen_role_from_name(&role, strchr(file, ':') + 1, err);
        return st ? st : digest_role(hex, s, role, is_frames ? frame_line : highlights_line, err);
    }
    char path[SHEEN_PATH_MAX];
    hex[0] = 0;
    const sheen_status st = sheen_session_path(path, s, file, err);
    return st || !sheen_file_exists(path) ? st : sheen_file_digest(hex, path, err);
}

sheen_status sheen_stamp_write(sheen_json_writer *w, const sheen_session *s, const char *const *files,
                               sheen_err *err)
{
    sheen_status st = SHEEN_OK;
    sheen_json_open(w, "inputs", '{');
    for (; !st && *files; files++) {
        char hex[33];
        st = digest_input(hex, s, *files, err);
        if (!st)
            sheen_json_put_string(w, *files, hex);
    }
    sheen_json_close(w);
    return st;
}

static void count_member(void *self, const char *key, const sheen_json *value)
{
    (void)key;
    (void)value;
    ++*(size_t *)self;
}

bool sheen_stamp_is_current(const sheen_json *result, const sheen_session *s, const char *const *files)
{
    const sheen_json *inputs = sheen_json_get(result, "inputs");
    if (!sheen_json_is_object(inputs))
        return false;
    size_t n_stamped = 0, n = 0;
    for (; files[n]; n++) {
        char hex[33];
        const char *stamped = sheen_json_value_string(sheen_json_get(inputs, files[n]), NULL);
        if (!stamped || digest_input(hex, s, files[n], NULL) || strcmp(hex, stamped) != 0)
            return false;
    }
    sheen_json_each(inputs, count_member, &n_stamped);
    return n_stamped == n;
}
