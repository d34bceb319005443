// SPDX-License-Identifier: Apache-2.0
// test_measure.c - a camera with a black level, a hot pixel, a lens that darkens and a curve of its own: what is measured
// of it, and what its frames are worth by that.
#include "capture/measure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include <linux/videodev2.h>

#include "capture/response_fit.h"
#include "capture/v4l2_source.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

enum { W = 64, H = 24, WIDE = 640 };
static const sheen_record_options patient = {0};

typedef struct station {
    fake_v4l2 camera;
    sheen_session session;
    sheen_source *src;
} station;

static void begin(station *t, void **state)
{
    char dir[TEST_PATH_MAX];
    sheen_err err;
    *t = (station){0};
    test_scratch_file(dir, *state, "s");
    assert_ok(sheen_session_create(&t->session, dir, SHEEN_MOVING_CAMERA, &err), err);
    fake_v4l2_init(&t->camera);
    t->camera.width_px = W;
    t->camera.height_px = H;
    t->camera.stride_bytes = 3 * W;
    t->camera.color.xfer_func = 5; // none: linear
}

static void open_source(station *t, const char *options)
{
    char rest[200];
    bool followed;
    sheen_err err;
    snprintf(rest, sizeof rest, "/dev/video0%s", options);
    assert_ok(sheen_v4l2_source_open(&t->src, &t->camera.io, rest, &err), err);
    if (t->session.n_frames)
        assert_ok(sheen_source_follow(t->src, &t->session.frames[t->session.n_frames - 1],
                                      t->camera.faults.covered, &followed, &err),
                  err);
}

static void record(station *t, const char *options, int bracket)
{
    sheen_record_report report;
    sheen_err err;
    const sheen_record_options o = {.count = 1, .bracket = bracket};
    open_source(t, options);
    assert_ok(sheen_record(&t->session, t->src, &o, &report, &err), err);
    sheen_source_close(&t->src);
}

static sheen_status measure(station *t, const char *options, sheen_measure kind, sheen_measure_report *r,
                            sheen_err *err)
{
    open_source(t, options);
    const sheen_status s = kind == SHEEN_MEASURE_RESPONSE
                               ? sheen_measure_response(r, &t->session, t->src, &patient, err)
                               : sheen_measure_field(r, &t->session, t->src, kind, 8, &patient, err);
    sheen_source_close(&t->src);
    return s;
}

static double channel_at(const station *t, size_t i_frame, int x, int y, int channel)
{
    sheen_image img;
    sheen_err err;
    assert_ok(sheen_session_image(&img, &t->session, &t->session.frames[i_frame], &err), err);
    const double light = (double)sheen_image_at(&img, x, y)[channel];
    sheen_image_release(&img);
    return light;
}

static double light_at(const station *t, size_t i_frame, int x, int y)
{
    return channel_at(t, i_frame, x, y, 1);
}

static void end(station *t)
{
    assert_true(fake_v4l2_is_clean(&t->camera));
    fake_v4l2_release(&t->camera);
    sheen_session_release(&t->session);
}

