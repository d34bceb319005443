// SPDX-License-Identifier: Apache-2.0
// test_sample.c - every stage on the sample session, against its truth: what a newcomer's `make demo` does.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/calibrate_session.h"
#include "fit/evaluate_session.h"
#include "fit/fit_session.h"
#include "pose/pose_session.h"
#include "support.h"

#define SAMPLE SHEEN_TEST_DATA "/penguin"
#define TRUTH SHEEN_TEST_DATA "/penguin-truth/scene.json"

static void copy_dir(const char *to, const char *from)
{
    sheen_err err;
    sheen_names names;
    assert_ok(sheen_dir_make(to, &err), err);
    assert_ok(sheen_dir_list(&names, from, NULL, &err), err);
    for (size_t i = 0; i < names.count; i++) {
        char a[SHEEN_PATH_MAX], b[SHEEN_PATH_MAX];
        assert_ok(sheen_path_join(a, from, names.names[i], &err), err);
        assert_ok(sheen_path_join(b, to, names.names[i], &err), err);
        if (sheen_dir_exists(a))
            copy_dir(b, a);
        else
            assert_ok(sheen_file_copy(b, a, &err), err);
    }
    sheen_names_release(&names);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Within 0.1 mm and 0.03 degrees of the truth, in the median.
static void check_poses(const sheen_session *s)
{
    sheen_err err;
    sheen_json *root;
    sheen_poses poses;
    double distance_mm[64], angle_deg[64];
    size_t n = 0;
    assert_ok(sheen_json_load(&root, TRUTH, &err), err);
    assert_ok(sheen_poses_load(&poses, s, &err), err);
    const sheen_json *views = sheen_json_get(root, "views");
    for (size_t i = 0; i < sheen_json_count(views); i++) {
        const char *name;
        sheen_Rt Rt;
        double rt[6];
        assert_ok(sheen_json_string(sheen_json_at(views, i), "name", &name, &err), err);
        assert_ok(sheen_json_numbers(sheen_json_at(views, i), "R", &Rt.R[0][0], 9, &err), err);
        assert_ok(sheen_json_numbers(sheen_json_at(views, i), "t", Rt.t, 3, &err), err);
        sheen_rt_from_Rt(rt, &Rt);
        const sheen_frame_pose *p = sheen_poses_find(&poses, name);
        assert_non_null(p);
        assert_true(p->found);
        double d[3];
        sheen_sub(d, p->rt_cam_board + 3, Rt.t);
        distance_mm[n] = 1000 * sheen_norm(d);
        angle_deg[n++] = sheen_rt_angle_rad(p->rt_cam_board, rt) * 180 / 3.14159265358979;
    }
    assert_int_equal(n, 12);
    qsort(distance_mm, n, sizeof *distance_mm, compare);
    qsort(angle_deg, n, sizeof *angle_deg, compare);
    print_message("poses: %.3f mm, %.4f degrees (median), %.3f mm, %.4f degrees (worst)\n",
                  distance_mm[n / 2], angle_deg[n / 2], distance_mm[n - 1], angle_deg[n - 1]);
    assert_true(distance_mm[n / 2] < 0.1 && angle_deg[n / 2] < 0.03);
    sheen_poses_release(&poses);
    sheen_json_free(&root);
}

// Better than every baseline by so much on highlight pixels and on the whole object.
static void check_scores(const sheen_session *s, double highlights_db, double object_db)
{
    sheen_err err;
    sheen_evaluation e;
    const sheen_evaluate_session_options o = {0};
    assert_false(sheen_evaluation_is_current(s));
    assert_ok(sheen_evaluate_session(&e, s, &o, &err), err);
    assert_true(sheen_evaluation_is_current(s));
    assert_int_equal(e.n_views, 4);
    assert_true(e.highlights_known);
    const sheen_score ours = sheen_evaluation_mean(&e, 0);
    for (int m = 0; m < SHEEN_EVALUATION_METHODS; m++) {
        const sheen_score other = sheen_evaluation_mean(&e, m);
        print_message("%-12s object %.2f dB sRGB, highlights %.2f dB linear\n",
                      sheen_evaluation_method_name(m), other.object.srgb_db, other.highlights.linear_db);
        if (m)
            assert_true(ours.highlights.linear_db > other.highlights.linear_db + highlights_db);
        if (m)
            assert_true(ours.object.srgb_db > other.object.srgb_db + object_db);
    }
    sheen_evaluation_release(&e);
}

static float board_luminance(const sheen_surroundings *e, double x_m, double y_m)
{
    float rgb[3];
    assert_true(sheen_image_bilinear(rgb, &e->board, (x_m - e->board_x0_m) / e->board_pitch_m,
                                     (y_m - e->board_y0_m) / e->board_pitch_m));
    return sheen_luminance(rgb);
}

// The saved model has the board's picture where the board is: the black square at its upper left corner, and the white rim
// round the tag beside it. Plastic reflects a few per cent.
static void check_surroundings(const sheen_session *s)
{
    sheen_err err;
    sheen_model m;
    assert_ok(sheen_model_load(&m, s, &err), err);
    assert_true(m.surroundings.present && m.shadows);
    assert_string_equal(m.method, "refined");
    assert_true(board_luminance(&m.surroundings, -0.123, 0.12) >
                5 * board_luminance(&m.surroundings, -0.165, 0.12));
    assert_true(m.surroundings.f0 > 0.005 && m.surroundings.f0 < 0.08);
    sheen_model_release(&m);
}

static void from_frames_to_scores(void **state)
{
    char path[TEST_PATH_MAX];
    sheen_err err;
    sheen_session s;
    sheen_calibration c;
    sheen_fit_summary f;
    test_scratch_file(path, *state, "penguin.session");
    copy_dir(path, SAMPLE);
    assert_ok(sheen_session_open(&s, path, &err), err);

    const sheen_calibrate_options co = {0};
    assert_ok(sheen_calibrate_session(&c, &s, &co, &err), err);
    sheen_calibration_release(&c);
    const sheen_pose_options po = {0};
    sheen_pose_summary poses;
    assert_ok(sheen_pose_session(&poses, NULL, &s, &po, &err), err);
    check_poses(&s);

    assert_false(sheen_fit_is_current(&s));
    const sheen_paper_options fo = {0};
    assert_ok(sheen_fit_session(&f, &s, SHEEN_FIT_PAPER, &fo, &err), err);
    print_message("sigma %.4f rad, k_S %.2f, %zu nodes kept, %zu lit, %zu turns\n", f.sigma_rad, f.k_s,
                  f.n_assigned, f.n_left, f.n_turns);
    assert_true(f.converged);
    assert_true(sheen_fit_is_current(&s));
    sheen_fit_summary_release(&f);
    check_scores(&s, 5, 0.8);

    assert_ok(sheen_fit_session(&f, &s, SHEEN_FIT_REFINED, &fo, &err), err);
    assert_true(sheen_fit_is_current(&s));
    sheen_fit_summary_release(&f);
    check_surroundings(&s);
    check_scores(&s, 12, 8);
    sheen_session_release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(from_frames_to_scores, test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
