// SPDX-License-Identifier: Apache-2.0
// test_pose_file.c - cameras and poses of other programs: conventions by hand-derived numbers, and what is refused.
#include "tests/base/damaged_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/pose3.h"
#include "base/pose_file.h"

#define CORPUS TEST_CORPUS

// Where a point of the world is seen, through the view's own camera.
static void project(const sheen_pose_file *p, size_t i_view, const double p_world[3], double q_px[2])
{
    sheen_err err;
    sheen_Rt Rt_cam_world;
    double p_cam[3];
    sheen_Rt_from_rt(&Rt_cam_world, p->views[i_view].rt_cam_world);
    sheen_Rt_point(p_cam, &Rt_cam_world, p_world);
    assert_true(p->views[i_view].i_camera >= 0);
    assert_ok(sheen_camera_project(&p->cameras[p->views[i_view].i_camera], q_px, NULL, p_cam, 1, &err), err);
}

// A NeRF camera with the identity as its matrix sits at the origin, looks along -z, y up. A point 2 m ahead, 0.2 m to
// the right and 0.1 m up is seen right of and above the centre: by 500 * 0.1 and 400 * 0.05. Their centre (320, 240)
// is the corner between the four pixels in the middle of 640 x 480: ours is (319.5, 239.5).
static void nerf_axes_and_half_pixel(void **state)
{
    (void)state;
    static const char text[] =
        "{\"fl_x\": 500, \"fl_y\": 400, \"cx\": 320, \"cy\": 240, \"w\": 640, \"h\": 480, "
        "\"frames\": [{\"file_path\": \"./images/view_7.png\", \"transform_matrix\": "
        "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}";
    sheen_err err;
    sheen_pose_file p;
    assert_ok(sheen_transforms_parse(&p, text, strlen(text), &err), err);
    assert_int_equal(p.n_views, 1);
    assert_int_equal(p.n_cameras, 1);
    assert_string_equal(p.views[0].name, "view_7");
    assert_string_equal(p.views[0].file, "./images/view_7.png");
    assert_int_equal(p.views[0].width_px, 640);
    assert_string_equal(p.cameras[0].lensmodel, "LENSMODEL_PINHOLE");
    assert_close(p.cameras[0].intrinsics[2], 319.5, 0);
    assert_close(p.cameras[0].intrinsics[3], 239.5, 0);
    static const double p_world[3] = {0.2, 0.1, -2};
    double q_px[2];
    project(&p, 0, p_world, q_px);
    assert_close(q_px[0], 319.5 + 50, 1e-9);
    assert_close(q_px[1], 239.5 - 20, 1e-9);
    sheen_pose_file_release(&p);
}

// The camera stands at (3, 0, 0) and looks along -x, its up is +z: the columns of the matrix are its right (0, 1, 0),
// up (0, 0, 1), back (1, 0, 0).
static void nerf_camera_that_has_moved(void **state)
{
    (void)state;
    static const char text[] =
        "{\"camera_angle_x\": 1.5707963267948966, \"w\": 200, \"h\": 100, \"frames\": ["
        "{\"file_path\": \"a\", \"transform_matrix\": "
        "[[0, 0, 1, 3], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]}]}";
    sheen_err err;
    sheen_pose_file p;
    assert_ok(sheen_transforms_parse(&p, text, strlen(text), &err), err);
    assert_close(p.cameras[0].intrinsics[0], 100, 1e-9); // 200 / 2 / tan(45 degrees)
    assert_close(p.cameras[0].intrinsics[1], 100, 1e-9);
    assert_close(p.cameras[0].intrinsics[2], 99.5, 1e-9);
    assert_close(p.cameras[0].intrinsics[3], 49.5, 1e-9);
    static const double p_world[3] = {0, 0.6, 0.3}; // 3 m ahead, 0.6 right, 0.3 up
    double q_px[2];
    project(&p, 0, p_world, q_px);
    assert_close(q_px[0], 99.5 + 20, 1e-9);
    assert_close(q_px[1], 49.5 - 10, 1e-9);
    sheen_pose_file_release(&p);
}