// The light is half of full scale at the left edge and 0.3 of it at the right one.
static void dark_and_flat_give_the_light_back(void **state)
{
    station t;
    sheen_measure_report r;
    sheen_err err;
    char before[33], after[33];
    begin(&t, state);
    t.camera.faults.black = 16;
    t.camera.faults.vignette = 0.4;
    record(&t, "?exposure_ms=30", 0);
    assert_close(light_at(&t, 0, 0, 10), (16 + 0.5 * 239) / 255, 0.003);
    assert_ok(sheen_radiometry_digest(before, &t.session, &err), err);
    assert_string_equal(before, "");

    t.camera.faults.covered = true;
    assert_ok(measure(&t, "", SHEEN_MEASURE_DARK, &r, &err), err);
    assert_close(r.level, 16.0 / 255, 0.001);
    assert_true(r.n_hot >= 3 && r.n_hot <= 6); // of one pixel, and where the frames' number is
    t.camera.faults.covered = false;
    assert_close(light_at(&t, 0, 5, 10), 0.5 * (1 - 0.4 * 5 / 63), 0.003);
    assert_close(light_at(&t, 0, 5, 5), 0.5 * (1 - 0.4 * 5 / 63), 0.01); // hot, and known to be
    assert_close(light_at(&t, 0, W - 1, 10), 0.3, 0.003);

    assert_ok(measure(&t, "", SHEEN_MEASURE_FLAT, &r, &err), err);
    assert_true(r.darkest > 0.3 && r.darkest < 0.7); // the hot pixel is the brightest
    for (int x = 3; x < W; x += 10)
        assert_close(light_at(&t, 0, x, 12), 0.5, 0.005);
    assert_ok(sheen_radiometry_digest(after, &t.session, &err), err);
    assert_true(strcmp(before, after) != 0);
    // Another session takes them over.
    sheen_session other;
    char dir[TEST_PATH_MAX];
    test_scratch_file(dir, *state, "other");
    assert_ok(sheen_session_create(&other, dir, SHEEN_MOVING_CAMERA, &err), err);
    assert_ok(sheen_radiometry_copy(&other, &t.session, &err), err);
    assert_ok(sheen_radiometry_digest(before, &other, &err), err);
    assert_string_equal(before, after);
    sheen_session_release(&other);
    // Measured again they replace one another.
    t.camera.faults.covered = true;
    assert_ok(measure(&t, "", SHEEN_MEASURE_DARK, &r, &err), err);
    t.camera.faults.covered = false;
    assert_close(light_at(&t, 0, W - 1, 10), 0.5, 0.005);
    end(&t);
}

// Of a mosaic the dark frame goes off before anything is interpolated: a hot blue pixel does not spread.
static void a_mosaic_is_mended_before_it_is_interpolated(void **state)
{
    station t;
    sheen_measure_report r;
    sheen_err err;
    begin(&t, state);
    t.camera.fourcc = V4L2_PIX_FMT_SRGGB8;
    t.camera.width_px = WIDE; // the frame's number in the first pixels is then less than a thousandth of them
    t.camera.stride_bytes = WIDE;
    t.camera.faults.black = 16;
    t.camera.faults.vignette = 0.4;
    record(&t, "?exposure_ms=30", 0);
    const double sunk = (16 + 239 * 0.5 * (1 - 0.4 * 6 / (WIDE - 1))) / 255;
    assert_close(channel_at(&t, 0, 20, 10, 0), (16 + 239 * 0.5 * (1 - 0.4 * 20 / (WIDE - 1))) / 255, 0.004);
    assert_true(channel_at(&t, 0, 6, 6, 2) > sunk + 0.05); // a quarter of the hot neighbour's 100
    t.camera.faults.covered = true;
    assert_ok(measure(&t, "", SHEEN_MEASURE_DARK, &r, &err), err);
    assert_close(r.level, 16.0 / 255, 0.003);
    t.camera.faults.covered = false;
    for (int c = 0; c < 3; c++) {
        assert_close(channel_at(&t, 0, 20, 10, c), 0.5 * (1 - 0.4 * 20 / (WIDE - 1)), 0.004);
        assert_close(channel_at(&t, 0, 5, 5, c), 0.5 * (1 - 0.4 * 5 / (WIDE - 1)), 0.01);
        assert_close(channel_at(&t, 0, 6, 6, c), 0.5 * (1 - 0.4 * 6 / (WIDE - 1)), 0.01);
    }
    assert_ok(measure(&t, "", SHEEN_MEASURE_FLAT, &r, &err), err);
    for (int x = 10; x < WIDE; x += 90)
        for (int c = 0; c < 3; c++)
            assert_close(channel_at(&t, 0, x, 12, c), 0.5, 0.005);
    end(&t);
}

