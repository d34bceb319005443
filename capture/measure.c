// SPDX-License-Identifier: Apache-2.0
// measure.c - averages frames of nothing and of white; exposes a scene again and again for the curve.
#include "capture/measure.h"

#include <math.h>
#include <stdlib.h>

#include "capture/bracket.h"
#include "capture/ladder.h"
#include "capture/response_fit.h"

// The response's exposures: from a sixteenth of the lock's to four times it, a factor of 2 apart.
enum { N_RESPONSE = 7, SHORTEST = -4, MAX_POINTS = 40000 };
static const double dark_most = 0.12; // of full scale; black levels are about 0.06
static const double white_most = 0.98, white_least = 0.1, uneven_least = 0.2;

// The sum of a raster's samples over frames.
typedef struct sum_of_frames {
    float *sum;
    int width_px, height_px, n_channels, bits;
    int n_frames;
    sheen_frame_info taken; // the first one
} sum_of_frames;

static size_t n_samples(const sum_of_frames *t)
{
    return (size_t)t->width_px * (size_t)t->height_px * (size_t)t->n_channels;
}

static sheen_status add_codes(sum_of_frames *t, const sheen_raster *r, sheen_err *err)
{
    if (!t->sum) {
        t->width_px = r->width_px;
        t->height_px = r->height_px;
        t->n_channels = r->n_channels;
        t->bits = r->bits;
        t->sum = calloc(n_samples(t), sizeof *t->sum);
        if (!t->sum)
            return sheen_fail_memory(err, (double)n_samples(t) * sizeof *t->sum, "the mean of frames");
    }
    if (r->width_px != t->width_px || r->height_px != t->height_px || r->n_channels != t->n_channels ||
        r->bits != t->bits)
        return sheen_fail(err, SHEEN_EIO, "the camera's frames differ in size or kind");
    const uint8_t *in8 = r->data;
    const uint16_t *in16 = r->data;
    const float scale = r->bits == 8 ? 1.0f / 255 : 1.0f / 65535;
    for (size_t i = 0; i < n_samples(t); i++)
        t->sum[i] += scale * (float)(r->bits == 8 ? in8[i] : in16[i]);
    t->n_frames++;
    return SHEEN_OK;
}

// Adds the next frames of the camera, all under one lock.
static sheen_status add_frames(sum_of_frames *t, sheen_ladder *ladder, int n_frames, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < n_frames && !s; i++) {
        sheen_frame frame;
        sheen_raster codes;
        s = sheen_ladder_next(ladder, &frame, err);
        if (!s && frame.info.lock != SHEEN_LOCK_HELD)
            s = sheen_fail(
                err, SHEEN_EUNSUP,
                "a camera is measured under its lock only: use a camera, and leave 'lock=off' out");
        if (!s)
            s = sheen_frame_codes(&codes, &frame.info, frame.data, frame.size_bytes, err);
        if (s)
            return s;
        if (!t->n_frames)
            t->taken = frame.info;
        s = add_codes(t, &codes, err);
        sheen_raster_release(&codes);
        ladder->done++;
        if (!s)
            s = sheen_progress_step(&ladder->options->progress, "measuring", ladder->done, ladder->total,
                                    err);
    }
    return s;
}

static float mean_of(const sum_of_frames *t, size_t i)
{
    return t->sum[i] / (float)t->n_frames;
}

static sheen_status mean_codes(sheen_raster *out, const sum_of_frames *t, sheen_err *err)
{
    const sheen_status s = sheen_raster_init(out, t->width_px, t->height_px, t->n_channels, 16, err);
    uint16_t *to = out->data;
    for (size_t i = 0; !s && i < n_samples(t); i++)
        to[i] = (uint16_t)(fminf(1, mean_of(t, i)) * 65535 + 0.5f);
    return s;
}

static void measure_levels(double *level, double *deviation, const sum_of_frames *t)
{
    double sum = 0, squares = 0;
    const size_t n = n_samples(t);
    for (size_t i = 0; i < n; i++) {
        const double x = (double)mean_of(t, i);
        sum += x;
        squares += x * x;
    }
    *level = sum / (double)n;
    *deviation = sqrt(fmax(0, squares / (double)n - *level * *level));
}

