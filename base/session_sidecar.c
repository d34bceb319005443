// SPDX-License-Identifier: Apache-2.0
// session_sidecar.c - a frame's description, frames/<name>.json, to and from memory.
#include <ctype.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/json_write.h"
#include "base/session_private.h"

enum { SIDECAR_VERSION = 1, NAME_MAX_BYTES = 60, EXTENSION_MAX_BYTES = 8 };

static const char *const role_names[SHEEN_ROLE_COUNT] = {
    [SHEEN_ROLE_INPUT] = "input",
    [SHEEN_ROLE_CALIBRATION] = "calibration",
    [SHEEN_ROLE_TEST] = "test",
    [SHEEN_ROLE_BACKGROUND] = "background",
};

const char *sheen_role_name(sheen_role r)
{
    return role_names[r];
}

sheen_status sheen_role_from_name(sheen_role *out, const char *name, sheen_err *err)
{
    for (int i = 0; i < SHEEN_ROLE_COUNT; i++)
        if (!strcmp(name, role_names[i])) {
            *out = (sheen_role)i;
            return SHEEN_OK;
        }
    return sheen_fail(err, SHEEN_EARG,
                      "unknown role '%.60s': use 'input', 'calibration', 'test' or 'background'", name);
}

void sheen_frame_info_init(sheen_frame_info *f)
{
    *f = (sheen_frame_info){0};
    f->t_ns = f->sequence = -1;
    f->table_asked_deg = f->table_measured_deg = (double)NAN;
}

bool sheen_frame_name_ok(const char *name)
{
    const size_t n = strlen(name);
    if (!n || n > NAME_MAX_BYTES || name[0] == '.')
        return false;
    for (const char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && !strchr("._-", *c))
            return false;
    return true;
}

bool sheen_frame_extension_ok(const char *extension)
{
    const size_t n = strlen(extension);
    if (!n || n > EXTENSION_MAX_BYTES || !strcmp(extension, "json"))
        return false;
    for (const char *c = extension; *c; c++)
        if (!islower((unsigned char)*c) && !isdigit((unsigned char)*c))
            return false;
    return true;
}

// V4L2's way to write a pixel format: four characters, "-BE" after them where bit 31 is set.
static void write_fourcc(sheen_json_writer *w, uint32_t fourcc)
{
    char text[8] = "";
    for (int i = 0; i < 4; i++) {
        const char c = (char)(fourcc >> (8 * i) & 0x7f);
        text[i] = isprint((unsigned char)c) ? c : '?';
    }
    if (fourcc >> 31)
        memcpy(text + 4, "-BE", 4);
    sheen_json_put_string(w, "fourcc", fourcc ? text : NULL);
}

static sheen_status parse_fourcc(uint32_t *out, const sheen_json *root, sheen_err *err)
{
    const sheen_json *v = sheen_json_get(root, "fourcc");
    *out = 0;
    if (!sheen_json_is_string(v))
        return SHEEN_OK;
    const char *text = sheen_json_value_string(v, "");
    const size_t n = strlen(text);
    if (n != 4 && (n != 7 || strcmp(text + 4, "-BE") != 0))
        return sheen_fail(err, SHEEN_EFORMAT, "'fourcc' is '%.20s', not four characters", text);
    for (int i = 0; i < 4; i++)
        *out |= ((uint32_t)(unsigned char)text[i] & 0x7f) << (8 * i);
    if (n == 7)
        *out |= UINT32_C(1) << 31;
    return SHEEN_OK;
}

static sheen_status parse_names(sheen_frame_info *f, const sheen_json *root, sheen_err *err)
{
    const char *file, *role, *transfer, *digest, *source;
    sheen_status s = sheen_json_string(root, "file", &file, err);
    if (!s)
        s = sheen_json_string(root, "role", &role, err);
    if (!s)
        s = sheen_json_string(root, "transfer", &transfer, err);
    if (!s)
        s = sheen_json_string(root, "payload_digest", &digest, err);
    if (!s)
        s = sheen_json_string(root, "source", &source, err);
    if (s)
        return s;
    if (strlen(file) >= sizeof f->file || strchr(file, '/') ||
        !sheen_frame_extension_ok(sheen_path_extension(file)))
        return sheen_fail(err, SHEEN_EFORMAT, "'%.80s' is no name for a payload file", file);
    if (strlen(digest) != 32 || strspn(digest, "0123456789abcdef") != 32)
        return sheen_fail(err, SHEEN_EFORMAT, "'payload_digest' is not 32 hexadecimal digits");
    snprintf(f->file, sizeof f->file, "%s", file);
    snprintf(f->payload_digest, sizeof f->payload_digest, "%s", digest);
    snprintf(f->source, sizeof f->source, "%s", source);
    if (sheen_role_from_name(&f->role, role, err) || sheen_transfer_from_name(&f->transfer, transfer, err))
        return err ? (err->code = SHEEN_EFORMAT) : SHEEN_EFORMAT;
    return SHEEN_OK;
}

