// SPDX-License-Identifier: Apache-2.0
// test_orbit.c - viewpoints about an object, and films.
#include "render/orbit.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "base/file.h"
#include "base/image_file.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "render/gbuffer.h"

static const double pi = 3.14159265358979323846;
static const float centre_obj[3] = {0.05f, -0.03f, 0.08f};

static void pose(sheen_Rt *Rt_cam_world, const sheen_mesh *mesh, const sheen_camera *cam,
                 const double rt_world_obj[6], double azimuth_rad, double elevation_rad, double distance_m)
{
    sheen_err err = {0};
    double rt_cam_obj[6], rt_obj_world[6], rt_cam_world[6];
    assert_ok(
        sheen_view_pose(rt_cam_obj, mesh, rt_world_obj, cam, azimuth_rad, elevation_rad, distance_m, &err),
        err);
    sheen_rt_invert(rt_obj_world, rt_world_obj);
    sheen_rt_compose(rt_cam_world, rt_cam_obj, rt_obj_world);
    sheen_Rt_from_rt(Rt_cam_world, rt_cam_world);
}

static void looks_from_where_it_was_asked(void **state)
{
    (void)state;
    const double rt_world_obj[6] = {0.2, 0.4, -0.3, 0.5, 0.1, -0.2};
    sheen_mesh mesh;
    sheen_camera cam;
    sheen_Rt Rt_world_obj;
    test_sphere(&mesh, 6, centre_obj, 0.1f);
    test_camera(&cam, 400, 300, 500, 1);
    sheen_Rt_from_rt(&Rt_world_obj, rt_world_obj);
    float centre_f[3], radius_m;
    sheen_mesh_sphere(&mesh, centre_f, &radius_m);
    const double centre[3] = {(double)centre_f[0], (double)centre_f[1], (double)centre_f[2]};
    double centre_world[3];
    sheen_Rt_point(centre_world, &Rt_world_obj, centre);
    for (double azimuth = -3; azimuth < 3.2; azimuth += 0.7)
        for (double elevation = -pi / 2; elevation <= pi / 2 + 1e-9; elevation += pi / 8) {
            sheen_Rt Rt_cam_world, Rt_world_cam;
            pose(&Rt_cam_world, &mesh, &cam, rt_world_obj, azimuth, elevation, 0.7);
            sheen_Rt_invert(&Rt_world_cam, &Rt_cam_world);
            const double from[3] = {cos(elevation) * cos(azimuth), cos(elevation) * sin(azimuth),
                                    sin(elevation)};
            for (int k = 0; k < 3; k++)
                assert_close(Rt_world_cam.t[k], centre_world[k] + 0.7 * from[k],
                             0.7 * 0.03); // turned by the lens
            double p[3], q[2];
            sheen_Rt_point(p, &Rt_cam_world, centre_world);
            assert_close(sheen_norm(p), 0.7, 1e-9);
            assert_int_equal(sheen_camera_project(&cam, q, NULL, p, 1, NULL), SHEEN_OK);
            assert_close(q[0], 199.5, 1e-4);
            assert_close(q[1], 149.5, 1e-4);
            // The picture's right is level, but for the small turn; up in the world is up in the picture.
            assert_close(Rt_cam_world.R[0][2], 0, 0.03);
            if (cos(elevation) > 0.1)
                assert_true(Rt_cam_world.R[1][2] < 0);
        }
    sheen_mesh_release(&mesh);
}

static void azimuth_zero_is_x(void **state)
{
    (void)state;
    const double none[6] = {0};
    const float origin[3] = {0, 0, 0};
    sheen_mesh mesh;
    sheen_camera cam;
    sheen_Rt Rt, inverse;
    test_sphere(&mesh, 4, origin, 0.1f);
    const double fxycxy[4] = {500, 500, 199.5, 149.5};
    assert_int_equal(sheen_camera_opencv(&cam, 400, 300, fxycxy, NULL, 0, NULL), SHEEN_OK);
    pose(&Rt, &mesh, &cam, none, 0, 0, 2);
    sheen_Rt_invert(&inverse, &Rt);
    assert_close(inverse.t[0], 2, 1e-3);
    assert_close(Rt.R[0][1], 1, 1e-9);  // +y is to the right
    assert_close(Rt.R[1][2], -1, 1e-9); // +z is up
    pose(&Rt, &mesh, &cam, none, pi / 2, 0, 2);
    sheen_Rt_invert(&inverse, &Rt);
    assert_close(inverse.t[1], 2, 1e-3); // counter-clockwise: +y next
    sheen_mesh_release(&mesh);
}