static void they_are_refused_for_frames_of_others(void **state)
{
    station t;
    sheen_measure_report r;
    sheen_image img;
    sheen_err err;
    begin(&t, state);
    t.camera.faults.black = 16;
    record(&t, "?exposure_ms=30", 0);
    assert_fails(measure(&t, "", SHEEN_MEASURE_DARK, &r, &err), err, SHEEN_EDATA, "cover the lens");
    t.camera.faults.covered = true;
    assert_ok(measure(&t, "", SHEEN_MEASURE_DARK, &r, &err), err);
    assert_fails(measure(&t, "", SHEEN_MEASURE_FLAT, &r, &err), err, SHEEN_EDATA, "too dark");
    t.camera.faults.covered = false;
    record(&t, "?exposure_ms=20", 0);
    assert_fails(sheen_session_image(&img, &t.session, &t.session.frames[1], &err), err, SHEEN_EDATA,
                 "exposure was 300, the frame's is 200");
    assert_ok(sheen_session_image(&img, &t.session, &t.session.frames[0], &err), err);
    sheen_image_release(&img);
    // A dark frame for each exposure.
    t.camera.faults.covered = true;
    assert_ok(measure(&t, "", SHEEN_MEASURE_DARK, &r, &err), err);
    t.camera.faults.covered = false;
    assert_close(light_at(&t, 1, 20, 10), 0.5 * 20 / 30, 0.004);
    assert_close(light_at(&t, 0, 20, 10), 0.5, 0.004);
    // Of another camera, another size.
    sheen_frame_info other = t.session.frames[0];
    snprintf(other.device, sizeof other.device, "Another (usb-1)");
    sheen_radiometry none;
    assert_fails(sheen_radiometry_load(&none, &t.session, &other, &err), err, SHEEN_EDATA, "Another");
    other = t.session.frames[0];
    other.width_px = 2 * W;
    assert_fails(sheen_radiometry_load(&none, &t.session, &other, &err), err, SHEEN_EDATA, "px");
    end(&t);
}

static void saturated_and_uneven_fields_are_refused(void **state)
{
    station t;
    sheen_measure_report r;
    sheen_err err;
    begin(&t, state);
    assert_fails(measure(&t, "?exposure_ms=80", SHEEN_MEASURE_FLAT, &r, &err), err, SHEEN_EDATA, "saturated");
    t.camera.faults.vignette = 0.9;
    assert_fails(measure(&t, "?exposure_ms=40", SHEEN_MEASURE_FLAT, &r, &err), err, SHEEN_EDATA,
                 "no even white");
    t.camera.faults.vignette = 0;
    assert_fails(measure(&t, "?exposure_ms=30&lock=off", SHEEN_MEASURE_FLAT, &r, &err), err, SHEEN_EUNSUP,
                 "lock");
    end(&t);
}

static void a_bracket_takes_its_dark_frames(void **state)
{
    station t;
    sheen_measure_report r;
    sheen_record_report report;
    sheen_err err;
    const sheen_record_options o = {.count = 1, .bracket = 3};
    begin(&t, state);
    t.camera.faults.black = 16;
    record(&t, "?exposure_ms=30", 0);
    t.camera.faults.covered = true;
    assert_ok(measure(&t, "", SHEEN_MEASURE_DARK, &r, &err), err);
    open_source(&t, "");
    assert_fails(sheen_record(&t.session, t.src, &o, &report, &err), err, SHEEN_EDATA, "exposure was 300");
    sheen_source_close(&t.src);
    open_source(&t, "");
    assert_ok(sheen_measure_bracket_dark(&r, &t.session, t.src, 3, 4, &patient, &err), err);
    sheen_source_close(&t.src);
    assert_int_equal(r.n_frames, 12);
    t.camera.faults.covered = false;
    record(&t, "", 3);
    assert_close(light_at(&t, 1, 20, 10), 0.5, 0.004);
    assert_close(light_at(&t, 1, 5, 5), 0.5, 0.02);
    end(&t);
}

