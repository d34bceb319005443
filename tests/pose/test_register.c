// SPDX-License-Identifier: Apache-2.0
// Registration: from masks whatever the unit, honest about what turns alike, from marks, and what it must refuse.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "mask_scene.h"
#include "pose/register_points.h"
#include "support.h"
#include "support_board.h"

static const double DEG = 3.14159265358979323846 / 180;
static const double rt_board_obj[6] = {1.2, 0.9, 0.8, 0.05, -0.03, 0.02};

typedef struct fixture {
    mask_scene scene;
    sheen_mesh mesh, moved; // on the board; as its file has it, in millimetres
    double rt[6];
} fixture;

// 8 small masks; the file's y is up, its unit millimetres.
static void make(fixture *f, void (*shape)(sheen_mesh *))
{
    shape(&f->mesh);
    mask_scene_make(&f->scene, &f->mesh,
                    &(mask_scene_options){
                        .width_px = 400, .height_px = 300, .n_views = 6, .distance_m = 0.42, .seed = 5});
    sheen_rt_compose(f->rt, (const double[6]){0, 0, 2.1, 0.04, 0.02, 0},
                     (const double[6]){90 * DEG, 0, 0, 0.01, 0.03, 0.02});
    mask_scene_move(&f->moved, &f->mesh, f->rt, 1e-3);
}

static void release(fixture *f)
{
    mask_scene_release(&f->scene);
    sheen_mesh_release(&f->mesh);
    sheen_mesh_release(&f->moved);
}

static void finds_place_unit_and_up(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_registration r;
    double m, rad;
    make(&f, mask_scene_figure);
    const sheen_register_options o = {.ups = SHEEN_UP_Y | SHEEN_UP_Z};
    assert_ok(sheen_register_search(&r, &f.moved, &f.scene.camera, f.scene.views, f.scene.n_views, &o, &err),
              err);
    mask_scene_error(&m, &rad, &r.placement, f.rt, 1e-3, &f.mesh);
    assert_int_equal(r.state, SHEEN_REGISTER_SURE);
    assert_close(m, 0, 1e-4);
    assert_close(rad, 0, 0.1 * DEG);
    assert_close(r.unit_m, 1e-3, 0);
    assert_string_equal(sheen_up_name(r.up), "y");
    assert_string_equal(sheen_unit_name(r.unit_m), "mm");
    assert_close(r.height_m, 0, 1e-4);

    // the wrong unit is a sentence
    const sheen_register_options metres = {.ups = SHEEN_UP_Y, .unit_m = 1};
    sheen_err why = {0};
    const sheen_status s = sheen_register_search(&r, &f.moved, &f.scene.camera, f.scene.views,
                                                 f.scene.n_views, &metres, &why);
    assert_true(s == SHEEN_EDATA || r.state == SHEEN_REGISTER_POOR);
    release(&f);
}

static void says_that_a_bottle_turns_alike(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_registration r;
    make(&f, mask_scene_bottle);
    const sheen_register_options o = {.ups = SHEEN_UP_Y, .unit_m = 1e-3};
    assert_ok(sheen_register_search(&r, &f.moved, &f.scene.camera, f.scene.views, f.scene.n_views, &o, &err),
              err);
    assert_int_equal(r.state, SHEEN_REGISTER_AMBIGUOUS);
    assert_non_null(strstr(r.reason, "ambiguous"));
    release(&f);
}

static void refuses_what_does_not_fit(void **state)
{
    (void)state;
    sheen_err err;
    fixture f;
    sheen_registration r;
    sheen_mesh bottle;
    make(&f, mask_scene_figure);
    mask_scene_bottle(&bottle); // another object
    const sheen_register_options o = {.ups = SHEEN_UP_Z};
    assert_ok(sheen_register_search(&r, &bottle, &f.scene.camera, f.scene.views, f.scene.n_views, &o, &err),
              err);
    assert_int_equal(r.state, SHEEN_REGISTER_POOR);
    assert_non_null(strstr(r.reason, "does not fit"));
    sheen_mesh_release(&bottle);
    const sheen_mesh empty = {0};
    assert_fails(sheen_register_search(&r, &empty, &f.scene.camera, f.scene.views, f.scene.n_views, &o, &err),
                 err, SHEEN_EARG, "no triangles");
    for (size_t v = 0; v < f.scene.n_views; v++)
        memset(f.scene.masks[v].data, 0, 400 * 300 * sizeof(float));
    assert_fails(
        sheen_register_search(&r, &f.mesh, &f.scene.camera, f.scene.views, f.scene.n_views, &o, &err), err,
        SHEEN_EDATA, "no mask shows the object");
    release(&f);
}