// Distance 0: the sphere's outline measures 80 % of the smaller side.
static void fills_the_picture(void **state)
{
    (void)state;
    const double none[6] = {0};
    const float origin[3] = {0, 0, 0};
    sheen_mesh mesh;
    sheen_camera cam;
    sheen_scene *scene;
    sheen_gbuffer g;
    sheen_err err = {0};
    double rt_cam_obj[6];
    test_sphere(&mesh, 30, origin, 0.1f);
    float centre[3], radius_m;
    sheen_mesh_sphere(&mesh, centre, &radius_m);
    assert_close(radius_m, 0.1, 1e-3);
    assert_ok(sheen_scene_new(&scene, &mesh, &err), err);
    test_camera(&cam, 400, 300, 350, 0);
    assert_ok(sheen_view_pose(rt_cam_obj, &mesh, none, &cam, 0.3, 0.4, 0, &err), err);
    assert_ok(sheen_gbuffer_make(&g, scene, &mesh, &cam, rt_cam_obj, 1, 0, &err), err);
    size_t n = 0;
    for (int i = 0; i < g.width_px * g.height_px; i++)
        n += g.hits[i].triangle != SHEEN_NO_HIT;
    const double diameter_px = 2 * sqrt((double)n / pi);
    assert_close(diameter_px, 0.8 * 300, 3);
    sheen_gbuffer_release(&g);
    sheen_scene_free(&scene);
    sheen_mesh_release(&mesh);
}

static void refuses_other_views(void **state)
{
    (void)state;
    const double none[6] = {0};
    sheen_mesh mesh;
    sheen_camera cam;
    sheen_err err = {0};
    double rt[6];
    test_sphere(&mesh, 2, centre_obj, 0.1f);
    test_camera(&cam, 400, 300, 350, 0);
    assert_fails(sheen_view_pose(rt, &mesh, none, &cam, (double)NAN, 0, 1, &err), err, SHEEN_EARG, "azimuth");
    assert_fails(sheen_view_pose(rt, &mesh, none, &cam, 0, 0, -1, &err), err, SHEEN_EARG, "distance");
    sheen_mesh_release(&mesh);
}

static void frame_of(sheen_image *img, int width_px, int height_px, float phase)
{
    assert_int_equal(sheen_image_init(img, width_px, height_px, 3, NULL), SHEEN_OK);
    for (int y = 0; y < height_px; y++)
        for (int x = 0; x < width_px; x++) {
            float *px = sheen_image_at(img, x, y);
            px[0] = x < width_px / 2 ? 0.8f : 0.1f;
            px[1] = y < height_px / 2 ? 0.6f : 0.05f;
            px[2] = phase;
        }
}

static size_t count_files(const char *dir)
{
    sheen_names names;
    assert_int_equal(sheen_dir_list(&names, dir, NULL, NULL), SHEEN_OK);
    const size_t n = names.count;
    sheen_names_release(&names);
    return n;
}

// No child of ours is left over.
static void assert_no_children(void)
{
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
}

// The film's third frame, decoded by ffmpeg, has the colours that went in.
static void check_film(const char *path, const char *png)
{
    char command[3 * TEST_PATH_MAX];
    snprintf(
        command, sizeof command,
        "ffmpeg -hide_banner -loglevel error -y -i '%s' -vf 'select=eq(n\\,2),scale=in_color_matrix=bt709' "
        "-frames:v 1 '%s'",
        path, png);
    assert_int_equal(system(command), 0); // NOLINT(cert-env33-c)
    sheen_raster r;
    sheen_image img;
    sheen_err err = {0};
    assert_ok(sheen_raster_load(&r, png, &err), err);
    assert_int_equal(r.width_px, 96);
    assert_int_equal(r.height_px, 64);
    assert_ok(sheen_image_from_raster(&img, &r, SHEEN_TRANSFER_SRGB, &err), err);
    const float *left = sheen_image_at(&img, 20, 15), *right = sheen_image_at(&img, 70, 50);
    assert_close(left[0], 0.8, 0.05);
    assert_close(left[1], 0.6, 0.05);
    assert_close(left[2], 0.3, 0.05);
    assert_close(right[0], 0.1, 0.04);
    assert_close(right[1], 0.05, 0.04);
    sheen_image_release(&img);
    sheen_raster_release(&r);
}

static void films_are_written(void **state)
{
    const test_scratch *scratch = *state;
    static const char *const names[] = {"-film.mp4", "film.WEBM"};
    for (size_t i = 0; i < 2; i++) {
        char path[TEST_PATH_MAX], png[TEST_PATH_MAX];
        sheen_film *film;
        sheen_err err = {0};
        test_scratch_file(path, scratch, names[i]);
        test_scratch_file(png, scratch, "frame.png");
        const sheen_status s = sheen_film_open(&film, path, 97, 65, 10, &err); // odd sizes are cropped
        if (s == SHEEN_EUNSUP && strstr(err.msg, "not installed"))
            test_skip("ffmpeg is not installed");
        assert_ok(s, err);
        for (int k = 0; k < 5; k++) {
            sheen_image img;
            frame_of(&img, 97, 65, 0.1f * (float)(k + 1));
            assert_ok(sheen_film_add(film, &img, &err), err);
            sheen_image_release(&img);
        }
        assert_false(sheen_file_exists(path)); // not before it is complete
        assert_ok(sheen_film_close(&film, 1, &err), err);
        assert_null(film);
        assert_true(sheen_file_exists(path));
        assert_no_children();
        check_film(path, png);
        assert_int_equal(sheen_file_remove(path, NULL), SHEEN_OK);
        assert_int_equal(sheen_file_remove(png, NULL), SHEEN_OK);
        assert_int_equal(count_files(scratch->path), 0);
    }
}