static void nerf_cameras_per_frame_and_shared(void **state)
{
    (void)state;
    sheen_err err;
    sheen_pose_file p;
    assert_ok(sheen_pose_file_load(&p, CORPUS "transforms/opencv.json", &err), err);
    assert_int_equal(p.n_views, 2);
    assert_int_equal(p.n_cameras, 1);
    assert_int_equal(p.views[1].i_camera, 0);
    assert_string_equal(p.cameras[0].lensmodel, "LENSMODEL_OPENCV4");
    static const double want[] = {500, 501, 319.5, 239.5, 0.1, -0.1, 0.001, 0.002};
    for (int i = 0; i < 8; i++)
        assert_close(p.cameras[0].intrinsics[i], want[i], 0);
    sheen_pose_file_release(&p);
    assert_ok(sheen_pose_file_load(&p, CORPUS "transforms/per-frame.json", &err), err);
    assert_int_equal(p.n_cameras, 2);
    assert_int_equal(p.views[1].i_camera, 1);
    assert_close(p.cameras[0].intrinsics[0], 1, 0);
    assert_int_equal(p.cameras[0].width_px, 10);
    assert_close(p.cameras[1].intrinsics[0], 2, 0);
    sheen_pose_file_release(&p);
    assert_ok(sheen_pose_file_load(&p, CORPUS "transforms/no-camera.json", &err), err);
    assert_int_equal(p.views[0].i_camera, -1);
    assert_int_equal(p.n_cameras, 0);
    sheen_pose_file_release(&p);
    assert_ok(sheen_pose_file_load(&p, CORPUS "transforms/3x4.json", &err), err);
    assert_string_equal(p.views[0].name, "000000"); // no file_path
    assert_string_equal(p.views[0].file, "");
    sheen_pose_file_release(&p);
    assert_ok(sheen_pose_file_load(&p, CORPUS "transforms/k3-zero.json", &err), err);
    sheen_pose_file_release(&p);
}

// q = (cos 45, 0, sin 45, 0): 90 degrees about y takes x to -z and z to x. COLMAP's pose takes the world to the
// camera: the point (-2, 0.1, 0.2) is at (0.2, 0.1, 2) before t = (0.1, 0.2, 0.5).
static void colmap_quaternion_and_half_pixel(void **state)
{
    (void)state;
    static const char cameras[] = "# comment\n\n3 PINHOLE 640 480 500 400 320 240\n"
                                  "9 SIMPLE_RADIAL 64 48 50 32 24 -0.01\n";
    static const char images[] =
        "# comment\n#\n"
        "1 0.70710678118654752 0 0.70710678118654752 0 0.1 0.2 0.5 3 left/IMG 1.JPG\n"
        "\n" // no keypoints: an empty line belongs to the image
        "2 1 0 0 0 0 0 0 9 b\n1.5 2.5 -1 3.5 4.5 17\n";
    sheen_err err;
    sheen_pose_file p;
    assert_ok(sheen_colmap_parse(&p, cameras, strlen(cameras), images, strlen(images), &err), err);
    assert_int_equal(p.n_views, 2);
    assert_int_equal(p.n_cameras, 2);
    assert_string_equal(p.views[0].name, "IMG 1");
    assert_string_equal(p.views[0].file, "left/IMG 1.JPG");
    assert_string_equal(p.views[1].name, "b");
    assert_int_equal(p.views[1].i_camera, 1);
    assert_int_equal(p.views[1].width_px, 64);
    static const double p_world[3] = {-2, 0.1, 0.2};
    double q_px[2];
    project(&p, 0, p_world, q_px);
    assert_close(q_px[0], 319.5 + 500 * 0.3 / 2.5, 1e-9);
    assert_close(q_px[1], 239.5 + 400 * 0.3 / 2.5, 1e-9);
    assert_string_equal(p.cameras[1].lensmodel, "LENSMODEL_OPENCV4");
    assert_close(p.cameras[1].intrinsics[4], -0.01, 0);
    assert_close(p.cameras[1].intrinsics[3], 23.5, 0);
    sheen_pose_file_release(&p);
}

