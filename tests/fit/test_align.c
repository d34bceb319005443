// SPDX-License-Identifier: Apache-2.0
// test_align.c - poses and exposures come back from photographs that were given wrong ones.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/align.h"
#include "support.h"
#include "tests/fit/exact_scene.h"

static void align(exact_scene *s, sheen_align_result *r, const sheen_align_options *o)
{
    sheen_err err;
    sheen_scene *scene;
    assert_ok(sheen_scene_new(&scene, &s->mesh, &err), err);
    assert_ok(sheen_align_photos(r, &s->inputs, &s->mesh, scene, o, &err), err);
    sheen_scene_free(&scene);
}

static double rms_pose_error_px(const exact_scene *s)
{
    double sum = 0;
    for (size_t i = 0; i < s->inputs.count; i++)
        sum += pow(exact_pose_error_px(s, s->inputs.photos[i].rt_cam_obj, s->rt_cam_obj[i]), 2);
    return sqrt(sum / (double)s->inputs.count);
}

static double worst_gain_error_ev(const exact_scene *s, const sheen_align_result *r)
{
    double worst = 0;
    for (size_t i = 0; i < s->inputs.count; i++)
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs(log2(r->views[i].gain[c] / s->gain[i][c])));
    return worst;
}

static const sheen_align_options both = {.poses = 1, .gains = 1, .texels_per_edge = 3};

static void poses_come_back(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    sheen_align_result r;
    exact_scene_options(&o, "pose-1.5", 3);
    o.size = 0.5;
    exact_scene_make(&s, &o);
    const double before_px = rms_pose_error_px(&s);
    align(&s, &r, &both);
    const double after_px = rms_pose_error_px(&s);
    print_message("pose error %.2f px -> %.2f px (expected %.2f px); disagreement %.4f -> %.4f, %zu points\n",
                  before_px, after_px, r.views[0].sigma_px, r.error_before, r.error_after, r.n_points);
    assert_true(r.poses_kept && !r.gains_kept);
    assert_true(after_px < 0.4);
    for (size_t i = 0; i < r.n_views; i++)
        assert_true(r.views[i].gain[0] == 1);
    sheen_align_result_release(&r);
    exact_scene_release(&s);
}

static void exposures_come_back(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    sheen_align_result r;
    exact_scene_options(&o, "drift", 3);
    o.size = 0.5;
    exact_scene_make(&s, &o);
    align(&s, &r, &both);
    const double worst_ev = worst_gain_error_ev(&s, &r);
    print_message("exposures within %.4f EV; disagreement %.4f -> %.4f\n", worst_ev, r.error_before,
                  r.error_after);
    assert_true(r.gains_kept);
    assert_true(worst_ev < 0.03);
    sheen_image taken[8];
    sheen_err err;
    const size_t pixel = 3 * (240 * 640 + 320);
    const float *const lent = s.inputs.photos[2].image.data;
    assert_ok(sheen_align_divide(taken, &s.inputs, &r, &err), err);
    assert_close(s.inputs.photos[2].image.data[pixel] * (float)r.views[2].gain[0], lent[pixel], 1e-5);
    sheen_align_give_back(&s.inputs, taken);
    assert_ptr_equal(s.inputs.photos[2].image.data, lent);
    sheen_align_result_release(&r);
    exact_scene_release(&s);
}

// White balance that drifts while luminances hardly do.
static void white_balance_comes_back(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    sheen_align_result r;
    exact_scene_options(&o, "far", 4);
    o.size = 0.4;
    o.white_balance = 0.05;
    exact_scene_make(&s, &o);
    align(&s, &r, &both);
    const double worst_ev = worst_gain_error_ev(&s, &r);
    print_message("white balance within %.4f EV\n", worst_ev);
    assert_true(r.gains_kept);
    assert_true(worst_ev < 0.01);
    sheen_align_result_release(&r);
    exact_scene_release(&s);
}