static sheen_status parse_numbers(sheen_frame_info *f, const sheen_json *root, sheen_err *err)
{
    sheen_status s = sheen_json_int(root, "width_px", 1, SHEEN_IMAGE_MAX_SIDE_PX, &f->width_px, err);
    if (!s)
        s = sheen_json_int(root, "height_px", 1, SHEEN_IMAGE_MAX_SIDE_PX, &f->height_px, err);
    if (!s)
        s = sheen_json_int(root, "stride_bytes", 0, 16 * SHEEN_IMAGE_MAX_SIDE_PX, &f->stride_bytes, err);
    if (!s)
        s = sheen_json_int64(root, "t_ns", &f->t_ns, err);
    if (!s)
        s = sheen_json_int64(root, "sequence", &f->sequence, err);
    if (s)
        return s;
    f->table_asked_deg = sheen_json_value_number(sheen_json_get(root, "table_asked_deg"), (double)NAN);
    f->table_measured_deg = sheen_json_value_number(sheen_json_get(root, "table_measured_deg"), (double)NAN);
    return SHEEN_OK;
}

static const char *const lock_names[] = {NULL, "off", "held"};

static sheen_status parse_lock(sheen_frame_info *f, const sheen_json *root, sheen_err *err)
{
    const char *name = sheen_json_value_string(sheen_json_get(root, "lock"), NULL);
    for (int i = SHEEN_LOCK_OFF; name && i <= SHEEN_LOCK_HELD; i++)
        if (!strcmp(name, lock_names[i]))
            f->lock = (sheen_lock)i;
    return name && !f->lock ? sheen_fail(err, SHEEN_EFORMAT, "'lock' is '%.20s', not 'held' or 'off'", name)
                            : SHEEN_OK;
}

static sheen_status parse_color(sheen_colorimetry *c, const sheen_json *root, sheen_err *err)
{
    const struct {
        const char *key;
        uint32_t *value;
    } members[] = {{"colorspace", &c->colorspace},
                   {"xfer_func", &c->xfer_func},
                   {"ycbcr_enc", &c->ycbcr_enc},
                   {"quantization", &c->quantization}};
    const sheen_json *color = sheen_json_get(root, "color");
    for (size_t i = 0; color && i < sizeof members / sizeof *members; i++) {
        int value = 0;
        const sheen_status s = sheen_json_int(color, members[i].key, 0, 255, &value, err);
        if (s)
            return s;
        *members[i].value = (uint32_t)value;
    }
    return SHEEN_OK;
}

typedef struct member {
    const char *key;
    size_t at; // a double of sheen_frame_pipeline
} member;

static const member pipeline_members[] = {
    {"exposure_us", offsetof(sheen_frame_pipeline, exposure_us)},
    {"analogue_gain", offsetof(sheen_frame_pipeline, analogue_gain)},
    {"digital_gain", offsetof(sheen_frame_pipeline, digital_gain)},
    {"red_gain", offsetof(sheen_frame_pipeline, red_gain)},
    {"blue_gain", offsetof(sheen_frame_pipeline, blue_gain)},
};
enum { N_PIPELINE_MEMBERS = sizeof pipeline_members / sizeof *pipeline_members, N_BLACK_LEVELS = 4 };