static void colmap_lens_models(void **state)
{
    (void)state;
    static const struct {
        const char *line, *lensmodel;
        double want[12];
    } cases[] = {
        {"1 SIMPLE_PINHOLE 64 48 50 32 24", "LENSMODEL_PINHOLE", {50, 50, 31.5, 23.5}},
        {"1 RADIAL 64 48 50 32 24 .1 .2", "LENSMODEL_OPENCV4", {50, 50, 31.5, 23.5, .1, .2, 0, 0}},
        {"1 OPENCV 64 48 50 51 32 24 .1 .2 .3 .4", "LENSMODEL_OPENCV4", {50, 51, 31.5, 23.5, .1, .2, .3, .4}},
        {"1 FULL_OPENCV 64 48 50 51 32 24 .1 .2 .3 .4 .5 .6 .7 .8",
         "LENSMODEL_OPENCV8",
         {50, 51, 31.5, 23.5, .1, .2, .3, .4, .5, .6, .7, .8}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_err err;
        sheen_camera *cameras;
        int *ids;
        size_t n;
        assert_ok(sheen_colmap_cameras_parse(&cameras, &ids, &n, cases[i].line, strlen(cases[i].line), &err),
                  err);
        assert_int_equal(n, 1);
        assert_int_equal(ids[0], 1);
        assert_string_equal(cameras[0].lensmodel, cases[i].lensmodel);
        for (int k = 0; k < cameras[0].n_intrinsics; k++)
            assert_close(cameras[0].intrinsics[k], cases[i].want[k], 0);
        free(cameras);
        free(ids);
    }
}

static void colmap_folders_and_poses_json(void **state)
{
    const test_scratch *scratch = *state;
    char cameras[TEST_PATH_MAX], images[TEST_PATH_MAX], poses[TEST_PATH_MAX];
    test_scratch_file(cameras, scratch, "cameras.txt");
    test_scratch_file(images, scratch, "images.txt");
    test_scratch_file(poses, scratch, "poses.json");
    sheen_err err;
    sheen_pose_file p;
    assert_fails(sheen_pose_file_load(&p, scratch->path, &err), err, SHEEN_EIO, "cameras.txt': No such file");
    test_file_write_text(cameras, "1 PINHOLE 64 48 50 50 32 24\n");
    test_file_write_text(images, "1 1 0 0 0 0 0 1 1 a.png\n\n");
    assert_ok(sheen_pose_file_load(&p, scratch->path, &err), err);
    assert_close(p.views[0].rt_cam_world[5], 1, 0);
    sheen_pose_file_release(&p);

    test_file_write_text(poses,
                         "{\"schema\": \"sheen-poses/1\", \"frames\": [{\"name\": \"a.b\", \"rt_cam_board\": "
                         "[0.1, -0.2, 0.3, 1, 2, 3]}, {\"name\": \"c\", \"reason\": \"no board\"}]}");
    assert_ok(sheen_pose_file_load(&p, poses, &err), err);
    assert_int_equal(p.n_views, 1);
    assert_string_equal(p.views[0].name, "a.b"); // a frame's name is no file name
    static const double want[] = {0.1, -0.2, 0.3, 1, 2, 3};
    for (int i = 0; i < 6; i++)
        assert_close(p.views[0].rt_cam_world[i], want[i], 0);
    assert_int_equal(p.views[0].i_camera, -1);
    sheen_pose_file_release(&p);

    char binary[TEST_PATH_MAX], want_msg[700];
    test_scratch_file(binary, scratch, "cameras.bin");
    test_file_write_text(binary, "x");
    assert_int_equal(remove(cameras), 0);
    assert_int_equal(sheen_pose_file_load(&p, scratch->path, &err), SHEEN_EUNSUP);
    snprintf(want_msg, sizeof want_msg,
             "'%s' is a binary COLMAP model: convert it with 'colmap model_converter --output_type TXT'",
             scratch->path);
    assert_string_equal(err.msg, want_msg);
}

static void transforms_round_trip(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "transforms.json");
    sheen_err err;
    sheen_camera cam;
    static const double fxycxy[] = {700, 710, 321.25, 239.5}, distortion[] = {-0.1, 0.05, 1e-3, -2e-3, 0.01};
    assert_ok(sheen_camera_opencv(&cam, 640, 480, fxycxy, distortion, 4, &err), err);
    sheen_view views[2] = {
        {.name = "a", .file = "images/a.png", .rt_cam_world = {0.3, -1.2, 2.1, 0.1, 0.2, 0.9}},
        {.name = "b", .rt_cam_world = {0, 3.0, 0, -1, 2, 3}}};
    assert_ok(sheen_transforms_save(path, &cam, views, 2, &err), err);
    sheen_pose_file p;
    assert_ok(sheen_pose_file_load(&p, path, &err), err);
    assert_int_equal(p.n_views, 2);
    assert_string_equal(p.views[0].file, "images/a.png");
    assert_string_equal(p.views[1].name, "b");
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 6; i++)
            assert_close(p.views[k].rt_cam_world[i], views[k].rt_cam_world[i], 1e-12);
    for (int i = 0; i < 8; i++)
        assert_close(p.cameras[0].intrinsics[i], cam.intrinsics[i], 1e-12);
    sheen_pose_file_release(&p);
    sheen_camera back;
    assert_ok(sheen_camera_load_any(&back, path, 0, 0, &err), err);
    assert_close(back.intrinsics[2], 321.25, 1e-12);

    assert_ok(sheen_camera_opencv(&cam, 640, 480, fxycxy, distortion, 5, &err), err);
    assert_fails(sheen_transforms_save(path, &cam, views, 2, &err), err, SHEEN_EUNSUP,
                 "transforms.json has no place for the lens model 'LENSMODEL_OPENCV5'");
}