static void follows_image_edges_where_masks_are_rough(void **state)
{
    (void)state;
    sheen_err err;
    sheen_mesh mesh;
    mask_scene scene;
    sheen_registration rough, fine;
    double m_rough, m_fine, rad;
    mask_scene_figure(&mesh);
    mask_scene_make(&scene, &mesh,
                    &(mask_scene_options){.width_px = 400,
                                          .height_px = 300,
                                          .n_views = 6,
                                          .distance_m = 0.42,
                                          .mask_noise_px = 1.5,
                                          .with_pictures = 1,
                                          .seed = 5});
    const double rt[6] = {0};
    sheen_placement start = {.scale = 1};
    sheen_Rt_from_rt(&start.Rt_board_obj, (const double[6]){0, 0, 0.03, 0.001, 0.001, 0});
    sheen_register_options o = {.unit_m = 1};
    assert_ok(
        sheen_register_refine(&rough, &mesh, &scene.camera, scene.views, scene.n_views, &start, &o, &err),
        err);
    mask_scene_error(&m_rough, &rad, &rough.placement, rt, 1, &mesh);
    o.edges = true;
    assert_ok(
        sheen_register_refine(&fine, &mesh, &scene.camera, scene.views, scene.n_views, &start, &o, &err),
        err);
    mask_scene_error(&m_fine, &rad, &fine.placement, rt, 1, &mesh);
    print_message("rough masks: %.3f mm; with edges %.3f mm, %.3f deg\n", 1e3 * m_rough, 1e3 * m_fine,
                  rad / DEG);
    assert_close(m_fine, 0, 1e-4);
    assert_close(rad, 0, 0.1 * DEG);
    assert_true(m_fine < m_rough);
    mask_scene_release(&scene);
    sheen_mesh_release(&mesh);
}

// The worst vertex' error against what is said of it: masks that wander, and masks that are a pixel too wide.
static void is_as_good_as_it_says(void **state)
{
    (void)state;
    enum { SCENES = 4 };
    sheen_err err;
    sheen_mesh mesh;
    const double rt[6] = {0};
    const sheen_register_options o = {.unit_m = 1};
    mask_scene_block(&mesh);
    for (int wide = 0; wide < 2; wide++) {
        double error2 = 0, said2 = 0, rad;
        int n_unsure = 0;
        for (uint64_t seed = 1; seed <= SCENES; seed++) {
            mask_scene scene;
            sheen_registration r;
            uint64_t spoil_seed = seed;
            double m;
            mask_scene_make(&scene, &mesh,
                            &(mask_scene_options){.width_px = 400,
                                                  .height_px = 300,
                                                  .n_views = 6,
                                                  .distance_m = 0.42,
                                                  .pose_noise = 1,
                                                  .mask_noise_px = wide ? 0.3 : 0.6,
                                                  .seed = seed});
            if (wide)
                mask_scene_spoil(&scene, MASK_SCENE_WIDER, &spoil_seed);
            sheen_placement start = {.scale = 1};
            sheen_Rt_from_rt(&start.Rt_board_obj, (const double[6]){0, 0, 0.01, 0.0005, 0.0005, 0});
            assert_ok(
                sheen_register_refine(&r, &mesh, &scene.camera, scene.views, scene.n_views, &start, &o, &err),
                err);
            mask_scene_error(&m, &rad, &r.placement, rt, 1, &mesh);
            if (wide) { // one frame hardly tells how far away it is
                sheen_registration alone;
                assert_ok(
                    sheen_register_refine(&alone, &mesh, &scene.camera, scene.views, 1, &start, &o, &err),
                    err);
                n_unsure += alone.state == SHEEN_REGISTER_AMBIGUOUS &&
                            strstr(alone.reason, " only: ") != NULL;
                assert_true(alone.sigma_m > 3 * r.sigma_m);
                assert_int_equal(r.state, SHEEN_REGISTER_SURE);
            }
            error2 += m * m;
            said2 += r.sigma_m * r.sigma_m;
            assert_close(r.misfit.offset_px, wide ? 1.1 : 0, 0.25);
            mask_scene_release(&scene);
        }
        assert_true(!wide || n_unsure > SCENES / 2);
        print_message("%s masks: %.3f mm rms, said %.3f\n", wide ? "wide" : "wandering",
                      1e3 * sqrt(error2 / SCENES), 1e3 * sqrt(said2 / SCENES));
        assert_true(error2 / said2 > 0.5 * 0.5 && error2 / said2 < 1.7 * 1.7);
        assert_true(error2 / SCENES < 0.6e-3 * 0.6e-3);
    }
    sheen_mesh_release(&mesh);
}

enum { MARKS = 14 };

