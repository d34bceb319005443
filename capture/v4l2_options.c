// SPDX-License-Identifier: Apache-2.0
// v4l2_options.c - reads the options of a camera's URI.
#include "capture/v4l2_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <linux/videodev2.h>

static sheen_status wrong(sheen_err *err, const char *key, const char *value, const char *wanted)
{
    return sheen_fail(err, SHEEN_EARG, "'%.40s=%.40s' is not understood: %.20s wants %s", key, value, key,
                      wanted);
}

static bool parse_number(double *out, const char *text, double min, double max)
{
    char *end;
    *out = strtod(text, &end);
    return end != text && !*end && isfinite(*out) && *out >= min && *out <= max;
}

static bool parse_size(sheen_v4l2_options *o, const char *text)
{
    char *end;
    const long w = strtol(text, &end, 10);
    if (end == text || *end != 'x')
        return false;
    const char *second = end + 1;
    const long h = strtol(second, &end, 10);
    if (end == second || *end || w < 1 || h < 1 || w > SHEEN_IMAGE_MAX_SIDE_PX || h > SHEEN_IMAGE_MAX_SIDE_PX)
        return false;
    o->width_px = (int)w;
    o->height_px = (int)h;
    return true;
}

static bool parse_fourcc(sheen_v4l2_options *o, const char *text)
{
    const size_t n = strlen(text);
    if (n < 3 || n > 4)
        return false;
    for (size_t i = 0; i < 4; i++) // "Y16" is "Y16 "
        o->fourcc |= (uint32_t)(unsigned char)(i < n ? text[i] : ' ') << (8 * i);
    return true;
}

// "1,2,4", in milliseconds.
static bool parse_exposures(sheen_v4l2_exposures *e, const char *text)
{
    for (e->n_only = 0; e->n_only < SHEEN_V4L2_MAX_EXPOSURES;) {
        char *end;
        const double ms = strtod(text, &end);
        if (end == text || !(ms >= 0.01 && ms <= 60000))
            return false;
        e->only_s[e->n_only++] = ms / 1000;
        if (*end != ',')
            return !*end;
        text = end + 1;
    }
    return false;
}

typedef struct word {
    const char *text;
    uint32_t value;
} word;

static const word matrices[] = {
    {"601", V4L2_YCBCR_ENC_601}, {"709", V4L2_YCBCR_ENC_709}, {"2020", V4L2_YCBCR_ENC_BT2020}, {0}};
static const word colorspaces[] = {{"srgb", V4L2_COLORSPACE_SRGB},
                                   {"rec709", V4L2_COLORSPACE_REC709},
                                   {"smpte170m", V4L2_COLORSPACE_SMPTE170M},
                                   {"jpeg", V4L2_COLORSPACE_JPEG},
                                   {"raw", V4L2_COLORSPACE_RAW},
                                   {0}};
static const word ranges[] = {
    {"full", V4L2_QUANTIZATION_FULL_RANGE}, {"limited", V4L2_QUANTIZATION_LIM_RANGE}, {0}};

static bool parse_word(uint32_t *out, const word *words, const char *text)
{
    for (; words->text; words++)
        if (!strcmp(words->text, text)) {
            *out = words->value;
            return true;
        }
    return false;
}