// Hot: beyond six deviations, and a hundredth of full scale at least.
static sheen_status judge_dark(sheen_measure_report *report, const sum_of_frames *t, sheen_err *err)
{
    double deviation;
    measure_levels(&report->level, &deviation, t);
    for (size_t i = 0; i < n_samples(t); i++)
        report->n_hot += (double)mean_of(t, i) > report->level + fmax(0.01, 6 * deviation);
    return report->level <= dark_most
               ? SHEEN_OK
               : sheen_fail(
                     err, SHEEN_EDATA,
                     "this is no dark frame: its mean is %.0f %% of full scale; cover the lens so that "
                     "no light enters",
                     100 * report->level);
}

static sheen_status judge_flat(sheen_measure_report *report, const sum_of_frames *t, sheen_err *err)
{
    enum { N_BINS = 1000 };
    size_t counts[N_BINS] = {0}, below = 0, n_white = 0;
    double deviation;
    const size_t n = n_samples(t);
    int first = 0, last = N_BINS - 1;
    measure_levels(&report->level, &deviation, t);
    for (size_t i = 0; i < n; i++) {
        const double x = (double)mean_of(t, i);
        n_white += x >= white_most;
        counts[(int)fmin(x * N_BINS, N_BINS - 1)]++;
    }
    while (first < N_BINS - 1 && (below += counts[first]) < n / 100)
        first++;
    while (last > 0 && !counts[last])
        last--;
    report->darkest = (first + 0.5) / (last + 0.5);
    if (n_white > n / 1000)
        return sheen_fail(err, SHEEN_EDATA,
                          "%.1f %% of the flat field are saturated: less light, or a shorter exposure_ms",
                          100 * (double)n_white / (double)n);
    if (report->level < white_least)
        return sheen_fail(err, SHEEN_EDATA,
                          "the flat field is too dark, %.0f %% of full scale: more light, or a longer "
                          "exposure_ms",
                          100 * report->level);
    if (report->darkest < uneven_least)
        return sheen_fail(err, SHEEN_EDATA,
                          "this is no even white: parts of it have %.0f %% of the brightest code; fill the "
                          "picture with paper in even light",
                          100 * report->darkest);
    return SHEEN_OK;
}

static sheen_status store_field(const sheen_session *s, sheen_measure kind, const sum_of_frames *t,
                                sheen_err *err)
{
    sheen_raster codes;
    sheen_radiometry check;
    sheen_status st = mean_codes(&codes, t, err);
    if (!st)
        st = sheen_radiometry_store(s, kind, &t->taken, &codes, NULL, err);
    sheen_raster_release(&codes);
    if (st || kind == SHEEN_MEASURE_DARK)
        return st;
    st = sheen_radiometry_load(&check, s, &t->taken, err);
    if (!st)
        sheen_radiometry_release(&check);
    return st ? sheen_wrap(err, st, "it is stored, but something is missing") : SHEEN_OK;
}

static sheen_status measure_here(sheen_measure_report *report, const sheen_session *s, sheen_measure kind,
                                 int n_frames, sheen_ladder *ladder, sheen_err *err)
{
    sum_of_frames t = {0};
    sheen_status st = add_frames(&t, ladder, n_frames, err);
    if (!st)
        st = kind == SHEEN_MEASURE_DARK ? judge_dark(report, &t, err) : judge_flat(report, &t, err);
    if (!st)
        st = store_field(s, kind, &t, err);
    report->n_frames += t.n_frames;
    free(t.sum);
    return st;
}

sheen_status sheen_measure_field(sheen_measure_report *report, const sheen_session *s, sheen_source *src,
                                 sheen_measure kind, int n_frames, const sheen_record_options *o,
                                 sheen_err *err)
{
    sheen_ladder ladder = {.src = src, .options = o, .total = n_frames};
    *report = (sheen_measure_report){0};
    return measure_here(report, s, kind, n_frames, &ladder, err);
}

// Whatever became of it, the camera is left at the lock's exposure. The first failure's sentence is kept.
static sheen_status back_to_lock(sheen_source *src, sheen_status st, sheen_err *err)
{
    double exposure_s;
    sheen_err late;
    const sheen_status back = sheen_source_expose(src, 1, &exposure_s, &late);
    if (!st && back && err)
        *err = late;
    return st ? st : back;
}

sheen_status sheen_measure_bracket_dark(sheen_measure_report *report, const sheen_session *s,
                                        sheen_source *src, int n_exposures, int n_frames,
                                        const sheen_record_options *o, sheen_err *err)
{
    sheen_ladder ladder = {.src = src, .options = o, .total = n_frames * n_exposures};
    sheen_frame first;
    *report = (sheen_measure_report){.n_exposures = n_exposures};
    sheen_status st = sheen_ladder_next(&ladder, &first, err); // the lock is whole
    if (st)
        return st;
    for (int i = 0; i < n_exposures && !st; i++) {
        st = sheen_source_expose(src, sheen_bracket_factor(i, n_exposures), &report->exposure_s[i], err);
        if (!st)
            st = measure_here(report, s, SHEEN_MEASURE_DARK, n_frames, &ladder, err);
    }
    return back_to_lock(src, st, err);
}