static void a_film_that_is_not_kept_leaves_nothing(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    sheen_film *film;
    sheen_image img;
    sheen_err err = {0};
    test_scratch_file(path, scratch, "film.mp4");
    if (sheen_film_open(&film, path, 64, 64, 10, &err))
        test_skip("ffmpeg is not installed");
    frame_of(&img, 64, 64, 0.5f);
    assert_ok(sheen_film_add(film, &img, &err), err);
    sheen_image_release(&img);
    assert_ok(sheen_film_close(&film, 0, &err), err);
    assert_null(film);
    assert_int_equal(count_files(scratch->path), 0);
    assert_no_children();
    assert_ok(sheen_film_close(&film, 1, &err), err); // nothing open is fine
}

// ffmpeg ends at once: no signal, a sentence, no file, no zombie.
static void a_film_that_cannot_be_written(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    sheen_film *film;
    sheen_image img;
    sheen_err err = {0};
    test_scratch_file(path, scratch, "no/such/folder/film.mp4");
    if (sheen_film_open(&film, path, 640, 480, 10, &err))
        test_skip("ffmpeg is not installed");
    frame_of(&img, 640, 480, 0.5f);
    sheen_status s = SHEEN_OK;
    for (int i = 0; i < 1000 && !s; i++)
        s = sheen_film_add(film, &img, &err);
    assert_fails(s, err, SHEEN_EIO, "No such file or directory");
    sheen_image_release(&img);
    assert_fails(sheen_film_close(&film, 1, &err), err, SHEEN_EIO, "no/such/folder");
    assert_null(film);
    assert_no_children();
}

// ffmpeg says why in the last line but one.
static void a_full_disk_is_named(void **state)
{
    static const char script[] = "#!/bin/sh\n"
                                 "echo 'Could not write header: No space left on device' >&2\n"
                                 "echo 'Error initializing output stream 0:0 -- ' >&2\n"
                                 "exit 1\n";
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX], program[TEST_PATH_MAX], old_path[1024];
    sheen_film *film;
    sheen_err err = {0};
    test_scratch_file(program, scratch, "ffmpeg");
    test_scratch_file(path, scratch, "film.mp4");
    test_file_write_text(program, script);
    assert_int_equal(chmod(program, 0700), 0);
    snprintf(old_path, sizeof old_path, "%s", getenv("PATH"));
    setenv("PATH", scratch->path, 1);
    assert_ok(sheen_film_open(&film, path, 64, 64, 10, &err), err);
    setenv("PATH", old_path, 1);
    assert_fails(sheen_film_close(&film, 1, &err), err, SHEEN_EIO, "the disk is full");
    assert_no_children();
}

static void refuses_other_films(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX], old_path[1024];
    sheen_film *film;
    sheen_image img;
    sheen_err err = {0};
    test_scratch_file(path, scratch, "film.avi");
    assert_fails(sheen_film_open(&film, path, 64, 64, 10, &err), err, SHEEN_EUNSUP, ".mp4 or .webm");
    test_scratch_file(path, scratch, "film.mp4");
    assert_fails(sheen_film_open(&film, path, 1, 64, 10, &err), err, SHEEN_EARG, "1 x 64");
    assert_fails(sheen_film_open(&film, path, 64, 64, 0, &err), err, SHEEN_EARG, "0 frames");
    if (!sheen_film_open(&film, path, 64, 64, 10, &err)) {
        frame_of(&img, 32, 64, 0.5f);
        assert_fails(sheen_film_add(film, &img, &err), err, SHEEN_EARG, "does not fit");
        sheen_image_release(&img);
        assert_ok(sheen_film_close(&film, 0, &err), err);
    }
    snprintf(old_path, sizeof old_path, "%s", getenv("PATH"));
    setenv("PATH", scratch->path, 1);
    assert_fails(sheen_film_open(&film, path, 64, 64, 10, &err), err, SHEEN_EUNSUP, "not installed");
    assert_null(film);
    setenv("PATH", old_path, 1);
    assert_no_children();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(looks_from_where_it_was_asked),
        cmocka_unit_test(azimuth_zero_is_x),
        cmocka_unit_test(fills_the_picture),
        cmocka_unit_test(refuses_other_views),
        cmocka_unit_test_setup_teardown(films_are_written, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_film_that_is_not_kept_leaves_nothing, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_film_that_cannot_be_written, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_full_disk_is_named, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(refuses_other_films, test_scratch_setup, test_scratch_teardown),
    };
    return test_result(cmocka_run_group_tests(tests, NULL, NULL));
}