static void a_curve_is_measured_and_used(void **state)
{
    static const double gammas[] = {1, 1.8, 2.4};
    for (int i = 0; i < 3; i++) {
        station t;
        sheen_measure_report r;
        sheen_err err;
        char name[16];
        begin(&t, state);
        snprintf(name, sizeof name, "g%d", i);
        sheen_session_release(&t.session);
        char dir[TEST_PATH_MAX];
        test_scratch_file(dir, *state, name);
        assert_ok(sheen_session_create(&t.session, dir, SHEEN_MOVING_CAMERA, &err), err);
        t.camera.faults.gamma = gammas[i];
        t.camera.color.xfer_func = 2; // claims sRGB
        t.camera.faults.ramp = true;
        t.camera.width_px = WIDE;
        t.camera.stride_bytes = 3 * WIDE;
        assert_ok(measure(&t, "?exposure_ms=20", SHEEN_MEASURE_RESPONSE, &r, &err), err);
        assert_true(r.residual < 0.02);
        assert_true(r.residual < r.residual_claimed);
        record(&t, "?exposure_ms=20", 0);
        for (int x = 80; x < WIDE; x += 60) {
            const double light = 2 * (double)x / (WIDE - 1) * 200 / 600;
            assert_close(light_at(&t, 0, x, 10), light, 0.02 * light + 0.004);
        }
        end(&t);
    }
}

static void a_flat_scene_has_no_curve(void **state)
{
    station t;
    sheen_measure_report r;
    sheen_err err;
    begin(&t, state);
    assert_fails(measure(&t, "?exposure_ms=20", SHEEN_MEASURE_RESPONSE, &r, &err), err, SHEEN_EDATA,
                 "too few degrees of brightness");
    end(&t);
}

// Points of all lights at exposures a factor of two apart, with noise; a step in the light makes a bad residual.
static void the_solver_finds_a_curve_under_noise(void **state)
{
    (void)state;
    enum { POINTS = 20000, EXPOSURES = 6 };
    static float codes[EXPOSURES * POINTS];
    double exposure_s[EXPOSURES];
    sheen_response_fit fit;
    sheen_err err;
    for (int changed = 0; changed < 2; changed++) {
        uint64_t seed = 3;
        for (int i = 0; i < EXPOSURES; i++) {
            exposure_s[i] = 0.002 * pow(2, i);
            seed += 17;
            for (int p = 0; p < POINTS; p++) {
                const double light = 4 * pow(0.001, (double)p / POINTS) * pow(2, i - 2) *
                                     (changed && i > 2 ? 1.2 : 1);
                const double z = pow(fmin(1, light), 1 / 2.0) + 0.008 * test_random_normal(&seed);
                codes[i * POINTS + p] = (float)(floor(fmin(1, fmax(0, z)) * 255 + 0.5) / 255);
            }
        }
        const sheen_response_data data = {codes, exposure_s, POINTS, EXPOSURES};
        assert_ok(sheen_response_solve(&fit, &data, SHEEN_TRANSFER_SRGB, &err), err);
        if (changed) {
            assert_true(fit.residual > 0.03);
            continue;
        }
        assert_true(fit.residual < 0.015);
        for (int k = 100; k < SHEEN_RESPONSE_CODES; k += 50) {
            const double z = k / (SHEEN_RESPONSE_CODES - 1.0);
            assert_close(fit.light[k], z * z, 0.03 * z * z + 0.002);
        }
    }
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(dark_and_flat_give_the_light_back),
        WITH_SCRATCH(a_mosaic_is_mended_before_it_is_interpolated),
        WITH_SCRATCH(they_are_refused_for_frames_of_others),
        WITH_SCRATCH(saturated_and_uneven_fields_are_refused),
        WITH_SCRATCH(a_bracket_takes_its_dark_frames),
        WITH_SCRATCH(a_curve_is_measured_and_used),
        WITH_SCRATCH(a_flat_scene_has_no_curve),
        cmocka_unit_test(the_solver_finds_a_curve_under_noise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