static void colmap_round_trip(void **state)
{
    sheen_err err = {0};
    sheen_camera cam;
    sheen_pose_file back;
    char dir[512];
    const double fxycxy[4] = {500, 510, 319.5, 241},
                 distortion[8] = {-0.1, 0.02, 1e-3, -2e-3, 0.01, 0, 0.03, 0};
    const double rt[3][6] = {{0.1, -0.2, 0.3, 1, 2, 3}, {3.1, 0.02, -0.1, -1, 0, 0.5}, {0, 0, 0, 0, 0, 1}};
    const float points[6] = {0, 0, 0, 1, 2, 3};
    const uint8_t rgb[6] = {1, 2, 3, 4, 5, 6};
    sheen_view views[3] = {{.file = "a.png"}, {.file = "b.jpg"}, {.name = "c"}};
    snprintf(dir, sizeof dir, "%s/sparse/0", (const char *)*state);
    for (int i = 0; i < 3; i++)
        memcpy(views[i].rt_cam_world, rt[i], sizeof rt[i]);
    assert_ok(sheen_camera_opencv(&cam, 640, 480, fxycxy, distortion, 8, &err), err);
    assert_ok(sheen_colmap_save(dir, &cam, views, 3, points, rgb, 2, &err), err);
    assert_ok(sheen_pose_file_load(&back, dir, &err), err);
    assert_int_equal(back.n_views, 3);
    assert_int_equal(back.n_cameras, 1);
    assert_string_equal(back.cameras[0].lensmodel, "LENSMODEL_OPENCV8");
    for (int i = 0; i < 12; i++)
        assert_close(back.cameras[0].intrinsics[i], cam.intrinsics[i], 1e-12);
    for (size_t i = 0; i < 3; i++)
        for (int k = 0; k < 6; k++)
            assert_close(back.views[i].rt_cam_world[k], rt[i][k], 1e-9);
    sheen_pose_file_release(&back);
    // a smaller model is a larger one with zeros; what has no place is refused
    memcpy(cam.lensmodel, "LENSMODEL_OPENCV5", sizeof "LENSMODEL_OPENCV5");
    cam.n_intrinsics = 9;
    assert_ok(sheen_colmap_save(dir, &cam, views, 3, points, rgb, 2, &err), err);
    assert_ok(sheen_pose_file_load(&back, dir, &err), err);
    for (int i = 0; i < 12; i++)
        assert_close(back.cameras[0].intrinsics[i], i < 9 ? cam.intrinsics[i] : 0, 1e-12);
    sheen_pose_file_release(&back);
    memcpy(cam.lensmodel, "LENSMODEL_CAHVOR", sizeof "LENSMODEL_CAHVOR");
    assert_fails(sheen_colmap_save(dir, &cam, views, 3, points, rgb, 2, &err), err, SHEEN_EUNSUP, "CAHVOR");
}