static sheen_status parse_pipeline(sheen_frame_pipeline *p, const sheen_json *root, sheen_err *err)
{
    const sheen_json *pipeline = sheen_json_get(root, "pipeline");
    const sheen_json *levels = sheen_json_get(pipeline, "black_levels");
    bool good = true;
    for (size_t i = 0; pipeline && i < N_PIPELINE_MEMBERS; i++) {
        double *value = (double *)(void *)((char *)p + pipeline_members[i].at);
        *value = sheen_json_value_number(sheen_json_get(pipeline, pipeline_members[i].key), 0);
        good = good && *value >= 0;
    }
    for (size_t i = 0; levels && i < N_BLACK_LEVELS; i++) {
        p->black_levels[i] = sheen_json_value_number(sheen_json_at(levels, i), -1);
        good = good && p->black_levels[i] >= 0 && p->black_levels[i] <= 65535;
    }
    return good ? SHEEN_OK : sheen_fail(err, SHEEN_EFORMAT, "'pipeline' has a number that none can have");
}

static double member_of(const sheen_frame_pipeline *p, size_t i)
{
    return *(const double *)(const void *)((const char *)p + pipeline_members[i].at);
}

static void write_pipeline(sheen_json_writer *w, const sheen_frame_pipeline *p)
{
    bool said = false;
    for (size_t i = 0; i < N_PIPELINE_MEMBERS; i++)
        said = said || member_of(p, i) > 0;
    if (!said)
        return;
    sheen_json_open(w, "pipeline", '{');
    for (size_t i = 0; i < N_PIPELINE_MEMBERS; i++)
        sheen_json_put_number(w, pipeline_members[i].key, member_of(p, i));
    sheen_json_put_numbers(w, "black_levels", p->black_levels, N_BLACK_LEVELS);
    sheen_json_close(w);
}

// An array of [id, value] pairs.
static sheen_status parse_controls(sheen_frame_info *f, const sheen_json *root, sheen_err *err)
{
    const sheen_json *controls = sheen_json_get(root, "controls");
    const size_t n = sheen_json_count(controls);
    if (n > SHEEN_FRAME_MAX_CONTROLS)
        return sheen_fail(err, SHEEN_EFORMAT, "'controls' has %zu pairs, more than %d", n,
                          SHEEN_FRAME_MAX_CONTROLS);
    for (size_t i = 0; i < n; i++) {
        const sheen_json *pair = sheen_json_at(controls, i);
        const double id = sheen_json_value_number(sheen_json_at(pair, 0), -1);
        const double value = sheen_json_value_number(sheen_json_at(pair, 1), (double)NAN);
        if (!(id >= 0 && id <= UINT32_MAX && value >= INT32_MIN && value <= INT32_MAX) || floor(id) != id ||
            floor(value) != value)
            return sheen_fail(err, SHEEN_EFORMAT,
                              "'controls' are not pairs of a control's number and its value");
        f->controls[i] = (sheen_frame_control){(uint32_t)id, (int32_t)value};
    }
    f->n_controls = (int)n;
    return SHEEN_OK;
}

static sheen_status parse_bracket(sheen_frame_info *f, const sheen_json *root, sheen_err *err)
{
    const sheen_json *bracket = sheen_json_get(root, "bracket");
    const sheen_json *exposures = sheen_json_get(bracket, "exposure_s"),
                     *noise = sheen_json_get(bracket, "noise");
    const size_t n = sheen_json_count(exposures);
    if (!bracket)
        return SHEEN_OK;
    if (n < 2 || n > SHEEN_BRACKET_MAX || sheen_json_count(noise) != 2)
        return sheen_fail(err, SHEEN_EFORMAT, "'bracket' wants 2 to %d exposures and two numbers of noise",
                          SHEEN_BRACKET_MAX);
    for (size_t i = 0; i < n; i++) {
        f->bracket.exposure_s[i] = sheen_json_value_number(sheen_json_at(exposures, i), 0);
        if (!(f->bracket.exposure_s[i] > 0))
            return sheen_fail(err, SHEEN_EFORMAT, "'bracket' has an exposure that is no time");
    }
    for (size_t i = 0; i < 2; i++)
        f->bracket.noise[i] = sheen_json_value_number(sheen_json_at(noise, i), 0);
    f->bracket.residual = sheen_json_value_number(sheen_json_get(bracket, "residual"), (double)NAN);
    f->bracket.n_exposures = (int)n;
    return SHEEN_OK;
}

static sheen_status parse_camera(sheen_frame_info *f, const sheen_json *root, sheen_err *err)
{
    snprintf(f->device, sizeof f->device, "%s", sheen_json_value_string(sheen_json_get(root, "device"), ""));
    sheen_status s = parse_lock(f, root, err);
    if (!s)
        s = parse_color(&f->color, root, err);
    if (!s)
        s = parse_pipeline(&f->pipeline, root, err);
    if (!s)
        s = parse_controls(f, root, err);
    return s ? s : parse_bracket(f, root, err);
}

