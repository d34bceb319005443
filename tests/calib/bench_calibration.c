// SPDX-License-Identifier: Apache-2.0
// Our calibration beside mrcal-calibrate-cameras and OpenCV's calibrateCamera on the same corners, and the time of a
// frame from picture to pose. The other two run where they are installed (packages mrcal, python3-opencv).
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "base/progress.h"
#include "calib/calibrate.h"
#include "calib/saddles.h"
#include "calib/vnl.h"
#include "pose/board_pose.h"
#include "support.h"
#include "support_board.h"
#include "synthetic_views.h"

enum { MAX_FRAMES = 100 };

typedef struct problem {
    sheen_board board;
    sheen_camera truth;
    int n;
    sheen_board_view views[MAX_FRAMES];
} problem;

static void problem_make(problem *p, int n, double sigma_px, const double warp_m[2])
{
    sheen_err err;
    uint64_t seed = 31;
    const double k[8] = {-0.30, 0.10, 0.0008, -0.0006, 0.01, 0.02, -0.01, 0.003};
    assert_ok(sheen_camera_opencv(&p->truth, 1280, 960, (const double[4]){1100, 1100, 645, 472}, k, 8, &err),
              err);
    test_board_make(&p->board, 12, 9, 0.025, 0.72, 0, 0);
    p->n = n;
    for (int i = 0; i < n; i++) {
        char name[24];
        double rt_cam_board[6];
        snprintf(name, sizeof name, "frame%03d", i);
        test_calibration_pose(rt_cam_board, i, 0.4);
        test_view_make(&p->views[i], name, &p->board, &p->truth, rt_cam_board, sigma_px, warp_m, &seed);
        snprintf(p->views[i].file, sizeof p->views[i].file, "%s.png", name);
    }
}

static void problem_release(problem *p)
{
    for (int i = 0; i < p->n; i++)
        sheen_board_view_release(&p->views[i]);
    sheen_board_release(&p->board);
}

static void say(const char *who, const sheen_camera *found, const sheen_camera *truth, double wall_s,
                double cpu_s)
{
    static const double edge_px[4] = {0, 400, 600, 800};
    sheen_err err;
    double ring_px[3];
    for (int k = 0; k < 3; k++) {
        sheen_camera_difference d;
        ring_px[k] = sheen_camera_compare_ring(&d, found, truth, 0.4, edge_px[k], edge_px[k + 1], &err)
                         ? (double)NAN
                         : d.moved_rms_px;
    }
    printf("  %-28s to the truth %.4f / %.4f / %.4f px, wall %.3f s, cpu %.3f s\n", who, ring_px[0],
           ring_px[1], ring_px[2], wall_s, cpu_s);
}