static void opencv_and_ros_yaml(void **state)
{
    (void)state;
    static const struct {
        const char *path, *lensmodel;
        int n_intrinsics;
    } cases[] = {{CORPUS "opencv_yaml/opencv-5.yml", "LENSMODEL_OPENCV5", 9},
                 {CORPUS "opencv_yaml/opencv-0.yml", "LENSMODEL_PINHOLE", 4},
                 {CORPUS "opencv_yaml/opencv-8.yml", "LENSMODEL_OPENCV8", 12},
                 {CORPUS "opencv_yaml/opencv-12.yml", "LENSMODEL_OPENCV12", 16},
                 {CORPUS "opencv_yaml/no-document-mark.yml", "LENSMODEL_OPENCV4", 8},
                 {CORPUS "opencv_yaml/image-size.yml", "LENSMODEL_PINHOLE", 4},
                 {CORPUS "opencv_yaml/ros.yml", "LENSMODEL_OPENCV5", 9}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_err err;
        sheen_camera cam;
        assert_ok(sheen_camera_load_any(&cam, cases[i].path, 640, 480, &err), err);
        assert_string_equal(cam.lensmodel, cases[i].lensmodel);
        assert_int_equal(cam.n_intrinsics, cases[i].n_intrinsics);
        static const double want[] = {500, 501, 320, 240}; // OpenCV's pixels are ours: nothing is subtracted
        for (int k = 0; k < 4; k++)
            assert_close(cam.intrinsics[k], want[k], 0);
        assert_close(cam.intrinsics[4], cam.n_intrinsics > 4 ? 0.1 : 0, 0);
        assert_int_equal(cam.width_px, 640);
        assert_int_equal(cam.height_px, 480);
    }
}