// Marks of 7 points in two frames each.
static void marks_make(sheen_register_point *marks, sheen_poses *poses, const sheen_camera *camera,
                       double noise_px)
{
    uint64_t seed = 3;
    *poses = (sheen_poses){.poses = calloc(3, sizeof *poses->poses), .n_poses = 3};
    assert_non_null(poses->poses);
    for (int v = 0; v < 3; v++) {
        poses->poses[v] = (sheen_frame_pose){.found = v < 2};
        poses->poses[v].name[0] = (char)('a' + v);
        test_board_look(poses->poses[v].rt_cam_board, (const double[2]){0, 0}, 0.4, 45, 30 + 100 * v, 5);
    }
    for (int i = 0; i < MARKS; i++) {
        double p[3];
        if (i % 2 == 0)
            for (int k = 0; k < 3; k++)
                marks[i].p_obj[k] = 80 * (test_random(&seed) - 0.5); // millimetres
        else
            memcpy(marks[i].p_obj, marks[i - 1].p_obj, sizeof p);
        sheen_Rt Rt;
        for (int k = 0; k < 3; k++)
            p[k] = 1e-3 * marks[i].p_obj[k];
        sheen_Rt_from_rt(&Rt, rt_board_obj);
        sheen_Rt_point(p, &Rt, p);
        strcpy(marks[i].frame, i % 2 ? "b" : "a");
        test_board_project(marks[i].q_px, camera, poses->poses[i % 2].rt_cam_board, p);
        for (int k = 0; k < 2; k++)
            marks[i].q_px[k] += noise_px * test_random_normal(&seed);
    }
}

static void marks_place_it(void **state)
{
    (void)state;
    sheen_err err;
    sheen_camera camera;
    sheen_poses poses;
    sheen_register_point marks[MARKS];
    sheen_register_points_fit fit;
    assert_ok(sheen_camera_opencv(&camera, 800, 600, (const double[4]){900, 900, 400, 300}, NULL, 0, &err),
              err);
    for (int sized = 0; sized < 2; sized++) {
        double rt[6];
        marks_make(marks, &poses, &camera, 0.5);
        assert_ok(sheen_register_points_solve(&fit, marks, MARKS, &camera, &poses, sized ? 1e-3 : 0, &err),
                  err);
        sheen_rt_from_Rt(rt, &fit.placement.Rt_board_obj);
        assert_close(fit.placement.scale, 1e-3, sized ? 0 : 1e-5);
        assert_close(sheen_rt_angle_rad(rt, rt_board_obj), 0, 1 * DEG);
        assert_close(fit.rms_px, 0.5, 0.3);
        for (int k = 3; k < 6; k++)
            assert_close(rt[k], rt_board_obj[k], 1e-3);
        assert_true(fit.sigma_rad < 1 * DEG && fit.sigma_m < 1e-3);
        marks[4].q_px[0] += 30;
        assert_ok(sheen_register_points_solve(&fit, marks, MARKS, &camera, &poses, 1e-3, &err), err);
        assert_int_equal((int)fit.i_worst, 4);
        sheen_poses_release(&poses);
    }
    marks_make(marks, &poses, &camera, 0);
    assert_fails(sheen_register_points_solve(&fit, marks, 3, &camera, &poses, 1e-3, &err), err, SHEEN_EDATA,
                 "at least 4");
    for (int i = 0; i < MARKS; i++)
        strcpy(marks[i].frame, "c");
    assert_fails(sheen_register_points_solve(&fit, marks, MARKS, &camera, &poses, 1e-3, &err), err,
                 SHEEN_EDATA, "0 marks lie in frames that have a pose");
    sheen_poses_release(&poses);
}

static void reads_marks(void **state)
{
    (void)state;
    sheen_err err;
    sheen_register_point *marks;
    size_t n;
    const char good[] = "# beak\nin00 10.5 20 1 2 3\n\nin01 1 2 3 4 5 # tail\n";
    assert_ok(sheen_register_points_parse(&marks, &n, good, sizeof good - 1, &err), err);
    assert_int_equal((int)n, 2);
    assert_string_equal(marks[1].frame, "in01");
    assert_close(marks[0].q_px[0], 10.5, 0);
    assert_close(marks[1].p_obj[2], 5, 0);
    free(marks);
    static const char *const bad[] = {"in00 1 2 3 4", "in00 1 2 3 4 5 6", "in00 1 2 nan 4 5",
                                      "in00 1 2 x 4 5"};
    for (int i = 0; i < 4; i++)
        assert_fails(sheen_register_points_parse(&marks, &n, bad[i], strlen(bad[i]), &err), err,
                     SHEEN_EFORMAT, "line 1");
    assert_fails(sheen_register_points_parse(&marks, &n, "# nothing\n", 10, &err), err, SHEEN_EDATA,
                 "no marks");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_place_unit_and_up),
        cmocka_unit_test(says_that_a_bottle_turns_alike),
        cmocka_unit_test(refuses_what_does_not_fit),
        cmocka_unit_test(follows_image_edges_where_masks_are_rough),
        cmocka_unit_test(is_as_good_as_it_says),
        cmocka_unit_test(marks_place_it),
        cmocka_unit_test(reads_marks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