// Of all programs that were run and have ended.
static double children_cpu_s(void)
{
    struct rusage u;
    assert_int_equal(getrusage(RUSAGE_CHILDREN, &u), 0);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

static void run_mrcal(const problem *p, const sheen_camera *ours, const double ours_s[2], const char *folder)
{
    sheen_err err;
    sheen_camera theirs;
    sheen_camera_difference d;
    char command[2400], path[TEST_PATH_MAX];
    if (system("command -v mrcal-calibrate-cameras >/dev/null 2>&1")) {
        printf("  mrcal-calibrate-cameras is not installed\n");
        return;
    }
    snprintf(command, sizeof command,
             "cd '%s' && mrcal-calibrate-cameras --corners-cache corners.vnl --lensmodel LENSMODEL_OPENCV8 "
             "--focal 1100 "
             "--imagersize 1280 960 --object-spacing 0.025 --object-width-n 11 --object-height-n 8 "
             "--skip-outlier-rejection 'frame*.png' >log 2>&1",
             folder);
    const sheen_stopwatch start = sheen_stopwatch_now();
    const double cpu_before_s = children_cpu_s();
    if (system(command)) {
        printf("  mrcal-calibrate-cameras failed\n");
        return;
    }
    const double wall_s = sheen_stopwatch_now().wall_s - start.wall_s;
    const double cpu_s = children_cpu_s() - cpu_before_s;
    snprintf(path, sizeof path, "%s/camera-0.cameramodel", folder);
    assert_ok(sheen_camera_load(&theirs, path, &err), err);
    say("mrcal-calibrate-cameras", &theirs, &p->truth, wall_s, cpu_s);
    assert_ok(sheen_camera_compare(&d, ours, &theirs, 0.4, &err), err);
    printf("  ours and theirs differ by %.5f px rms (%.5f at most) as they are; ours takes %.3f of the time, "
           "%.3f of "
           "the processor's\n",
           d.raw_rms_px, d.raw_max_px, ours_s[0] / wall_s, ours_s[1] / cpu_s);
}

static void run_opencv(const problem *p, const char *folder, int n_coefficients)
{
    sheen_err err;
    sheen_camera theirs;
    double f[4], k[8] = {0}, wall_s;
    char command[2400];
    snprintf(
        command, sizeof command,
        "cd '%s' && /usr/bin/python3 -c \"\n"
        "import cv2, time, numpy as np\n"
        "frames = {}\n"
        "for l in open('corners.vnl'):\n"
        "    if l[0] != '#':\n"
        "        w = l.split(); frames.setdefault(w[0], []).append(w[1:3])\n"
        "g = np.array([(x, y, 0) for y in range(8) for x in range(11)], np.float32) * 0.025\n"
        "o, q = [], []\n"
        "for rows in frames.values():\n"
        "    keep = [i for i, w in enumerate(rows) if w[0] != '-']\n"
        "    o.append(g[keep]); q.append(np.array([[float(v) for v in rows[i]] for i in keep], np.float32))\n"
        "t = time.time()\n"
        "r, K, d, _, _ = cv2.calibrateCamera(o, q, (1280, 960), None, None, flags=%s)\n"
        "d = d.ravel()[:%d]\n"
        "print(time.time() - t, K[0,0], K[1,1], K[0,2], K[1,2], *d)\" 2>/dev/null",
        folder, n_coefficients == 8 ? "cv2.CALIB_RATIONAL_MODEL" : "0", n_coefficients);
    FILE *answer = popen(command, "r");
    assert_non_null(answer);
    int read = fscanf(answer, "%lf %lf %lf %lf %lf", &wall_s, &f[0], &f[1], &f[2], &f[3]);
    for (int i = 0; i < n_coefficients; i++)
        read += fscanf(answer, "%lf", &k[i]);
    pclose(answer);
    if (read != 5 + n_coefficients) {
        printf("  OpenCV for Python is not installed\n");
        return;
    }
    assert_ok(sheen_camera_opencv(&theirs, 1280, 960, f, k, n_coefficients, &err), err);
    say(n_coefficients == 8 ? "calibrateCamera, 8 numbers" : "calibrateCamera, 5 numbers", &theirs, &p->truth,
        wall_s, (double)NAN);
}

static void compare(const char *what, int n, double sigma_px, const double warp_m[2], const char *folder)
{
    sheen_err err;
    problem p;
    sheen_calibration c;
    char path[TEST_PATH_MAX];
    const sheen_calibrate_options options = {0};
    problem_make(&p, n, sigma_px, warp_m);
    snprintf(path, sizeof path, "%s/corners.vnl", folder);
    assert_ok(sheen_vnl_save(path, &p.board, p.views, (size_t)n, &err), err);
    printf("%s\n", what);
    const sheen_stopwatch start = sheen_stopwatch_now();
    assert_ok(sheen_calibrate(&c, &p.board, p.views, (size_t)n, &options, &err), err);
    const sheen_stopwatch end = sheen_stopwatch_now();
    say("sheen, with its report", &c.camera, &p.truth, end.wall_s - start.wall_s, end.cpu_s - start.cpu_s);
    run_mrcal(&p, &c.camera, (const double[2]){end.wall_s - start.wall_s, end.cpu_s - start.cpu_s}, folder);
    run_opencv(&p, folder, 5);
    run_opencv(&p, folder, 8);
    sheen_calibration_release(&c);
    problem_release(&p);
}

static void beside_others(void **state)
{
    const test_scratch *scratch = *state;
    compare("20 frames, 0.2 px, flat board", 20, 0.2, (const double[2]){0, 0}, scratch->path);
    compare("20 frames, 0.2 px, board bent 0.8 and 0.5 mm", 20, 0.2, (const double[2]){0.8e-3, 0.5e-3},
            scratch->path);
    compare("100 frames, 0.2 px, board bent 0.8 and 0.5 mm", 100, 0.2, (const double[2]){0.8e-3, 0.5e-3},
            scratch->path);
}

// From grey picture to pose: 1280 x 960, noise of 2 DN, one thread.
static void a_frame(void **state)
{
    (void)state;
    enum { RUNS = 9, POSES = 100 }; // a pose alone is less than a tick of the processor's clock
    sheen_err err;
    problem p;
    sheen_tag_detector *detector;
    problem_make(&p, 1, 0, (const double[2]){0, 0});
    test_photo photo = {
        .board = &p.board, .camera = &p.truth, .blur_px = 0.7, .gamma = 2.2, .noise_dn = 2, .seed = 3};
    test_board_look(photo.rt_cam_board, (const double[2]){0, 0}, 0.5, 25, 40, 10);
    uint8_t *grey = test_photo_render(&photo);
    assert_ok(sheen_tag_detector_new(&detector, "tag36h11", &err), err);
    double best_observe = INFINITY, best_pose = INFINITY;
    for (int i = 0; i < RUNS; i++) {
        sheen_board_view view;
        sheen_board_pose pose;
        bool is_inlier[256];
        const double a = sheen_stopwatch_now().cpu_s;
        assert_ok(sheen_board_observe(&view, detector, grey, 1280, 960, &p.board, &err), err);
        const double b = sheen_stopwatch_now().cpu_s;
        for (int k = 0; k < POSES; k++)
            assert_ok(sheen_board_pose_find(&pose, is_inlier, &p.truth, &p.board, &view, &err), err);
        const double c = sheen_stopwatch_now().cpu_s;
        best_observe = fmin(best_observe, b - a);
        best_pose = fmin(best_pose, (c - b) / POSES);
        sheen_board_view_release(&view);
    }
    printf("a frame of 1280 x 960, noise 2 DN: tags and saddles %.1f ms, pose %.2f ms of CPU\n",
           1e3 * best_observe, 1e3 * best_pose);
    sheen_tag_detector_free(&detector);
    free(grey);
    problem_release(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame),
        cmocka_unit_test_setup_teardown(beside_others, test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