// ---- response

typedef struct bracket_points {
    float *codes; // [N_RESPONSE][n_points]
    size_t n_points, stride;
    double exposure_s[N_RESPONSE];
    int n_exposures;
    sheen_frame_info taken;
} bracket_points;

// Every stride-th sample of the mean of two frames.
static sheen_status take_exposure(bracket_points *b, sheen_ladder *ladder, sheen_err *err)
{
    sum_of_frames t = {0};
    sheen_status st = add_frames(&t, ladder, 2, err);
    if (!st && t.taken.fourcc && sheen_pixels_is_mosaic(t.taken.fourcc))
        st = sheen_fail(err, SHEEN_EUNSUP,
                        "a mosaic's numbers are linear in light: there is no curve to measure");
    if (!st && !b->codes) {
        b->stride = 1 + n_samples(&t) / MAX_POINTS;
        b->n_points = n_samples(&t) / b->stride;
        b->codes = malloc(N_RESPONSE * b->n_points * sizeof *b->codes);
        b->taken = t.taken;
        if (!b->codes)
            st = sheen_fail_memory(err, (double)b->n_points * N_RESPONSE, "the points of a response");
    }
    for (size_t i = 0; !st && i < b->n_points; i++)
        b->codes[(size_t)b->n_exposures * b->n_points + i] = mean_of(&t, i * b->stride);
    free(t.sum);
    return st;
}

// Exposures that the camera cannot tell apart count once.
static sheen_status take_bracket(bracket_points *b, sheen_ladder *ladder, sheen_err *err)
{
    sheen_frame first;
    sheen_status st = sheen_ladder_next(ladder, &first, err); // the lock is whole
    for (int i = 0; i < N_RESPONSE && !st; i++) {
        double exposure_s;
        st = sheen_source_expose(ladder->src, pow(2, SHORTEST + i), &exposure_s, err);
        if (st || (b->n_exposures && exposure_s < 1.2 * b->exposure_s[b->n_exposures - 1]))
            continue;
        st = take_exposure(b, ladder, err);
        b->exposure_s[b->n_exposures++] = exposure_s;
    }
    return st;
}

static sheen_status store_response(const sheen_session *s, const bracket_points *b,
                                   const sheen_response_fit *fit, sheen_err *err)
{
    sheen_image light;
    sheen_frame_info taken = b->taken;
    taken.bracket = (sheen_frame_bracket){.n_exposures = b->n_exposures, .residual = fit->residual};
    for (int i = 0; i < b->n_exposures; i++)
        taken.bracket.exposure_s[i] = b->exposure_s[i];
    sheen_status st = sheen_image_init(&light, SHEEN_RESPONSE_CODES, 1, 1, err);
    for (int i = 0; !st && i < SHEEN_RESPONSE_CODES; i++)
        light.data[i] = fit->light[i];
    if (!st)
        st = sheen_radiometry_store(s, SHEEN_MEASURE_RESPONSE, &taken, NULL, &light, err);
    sheen_image_release(&light);
    return st;
}

sheen_status sheen_measure_response(sheen_measure_report *report, const sheen_session *s, sheen_source *src,
                                    const sheen_record_options *o, sheen_err *err)
{
    sheen_ladder ladder = {.src = src, .options = o, .total = 2 * N_RESPONSE};
    bracket_points b = {0};
    sheen_response_fit fit;
    *report = (sheen_measure_report){0};
    sheen_status st = back_to_lock(src, take_bracket(&b, &ladder, err), err);
    const sheen_response_data data = {b.codes, b.exposure_s, b.n_points, b.n_exposures};
    if (!st)
        st = sheen_response_solve(&fit, &data, b.taken.transfer, err);
    if (!st)
        st = store_response(s, &b, &fit, err);
    if (!st) {
        report->residual = fit.residual;
        report->residual_claimed = fit.residual_claimed;
        report->n_exposures = b.n_exposures;
        for (int i = 0; i < b.n_exposures; i++)
            report->exposure_s[i] = b.exposure_s[i];
    }
    free(b.codes);
    return st;
}
