// SPDX-License-Identifier: Apache-2.0
// test_pixel_rays.c - interpolated directions through an image agree with the lens model's own.
#include "render/pixel_rays.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/vec.h"

// Compares in pixels: the interpolated direction is projected again. Returns the worst.
static double worst_px(const sheen_camera *cam, double *share_exact)
{
    sheen_err err = {0};
    const double rt_cam_obj[6] = {0.3, -0.4, 1.2, 0.1, 0.2, 0.5};
    sheen_Rt Rt_cam_obj;
    sheen_Rt_from_rt(&Rt_cam_obj, rt_cam_obj);
    sheen_pixel_rays rays;
    const int x0 = 13, y0 = 5, width = cam->width_px - 20, height = cam->height_px - 7;
    const int window_px[4] = {x0, y0, width, height};
    assert_ok(sheen_pixel_rays_init(&rays, cam, rt_cam_obj, window_px, 0, &err), err);
    double worst = 0;
    for (double y = y0 - 0.5; y <= y0 + height - 0.5; y += 3.25)
        for (double x = x0 - 0.5; x + 63 * 0.5 <= x0 + width - 0.5; x += 17.5) {
            float got[64][3], ref[64][3];
            sheen_pixel_rays_row(&rays, got[0], x, y, 0.5, 64);
            sheen_pixel_rays_row_ref(&rays, ref[0], x, y, 0.5, 64);
            for (int i = 0; i < 64; i += 7) {
                double v[3] = {(double)got[i][0], (double)got[i][1], (double)got[i][2]}, q[2];
                if (isnan(ref[i][0])) { // no ray comes through here
                    assert_true(isnan(got[i][0]));
                    continue;
                }
                assert_close(sheen_norm(v), 1, 1e-6);
                for (int k = 0; k < 3; k++)
                    assert_close(got[i][k], ref[i][k], SHEEN_PIXEL_RAYS_ERROR_PX / cam->intrinsics[0] + 1e-7);
                sheen_Rt_direction(v, &Rt_cam_obj, v);
                assert_ok(sheen_camera_project(cam, q, NULL, v, 1, &err), err);
                double v_ref[3] = {(double)ref[i][0], (double)ref[i][1], (double)ref[i][2]}, q_ref[2];
                sheen_Rt_direction(v_ref, &Rt_cam_obj, v_ref);
                assert_ok(sheen_camera_project(cam, q_ref, NULL, v_ref, 1, &err), err);
                worst = fmax(worst, hypot(q[0] - q_ref[0], q[1] - q_ref[1]));
            }
        }
    size_t n_exact = 0, n = 0;
    for (int row = 1; rays.smooth && row < rays.n_rows - 2; row++)
        for (int column = 1; column < rays.n_columns - 2; column++, n++)
            n_exact += !rays.smooth[row * rays.n_columns + column];
    *share_exact = n ? (double)n_exact / (double)n : 0;
    sheen_pixel_rays_release(&rays);
    return worst;
}

static void agrees_for(const sheen_camera *cam, double most_exact)
{
    double share_exact;
    const double worst = worst_px(cam, &share_exact);
    print_message("%s: worst %.2g px, %.1f %% of the cells through the model\n", cam->lensmodel, worst,
                  100 * share_exact);
    assert_true(worst < SHEEN_PIXEL_RAYS_ERROR_PX);
    assert_true(share_exact <= most_exact);
}

static void pinhole(void **state)
{
    (void)state;
    sheen_camera cam;
    test_camera(&cam, 640, 480, 750, 0);
    agrees_for(&cam, 0);
}

static void opencv(void **state)
{
    (void)state;
    sheen_camera cam;
    test_camera(&cam, 640, 480, 750, 1);
    agrees_for(&cam, 0.02);
}

static void other(sheen_camera *cam, const char *lensmodel, const double *intrinsics, int n)
{
    *cam = (sheen_camera){.n_intrinsics = n, .width_px = 640, .height_px = 480};
    snprintf(cam->lensmodel, sizeof cam->lensmodel, "%s", lensmodel);
    memcpy(cam->intrinsics, intrinsics, (size_t)n * sizeof *intrinsics);
    sheen_err err = {0};
    assert_ok(sheen_camera_check(cam, &err), err);
}

static void fisheye(void **state)
{
    (void)state;
    static const double intrinsics[] = {220, 220, 319, 241}; // 145 degrees across
    sheen_camera cam;
    other(&cam, "LENSMODEL_STEREOGRAPHIC", intrinsics, 4);
    agrees_for(&cam, 0.05);
}

// A spline's third derivative jumps between its patches, so the grid must be finer.
static void splined(void **state)
{
    (void)state;
    enum { NX = 16, NY = 12 };
    double intrinsics[4 + 2 * NX * NY] = {500, 500, 321, 238};
    uint64_t seed = 4;
    for (int i = 4; i < 4 + 2 * NX * NY; i++)
        intrinsics[i] = 0.003 * test_random_normal(&seed);
    sheen_camera cam;
    other(&cam, "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=16_Ny=12_fov_x_deg=85", intrinsics,
          4 + 2 * NX * NY);
    agrees_for(&cam, 0.05);
}

// A lens so bent that no ray comes through the corners: much goes through the model, and nothing is wrong.
static void strongly_bent(void **state)
{
    (void)state;
    static const double distortion[5] = {-0.3, 0.25, 0.01, -0.02, -0.1};
    static const double fxycxy[4] = {60, 60, 79, 61};
    sheen_camera cam;
    sheen_err err = {0};
    assert_ok(sheen_camera_opencv(&cam, 160, 120, fxycxy, distortion, 5, &err), err);
    agrees_for(&cam, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pinhole), cmocka_unit_test(opencv),        cmocka_unit_test(fisheye),
        cmocka_unit_test(splined), cmocka_unit_test(strongly_bent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