static void cameras_are_told_by_content(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    sheen_err err;
    sheen_camera cam;
    test_scratch_file(path, scratch, "a.txt");
    test_file_write_text(path, "# Camera list\n1 PINHOLE 64 48 50 51 32 24\n");
    assert_ok(sheen_camera_load_any(&cam, path, 0, 0, &err), err);
    assert_close(cam.intrinsics[1], 51, 0);
    test_file_write_text(path, "1 PINHOLE 64 48 50 51 32 24\n2 PINHOLE 64 48 50 51 32 24\n");
    assert_fails(sheen_camera_load_any(&cam, path, 0, 0, &err), err, SHEEN_EFORMAT,
                 "it holds 2 cameras: leave the one that is meant");
    test_file_write_text(path,
                         "# made by hand\n{ 'lensmodel': 'LENSMODEL_PINHOLE', 'extrinsics': [0,0,0,0,0,0,], "
                         "'intrinsics': [50, 52, 31, 23,], 'imagersize': [64, 48,],}\n");
    assert_ok(sheen_camera_load_any(&cam, path, 0, 0, &err), err);
    assert_close(cam.intrinsics[1], 52, 0);
    test_file_write_text(path, "{\"camera_angle_x\": 1, \"frames\": [{\"transform_matrix\": "
                               "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
    assert_ok(sheen_camera_load_any(&cam, path, 64, 48, &err), err); // the size comes from the images
    assert_close(cam.intrinsics[0], 32 / tan(0.5), 1e-9);
    assert_fails(sheen_camera_load_any(&cam, path, 0, 0, &err), err, SHEEN_EFORMAT, "it holds 0 cameras");
    test_file_write_text(path, "  \n# nothing\n");
    assert_fails(sheen_camera_load_any(&cam, path, 0, 0, &err), err, SHEEN_EFORMAT, "the file is empty");
}

static sheen_status load(const char *path, sheen_err *err)
{
    sheen_pose_file p;
    sheen_camera cam;
    if (strstr(path, "opencv_yaml"))
        return sheen_camera_load_any(&cam, path, 0, 0, err);
    if (!strstr(path, "colmap")) {
        const sheen_status s = sheen_pose_file_load(&p, path, err);
        sheen_pose_file_release(&p);
        return s;
    }
    size_t size_bytes;
    uint8_t *data = test_file_read(path, &size_bytes);
    const char *images = strstr((const char *)data, "====\n");
    assert_non_null(images);
    const size_t at = (size_t)(images - (const char *)data);
    const sheen_status s = sheen_colmap_parse(&p, data, at, images + 5, size_bytes - at - 5, err);
    sheen_pose_file_release(&p);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : s;
}

static void says_what_is_wrong(void **state)
{
    (void)state;
    static const test_damaged_file files[] = {
        {"transforms/fisheye.json", SHEEN_EUNSUP,
         "frame 0: camera model 'OPENCV_FISHEYE' is not supported: undistort the images first"},
        {"transforms/is-fisheye.json", SHEEN_EUNSUP,
         "frame 0: a lens with 'is_fisheye' is not supported: undistort the images first"},
        {"transforms/k3.json", SHEEN_EUNSUP,
         "frame 0: distortion 'k3' = 0.1 is not supported, only k1 k2 p1 p2 are: undistort the images first"},
        {"transforms/not-a-rotation.json", SHEEN_EFORMAT,
         "frame 0: 'transform_matrix' is not a rotation and a translation"},
        {"transforms/mirror.json", SHEEN_EFORMAT,
         "frame 0: 'transform_matrix' is not a rotation and a translation"},
        {"transforms/last-row.json", SHEEN_EFORMAT,
         "frame 0: the last row of 'transform_matrix' is not 0 0 0 1"},
        {"transforms/frame-twice.json", SHEEN_EFORMAT, "frame 'a' is there twice"},
        {"transforms/no-frames.json", SHEEN_EFORMAT, "it holds no frame with a pose"},
        {"transforms/width-half.json", SHEEN_EFORMAT, "frame 0: 'w' is 640.5, not a number of pixels"},
        {"transforms/focal-zero.json", SHEEN_EFORMAT, "frame 0: 'fl_x' is 0, not a focal length"},
        {"transforms/focal-text.json", SHEEN_EFORMAT, "frame 0: 'fl_x' is not a number"},
        {"transforms/angle-pi.json", SHEEN_EFORMAT,
         "frame 0: 'camera_angle_x' is 3.14159, not an angle between 0 and pi"},
        {"transforms/matrix-of-text.json", SHEEN_EFORMAT,
         "frame 0: no list of 16 numbers 'transform_matrix'"},
        {"poses_json/no-pose.json", SHEEN_EFORMAT, "it holds no frame with a pose"},
        {"poses_json/twice.json", SHEEN_EFORMAT, "frame '000000' is there twice"},
        {"poses_json/five-numbers.json", SHEEN_EFORMAT, "frame 0: 'rt_cam_board' has 5 numbers, not 6"},
        {"poses_json/newer.json", SHEEN_EFORMAT,
         "schema 'sheen-poses/9' is newer than this program knows (1): update sheen"},
        {"board/3x3.json", SHEEN_EFORMAT, "neither transforms.json nor poses.json: it has no list 'frames'"},
        {"colmap/opencv-fisheye-8.txt", SHEEN_EUNSUP,
         "cameras.txt, line 1: lens model 'OPENCV_FISHEYE' is not supported: undistort the images with "
         "COLMAP"},
        {"colmap/simple-radial-3.txt", SHEEN_EFORMAT,
         "cameras.txt, line 1: SIMPLE_RADIAL has 4 parameters, all finite"},
        {"colmap/pinhole-5.txt", SHEEN_EFORMAT,
         "cameras.txt, line 1: PINHOLE has 4 parameters, here are more"},
        {"colmap/pinhole-4-nan.txt", SHEEN_EFORMAT,
         "cameras.txt, line 1: PINHOLE has 4 parameters, all finite"},
        {"colmap/pinhole-4-zero.txt", SHEEN_EFORMAT,
         "cameras.txt, line 1: the camera's focal length 0 x 501 px is not positive"},
        {"colmap/camera-twice.txt", SHEEN_EFORMAT, "cameras.txt: camera 1 is there twice"},
        {"colmap/camera-missing.txt", SHEEN_EFORMAT, "images.txt, line 4: cameras.txt has no camera 9"},
        {"colmap/quaternion-zero.txt", SHEEN_EFORMAT, "images.txt, line 2: the quaternion is not a rotation"},
        {"colmap/name-twice.txt", SHEEN_EFORMAT, "frame 'IMG 1' is there twice"},
        {"colmap/no-images.txt", SHEEN_EFORMAT, "it holds no frame with a pose"},
        {"colmap/no-cameras.txt", SHEEN_EFORMAT, "cameras.txt holds no camera"},
        {"colmap/width-huge.txt", SHEEN_EFORMAT,
         "cameras.txt, line 1: width and height are not numbers of pixels"},
        {"opencv_yaml/three-coefficients.yml", SHEEN_EFORMAT,
         "'distortion_coefficients' has 3 coefficients, not 0, 4, 5, 8 or 12"},
        {"opencv_yaml/opencv-14-tilted.yml", SHEEN_EUNSUP,
         "a tilted sensor (14 coefficients in 'distortion_coefficients') is not supported"},
        {"opencv_yaml/nan.yml", SHEEN_EFORMAT,
         "'distortion_coefficients' holds something else than finite numbers"},
        {"opencv_yaml/skew.yml", SHEEN_EUNSUP,
         "'camera_matrix' has a skew of 1, which no lens model here has"},
        {"opencv_yaml/no-matrix.yml", SHEEN_EFORMAT, "it has no 'camera_matrix'"},
        {"opencv_yaml/no-distortion.yml", SHEEN_EFORMAT, "it has no 'distortion_coefficients'"},
        {"opencv_yaml/no-document-mark.yml", SHEEN_EFORMAT,
         "it states no image_width and image_height, and no image tells them"},
        {"opencv_yaml/fisheye.yml", SHEEN_EUNSUP, "a fisheye calibration is not supported: calibrate anew"},
        {"opencv_yaml/ros-equidistant.yml", SHEEN_EUNSUP,
         "distortion model 'equidistant' is not supported: use plumb_bob"},
    };
    test_damaged_files(files, sizeof files / sizeof *files, load);
}

static void cut_files_are_refused(void **state)
{
    (void)state;
    size_t size_bytes;
    uint8_t *data = test_file_read(CORPUS "transforms/opencv.json", &size_bytes);
    sheen_pose_file p;
    for (size_t n = 0; n < size_bytes; n++) {
        assert_int_equal(sheen_transforms_parse(&p, data, n, NULL), SHEEN_EFORMAT);
        assert_null(p.views);
    }
    free(data);
    data = test_file_read(CORPUS "opencv_yaml/ros.yml", &size_bytes);
    sheen_camera cam;
    for (size_t n = 0; n + 2 < size_bytes; n++) // the last two are the bracket and the end of the line
        assert_int_not_equal(sheen_opencv_yaml_parse(&cam, data, n, 0, 0, NULL), SHEEN_OK);
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nerf_axes_and_half_pixel),
        cmocka_unit_test(nerf_camera_that_has_moved),
        cmocka_unit_test(nerf_cameras_per_frame_and_shared),
        cmocka_unit_test(colmap_quaternion_and_half_pixel),
        cmocka_unit_test(colmap_lens_models),
        cmocka_unit_test_setup_teardown(colmap_folders_and_poses_json, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(transforms_round_trip, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(colmap_round_trip, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test(opencv_and_ros_yaml),
        cmocka_unit_test_setup_teardown(cameras_are_told_by_content, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(says_what_is_wrong),
        cmocka_unit_test(cut_files_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