static sheen_status set(sheen_v4l2_options *o, const char *key, const char *value, sheen_err *err)
{
    double x = 0;
    if (!strcmp(key, "format"))
        return parse_fourcc(o, value) ? SHEEN_OK
                                      : wrong(err, key, value, "V4L2's four letters, such as MJPG");
    if (!strcmp(key, "size"))
        return parse_size(o, value) ? SHEEN_OK : wrong(err, key, value, "a size such as 1280x720");
    if (!strcmp(key, "rate"))
        return parse_number(&o->rate_hz, value, 0.1, 1000) ? SHEEN_OK
                                                           : wrong(err, key, value, "frames a second");
    if (!strcmp(key, "exposure_ms")) {
        if (!parse_number(&x, value, 0.01, 60000))
            return wrong(err, key, value, "milliseconds");
        o->exposure_s = x / 1000;
        return SHEEN_OK;
    }
    if (!strcmp(key, "exposure_most_ms")) {
        if (!parse_number(&x, value, 0.01, 60000))
            return wrong(err, key, value, "milliseconds");
        o->exposures.most_s = x / 1000;
        return SHEEN_OK;
    }
    if (!strcmp(key, "exposures_ms"))
        return parse_exposures(&o->exposures, value)
                   ? SHEEN_OK
                   : wrong(err, key, value, "milliseconds with commas between, 16 at most");
    if (!strcmp(key, "mains")) {
        const bool fine = parse_number(&x, value, 0, 60) && (x == 0 || x == 50 || x == 60);
        o->mains_hz = (int)x;
        return fine ? SHEEN_OK : wrong(err, key, value, "50 or 60 Hz, or 0 for lamps that do not flicker");
    }
    if (!strcmp(key, "lock")) {
        o->lock = strcmp(value, "off") != 0;
        return !o->lock || !strcmp(value, "on") ? SHEEN_OK : wrong(err, key, value, "on or off");
    }
    if (!strcmp(key, "transfer")) {
        o->set_transfer = true;
        return sheen_transfer_from_name(&o->transfer, value, err);
    }
    if (!strcmp(key, "colorspace"))
        return parse_word(&o->colorspace, colorspaces, value)
                   ? SHEEN_OK
                   : wrong(err, key, value, "srgb, rec709, smpte170m, jpeg or raw");
    if (!strcmp(key, "matrix"))
        return parse_word(&o->ycbcr_enc, matrices, value) ? SHEEN_OK
                                                          : wrong(err, key, value, "601, 709 or 2020");
    if (!strcmp(key, "range"))
        return parse_word(&o->quantization, ranges, value) ? SHEEN_OK
                                                           : wrong(err, key, value, "full or limited");
    return sheen_fail(err, SHEEN_EARG,
                      "unknown option '%.40s': a camera's are format, size, rate, exposure_ms, mains, lock, "
                      "colorspace, transfer, matrix, range, exposure_most_ms, exposures_ms",
                      key);
}

static sheen_status parse_query(sheen_v4l2_options *o, const char *query, sheen_err *err)
{
    while (*query) {
        char text[128];
        const size_t n = strcspn(query, "&");
        if (n >= sizeof text)
            return sheen_fail(err, SHEEN_EARG, "the option '%.40s' is too long", query);
        memcpy(text, query, n);
        text[n] = 0;
        query += n + (query[n] == '&');
        char *value = strchr(text, '=');
        if (!value || !value[1])
            return sheen_fail(err, SHEEN_EARG, "the option '%.40s' has no value", text);
        *value++ = 0;
        const sheen_status s = set(o, text, value, err);
        if (s)
            return s;
    }
    return SHEEN_OK;
}

sheen_status sheen_v4l2_options_parse(sheen_v4l2_options *o, const char *rest, sheen_err *err)
{
    const size_t n = strcspn(rest, "?");
    *o = (sheen_v4l2_options){.lock = true, .mains_hz = 50};
    if (!n || n >= sizeof o->path)
        return sheen_fail(err, SHEEN_EARG,
                          n ? "its path is too long" : "it names no camera: write v4l2:/dev/videoN");
    memcpy(o->path, rest, n);
    o->path[n] = 0;
    return rest[n] ? parse_query(o, rest + n + 1, err) : SHEEN_OK;
}

void sheen_v4l2_options_color(sheen_colorimetry *claim, const sheen_v4l2_options *o)
{
    if (o->colorspace) // its own defaults then hold for what is not said
        *claim = (sheen_colorimetry){.colorspace = o->colorspace};
    if (o->ycbcr_enc) // the person knows better than the driver
        claim->ycbcr_enc = o->ycbcr_enc;
    if (o->quantization)
        claim->quantization = o->quantization;
}