sheen_status sheen_frame_info_parse(sheen_frame_info *f, const void *data, size_t size_bytes, sheen_err *err)
{
    char name[sizeof f->name];
    memcpy(name, f->name, sizeof name);
    sheen_frame_info_init(f);
    memcpy(f->name, name, sizeof name);
    sheen_json *root = NULL;
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = sheen_json_schema(root, "sheen-frame", SIDECAR_VERSION, NULL, err);
    if (!s)
        s = parse_names(f, root, err);
    if (!s)
        s = parse_numbers(f, root, err);
    if (!s)
        s = parse_fourcc(&f->fourcc, root, err);
    if (!s)
        s = parse_camera(f, root, err);
    sheen_json_free(&root);
    return s;
}

static void write_bracket(sheen_json_writer *w, const sheen_frame_bracket *b)
{
    if (!b->n_exposures)
        return;
    sheen_json_open(w, "bracket", '{');
    sheen_json_put_numbers(w, "exposure_s", b->exposure_s, (size_t)b->n_exposures);
    sheen_json_put_numbers(w, "noise", b->noise, 2);
    sheen_json_put_number(w, "residual", b->residual);
    sheen_json_close(w);
}

// What only a camera's frame has.
static void write_camera(sheen_json_writer *w, const sheen_frame_info *f)
{
    if (f->device[0])
        sheen_json_put_string(w, "device", f->device);
    if (f->lock)
        sheen_json_put_string(w, "lock", lock_names[f->lock]);
    if (sheen_colorimetry_known(&f->color)) {
        sheen_json_open(w, "color", '{');
        sheen_json_put_int(w, "colorspace", f->color.colorspace);
        sheen_json_put_int(w, "xfer_func", f->color.xfer_func);
        sheen_json_put_int(w, "ycbcr_enc", f->color.ycbcr_enc);
        sheen_json_put_int(w, "quantization", f->color.quantization);
        sheen_json_close(w);
    }
    write_pipeline(w, &f->pipeline);
    if (!f->n_controls)
        return;
    sheen_json_open(w, "controls", '[');
    for (int i = 0; i < f->n_controls; i++) {
        const double pair[2] = {f->controls[i].id, f->controls[i].value};
        sheen_json_put_numbers(w, NULL, pair, 2);
    }
    sheen_json_close(w);
}

sheen_status sheen_frame_info_save(const sheen_frame_info *f, const char *path, sheen_err *err)
{
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-frame/1");
    sheen_json_put_string(&w, "file", f->file);
    sheen_json_put_string(&w, "role", sheen_role_name(f->role));
    sheen_json_put_int(&w, "width_px", f->width_px);
    sheen_json_put_int(&w, "height_px", f->height_px);
    write_fourcc(&w, f->fourcc);
    sheen_json_put_int(&w, "stride_bytes", f->stride_bytes);
    sheen_json_put_string(&w, "transfer", sheen_transfer_name(f->transfer));
    sheen_json_put_int(&w, "t_ns", f->t_ns);
    sheen_json_put_int(&w, "sequence", f->sequence);
    sheen_json_put_number(&w, "table_asked_deg", f->table_asked_deg);
    sheen_json_put_number(&w, "table_measured_deg", f->table_measured_deg);
    sheen_json_put_string(&w, "payload_digest", f->payload_digest);
    sheen_json_put_string(&w, "source", f->source);
    write_camera(&w, f);
    write_bracket(&w, &f->bracket);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}

void sheen_frame_taken_by(char out[160], const sheen_frame_info *f)
{
    enum { FOCUS_ABSOLUTE = 0x009a090a };      // V4L2's number of the control
    int length = (int)strcspn(f->device, "("); // the place follows in brackets
    while (length > 0 && f->device[length - 1] == ' ')
        length--;
    snprintf(out, 160, "%.*s", length, f->device);
    for (int i = 0; i < f->n_controls && out[0]; i++)
        if (f->controls[i].id == FOCUS_ABSOLUTE)
            snprintf(out, 160, "%.*s; focus %d", length, f->device, (int)f->controls[i].value);
    for (char *c = out; *c; c++) // it becomes a comment of one line
        if ((unsigned char)*c < ' ')
            *c = ' ';
}
