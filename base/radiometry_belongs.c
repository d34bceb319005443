// SPDX-License-Identifier: Apache-2.0
// radiometry_belongs.c - whether what was measured of a camera may be used for a frame: same camera, size, settings.
//
// A dark frame holds for exactly its settings. Vignetting depends on the lens alone. A curve depends on neither exposure
// nor gains, which stand before it, but on every control that bends it.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <linux/v4l2-controls.h>

#include "base/radiometry.h"

typedef struct control_name {
    uint32_t id;
    const char *name;
} control_name;

static const control_name lens[] = {{V4L2_CID_FOCUS_ABSOLUTE, "focus"},
                                    {V4L2_CID_ZOOM_ABSOLUTE, "zoom"},
                                    {V4L2_CID_IRIS_ABSOLUTE, "iris"},
                                    {0}};

// What acts before the curve.
static const control_name before_curve[] = {{V4L2_CID_EXPOSURE_ABSOLUTE, "exposure"},
                                            {V4L2_CID_EXPOSURE, "exposure in lines"},
                                            {V4L2_CID_GAIN, "gain"},
                                            {V4L2_CID_ANALOGUE_GAIN, "analogue gain"},
                                            {V4L2_CID_DIGITAL_GAIN, "digital gain"},
                                            {V4L2_CID_ISO_SENSITIVITY, "ISO"},
                                            {V4L2_CID_WHITE_BALANCE_TEMPERATURE, "white balance"},
                                            {V4L2_CID_RED_BALANCE, "red balance"},
                                            {V4L2_CID_BLUE_BALANCE, "blue balance"},
                                            {V4L2_CID_POWER_LINE_FREQUENCY, "mains frequency"},
                                            {V4L2_CID_VBLANK, "vertical blanking"},
                                            {V4L2_CID_HBLANK, "horizontal blanking"},
                                            {V4L2_CID_JPEG_COMPRESSION_QUALITY, "JPEG quality"},
                                            {0}};

static const char *name_in(const control_name *names, uint32_t id)
{
    for (; names->id; names++)
        if (names->id == id)
            return names->name;
    return NULL;
}

static bool counts(sheen_measure kind, uint32_t id)
{
    const bool of_lens = name_in(lens, id) != NULL;
    switch (kind) {
    case SHEEN_MEASURE_FLAT:
        return of_lens;
    case SHEEN_MEASURE_RESPONSE:
        return !of_lens && !name_in(before_curve, id);
    default:
        return true;
    }
}

static const sheen_frame_control *find(const sheen_frame_info *f, uint32_t id)
{
    for (int i = 0; i < f->n_controls; i++)
        if (f->controls[i].id == id)
            return &f->controls[i];
    return NULL;
}

static void name_control(char out[40], uint32_t id)
{
    const char *name = name_in(lens, id);
    name = name ? name : name_in(before_curve, id);
    if (name)
        snprintf(out, 40, "%s", name);
    else
        snprintf(out, 40, "setting 0x%08lx", (unsigned long)id);
}

// Every control of a that counts is in b with the same value.
static sheen_status compare_controls(sheen_measure kind, const sheen_frame_info *a, const sheen_frame_info *b,
                                     sheen_err *err)
{
    for (int i = 0; i < a->n_controls; i++) {
        const uint32_t id = a->controls[i].id;
        const sheen_frame_control *other = find(b, id);
        char name[40];
        if (!counts(kind, id) || (other && other->value == a->controls[i].value))
            continue;
        name_control(name, id);
        return other ? sheen_fail(err, SHEEN_EDATA, "its %s was %ld, the frame's is %ld", name,
                                  (long)a->controls[i].value, (long)other->value)
                     : sheen_fail(err, SHEEN_EDATA, "its %s is known, the frame's is not", name);
    }
    return SHEEN_OK;
}

// libcamera's word on exposure and gain, which it rounds.
static sheen_status compare_pipelines(sheen_measure kind, const sheen_frame_info *a,
                                      const sheen_frame_info *b, sheen_err *err)
{
    const double x[3] = {a->pipeline.exposure_us, a->pipeline.analogue_gain, a->pipeline.digital_gain};
    const double y[3] = {b->pipeline.exposure_us, b->pipeline.analogue_gain, b->pipeline.digital_gain};
    static const char *const names[3] = {"exposure", "analogue gain", "digital gain"};
    for (int i = 0; kind == SHEEN_MEASURE_DARK && i < 3; i++)
        if (fabs(x[i] - y[i]) > 0.01 * fmax(x[i], y[i]))
            return sheen_fail(err, SHEEN_EDATA, "its %s was %.6g, the frame's is %.6g", names[i], x[i], y[i]);
    return SHEEN_OK;
}

static sheen_status compare_sizes(sheen_measure kind, const sheen_frame_info *a, const sheen_frame_info *b,
                                  sheen_err *err)
{
    if (kind != SHEEN_MEASURE_RESPONSE && (a->width_px != b->width_px || a->height_px != b->height_px))
        return sheen_fail(err, SHEEN_EDATA, "it is %d x %d px, the frame %d x %d", a->width_px, a->height_px,
                          b->width_px, b->height_px);
    return SHEEN_OK;
}

static sheen_status compare_formats(const sheen_frame_info *a, const sheen_frame_info *b, sheen_err *err)
{
    if (a->fourcc != b->fourcc)
        return sheen_fail(err, SHEEN_EDATA, "it was taken in another pixel format");
    if (memcmp(&a->color, &b->color, sizeof a->color) != 0)
        return sheen_fail(err, SHEEN_EDATA, "its numbers stand for other colours (matrix or range differ)");
    return SHEEN_OK;
}

// As the camera names itself, without its place on the bus, which follows in brackets.
static int name_length(const sheen_frame_info *f)
{
    return (int)strcspn(f->device, "(");
}

sheen_status sheen_measure_belongs(sheen_measure kind, const sheen_frame_info *a, const sheen_frame_info *b,
                                   sheen_err *err)
{
    const int n = name_length(a);
    if (n != name_length(b) || strncmp(a->device, b->device, (size_t)n) != 0)
        return sheen_fail(err, SHEEN_EDATA, "it is of the camera '%.*s', the frame of '%.*s'", n, a->device,
                          name_length(b), b->device);
    sheen_status s = compare_sizes(kind, a, b, err);
    if (!s && !b->bracket.n_exposures) // else its numbers are light already
        s = compare_formats(a, b, err);
    if (!s)
        s = compare_controls(kind, a, b, err);
    return s ? s : compare_pipelines(kind, a, b, err);
}
