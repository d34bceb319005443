// SPDX-License-Identifier: Apache-2.0
// test_bracket.c - exposures of a known scene under known noise; and a bracket from a camera into a session.
#include "capture/bracket.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "capture/exposure_merge.h"
#include "capture/v4l2_source.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

enum { W = 200, H = 100, N = 3 };
static const double noise[2] = {2e-6, 1e-4}, ratio[N] = {0.25, 1, 4};

// Light from a thousandth to 8 times the full scale of the middle exposure.
static double light_at(int x)
{
    return 0.001 * pow(8000, x / (W - 1.0));
}

static void expose(sheen_image *img, double factor, double gamma, uint64_t *seed)
{
    sheen_err err;
    assert_ok(sheen_image_init(img, W, H, 3, &err), err);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            for (int c = 0; c < 3; c++) {
                const double clean = fmin(1, light_at(x) * factor);
                const double v = clean + sqrt(noise[0] + noise[1] * clean) * test_random_normal(seed);
                img->data[3 * (y * W + x) + c] = (float)pow(fmin(1, fmax(0, v)), gamma);
            }
}

static void make(sheen_exposure e[N], double gamma)
{
    uint64_t seed = 7;
    for (int i = 0; i < N; i++) {
        e[i].exposure_s = 0.01 * ratio[i];
        for (int k = 0; k < 2; k++)
            expose(&e[i].pair[k], ratio[i], gamma, &seed);
    }
}

static void release(sheen_exposure e[N])
{
    for (int i = 0; i < N; i++)
        for (int k = 0; k < 2; k++)
            sheen_image_release(&e[i].pair[k]);
}

static void light_noise_and_saturation_are_found(void **state)
{
    (void)state;
    sheen_exposure e[N];
    sheen_image out;
    sheen_merge_report report;
    sheen_err err;
    make(e, 1);
    assert_ok(sheen_exposures_merge(&out, &report, e, N, 0.01, &err), err);
    assert_close(report.noise[1], noise[1], 0.1 * noise[1]);
    assert_close(report.noise[0], noise[0], 1e-6);
    assert_true(report.residual < 0.03);
    double dark_error = 0;
    size_t n_saturated = 0;
    for (int x = 0; x < W; x++) {
        const double want = light_at(x);
        for (int y = 0; y < H; y++) {
            const float *p = out.data + 4 * (y * W + x);
            n_saturated += p[3] == 0;
            if (want < 3.5) {
                assert_true(p[3] == 1);
                assert_close(p[0], want, 6 * sqrt(noise[0] + noise[1] * want) + 0.02 * want);
            }
            if (want > 4.3)
                assert_true(p[3] == 0 && p[0] > 3.8f);
            dark_error += x < 20 ? fabs((double)p[1] - want) / (20.0 * H) : 0;
        }
    }
    assert_close(report.saturated, (double)n_saturated / (W * H), 1e-9);
    // The longest exposure resolves the dark: a single middle one is off by 0.0011 on average.
    assert_true(dark_error < 0.0004);
    sheen_image_release(&out);
    assert_fails(sheen_exposures_merge(&out, &report, e, 1, 0.01, &err), err, SHEEN_EARG, "2 to 9");
    release(e);
}

static void a_wrong_curve_shows_in_the_residual(void **state)
{
    (void)state;
    sheen_exposure e[N];
    sheen_image out;
    sheen_merge_report report;
    sheen_err err;
    make(e, 0.8); // as if a curve had been undone that was not there
    assert_ok(sheen_exposures_merge(&out, &report, e, N, 0.01, &err), err);
    assert_true(report.residual > 0.05);
    sheen_image_release(&out);
    release(e);
}

// The fake camera's light is half of full scale at the lock's 30 ms; four times that is white.
static void a_camera_gives_a_bracket_as_one_frame(void **state)
{
    for (int lag = 0; lag <= 6; lag += 3) {
        char dir[TEST_PATH_MAX], name[16];
        fake_v4l2 f;
        sheen_session s;
        sheen_source *src;
        sheen_record_report report;
        sheen_image image;
        sheen_err err;
        const sheen_record_options o = {.count = 2, .bracket = 3};
        snprintf(name, sizeof name, "lag%d", lag);
        test_scratch_file(dir, *state, name);
        assert_ok(sheen_session_create(&s, dir, SHEEN_MOVING_CAMERA, &err), err);
        fake_v4l2_init(&f);
        f.faults.lag_frames = lag;
        assert_ok(sheen_v4l2_source_open(&src, &f.io, "/dev/video0", &err), err);
        assert_ok(sheen_record(&s, src, &o, &report, &err), err);
        sheen_source_close(&src);
        sheen_session_release(&s);
        assert_ok(sheen_session_open(&s, dir, &err), err); // from the disk
        assert_int_equal(s.n_frames, 2);
        for (size_t i = 0; i < 2; i++) {
            const sheen_frame_info *g = &s.frames[i];
            assert_true(strstr(g->file, ".exr") && g->transfer == SHEEN_TRANSFER_LINEAR && !g->fourcc);
            assert_int_equal(g->bracket.n_exposures, 3);
            for (int k = 0; k < 3; k++)
                assert_close(g->bracket.exposure_s[k], 0.03 * ratio[k], 1e-9);
            assert_true(g->bracket.residual < 0.5); // its first pixels hold the frame's number
            assert_ok(sheen_session_image(&image, &s, g, &err), err);
            assert_close(*sheen_image_at(&image, 20, 20), 0.5, 0.003);
            sheen_image_release(&image);
        }
        sheen_session_release(&s);
    }
}

static void a_recording_cannot_be_bracketed(void **state)
{
    char dir[TEST_PATH_MAX];
    sheen_session s;
    fake_v4l2 f;
    sheen_source *src;
    sheen_record_report report;
    sheen_err err;
    const sheen_record_options o = {.count = 1, .bracket = 3};
    test_scratch_file(dir, *state, "unlocked");
    assert_ok(sheen_session_create(&s, dir, SHEEN_MOVING_CAMERA, &err), err);
    fake_v4l2_init(&f);
    assert_ok(sheen_v4l2_source_open(&src, &f.io, "/dev/video0?lock=off", &err), err);
    assert_fails(sheen_record(&s, src, &o, &report, &err), err, SHEEN_EUNSUP, "lock");
    sheen_source_close(&src);
    sheen_session_release(&s);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_noise_and_saturation_are_found),
        cmocka_unit_test(a_wrong_curve_shows_in_the_residual),
        WITH_SCRATCH(a_camera_gives_a_bracket_as_one_frame),
        WITH_SCRATCH(a_recording_cannot_be_bracketed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
