// SPDX-License-Identifier: Apache-2.0
// How differently two cameras see: differences that are known beforehand.
#include <math.h>

#include "calib/compare.h"
#include "support.h"

static void make(sheen_camera *camera, double f, double cx, double k1)
{
    sheen_err err;
    const double distortion[5] = {k1, 0.04, 0.001, -0.0005, 0};
    assert_ok(sheen_camera_opencv(camera, 800, 600, (const double[4]){f, f, cx, 301}, distortion, 5, &err),
              err);
}

static void the_same_camera_does_not_differ(void **state)
{
    (void)state;
    sheen_err err;
    sheen_camera a;
    sheen_camera_difference d;
    make(&a, 900, 395, -0.1);
    assert_ok(sheen_camera_compare(&d, &a, &a, 0.5, &err), err);
    assert_close(d.raw_max_px, 0, 1e-6);
    assert_close(d.turned_max_px, 0, 1e-6);
    assert_close(d.moved_max_px, 0, 1e-6);
}

// A moved principal point is nearly a rotation; a longer focal length is not, but is nearly a move.
static void alignment_absorbs_what_it_should(void **state)
{
    (void)state;
    sheen_err err;
    sheen_camera a, b;
    sheen_camera_difference d;
    make(&a, 900, 395, -0.1);
    make(&b, 900, 397, -0.1);
    assert_ok(sheen_camera_compare(&d, &a, &b, 0.5, &err), err);
    assert_close(d.raw_rms_px, 2, 1e-6);
    assert_true(d.turned_rms_px < 0.4);
    assert_true(d.turned_max_px >= d.turned_rms_px);

    make(&b, 909, 395, -0.1);
    assert_ok(sheen_camera_compare(&d, &a, &b, 0.5, &err), err);
    assert_true(d.raw_rms_px > 2);
    assert_true(d.turned_rms_px > 0.9 * d.raw_rms_px);
    assert_true(d.moved_rms_px < 0.3 * d.turned_rms_px);

    make(&b, 900, 395, -0.12); // another lens is neither
    assert_ok(sheen_camera_compare(&d, &a, &b, 0.5, &err), err);
    assert_true(d.moved_max_px > 0.5);
}

static void says_what_cannot_be_compared(void **state)
{
    (void)state;
    sheen_err err;
    sheen_camera a, b;
    sheen_camera_difference d;
    make(&a, 900, 395, -0.1);
    b = a;
    b.width_px = 640;
    assert_fails(sheen_camera_compare(&d, &a, &b, 0.5, &err), err, SHEEN_EARG, "800 x 600 and 640 x 600");
    assert_fails(sheen_camera_compare(&d, &a, &a, 0, &err), err, SHEEN_EARG, "distance");
    assert_fails(sheen_camera_compare(&d, &a, &a, (double)NAN, &err), err, SHEEN_EARG, "distance");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_camera_does_not_differ),
        cmocka_unit_test(alignment_absorbs_what_it_should),
        cmocka_unit_test(says_what_cannot_be_compared),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