// A metal has no paint to agree on: what it mirrors can be made to, by other poses and exposures.
static void right_ones_stay_on_a_metal(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        exact_options o;
        exact_scene s;
        sheen_align_result r;
        exact_scene_options(&o, "metal", seed);
        o.size = 0.33;
        exact_scene_make(&s, &o);
        align(&s, &r, &both);
        print_message("metal %d: poses off by %.2f px, exposures by %.3f EV\n", (int)seed,
                      rms_pose_error_px(&s), worst_gain_error_ev(&s, &r));
        assert_true(!r.gains_kept && !r.poses_kept);
        assert_true(rms_pose_error_px(&s) < 0.01);
        assert_true(worst_gain_error_ev(&s, &r) < 1e-6);
        sheen_align_result_release(&r);
        exact_scene_release(&s);
    }
}

// What is right is left as it is, to a small part of a pixel.
static void right_poses_stay(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    sheen_align_result r;
    exact_scene_options(&o, "far", 4);
    o.size = 0.4;
    exact_scene_make(&s, &o);
    align(&s, &r, &both);
    print_message("right poses moved to %.3f px\n", rms_pose_error_px(&s));
    assert_true(!r.gains_kept);
    assert_true(rms_pose_error_px(&s) < 0.15);
    sheen_align_result_release(&r);
    exact_scene_release(&s);
}

// Photographs can be made to agree on a surface that is wrong, by sliding over it: poses that were right must not follow.
static void right_poses_stay_on_a_wrong_mesh(void **state)
{
    (void)state;
    exact_options o;
    exact_scene s;
    sheen_align_result r;
    exact_scene_options(&o, "sigma-.1", 6);
    o.size = 0.4;
    exact_scene_make(&s, &o);
    float centre_obj[3], radius_m;
    sheen_mesh_sphere(&s.mesh, centre_obj, &radius_m);
    for (size_t i = 0; i < s.mesh.n_vertices; i++) { // waves that the object has not
        float *p = s.mesh.p_obj + 3 * i, wave = 0.3f;
        for (int k = 0; k < 3; k++)
            wave *= sinf(p[k] / (0.15f * radius_m));
        for (int k = 0; k < 3; k++)
            p[k] += wave * (p[k] - centre_obj[k]);
    }
    align(&s, &r, &both);
    print_message("disagreement %.4f -> %.4f, poses off by %.2f px\n", r.error_before, r.error_after,
                  rms_pose_error_px(&s));
    assert_true(!r.poses_kept);
    assert_true(rms_pose_error_px(&s) < 0.01);
    sheen_align_result_release(&r);
    exact_scene_release(&s);
}

static void threads_do_not_change_the_result(void **state)
{
    (void)state;
    exact_options o;
    exact_scene a, b;
    sheen_align_result ra, rb;
    exact_scene_options(&o, "pose", 5);
    o.size = 0.2;
    o.n_inputs = 4;
    exact_scene_make(&a, &o);
    exact_scene_make(&b, &o);
    sheen_align_options one = both, three = both;
    one.n_threads = 1;
    three.n_threads = 3;
    align(&a, &ra, &one);
    align(&b, &rb, &three);
    for (size_t i = 0; i < a.inputs.count; i++)
        assert_memory_equal(a.inputs.photos[i].rt_cam_obj, b.inputs.photos[i].rt_cam_obj, 6 * sizeof(double));
    sheen_align_result_release(&ra);
    sheen_align_result_release(&rb);
    exact_scene_release(&a);
    exact_scene_release(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_come_back),
        cmocka_unit_test(exposures_come_back),
        cmocka_unit_test(white_balance_comes_back),
        cmocka_unit_test(right_poses_stay),
        cmocka_unit_test(right_ones_stay_on_a_metal),
        cmocka_unit_test(right_poses_stay_on_a_wrong_mesh),
        cmocka_unit_test(threads_do_not_change_the_result),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
