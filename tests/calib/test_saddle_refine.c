// SPDX-License-Identifier: Apache-2.0
// The corner refinement against its slow twin, against truth, and where there is no corner.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calib/saddle_refine.h"
#include "support.h"
#include "support_board.h"

// A photograph of a board without tags in its white squares, and the truth of its corners.
typedef struct photo {
    sheen_board board;
    sheen_camera camera;
    double rt_cam_board[6];
    uint8_t *grey;
} photo;

static void photo_make(photo *p, double tilt_deg, double blur_px, double noise_dn, double gamma)
{
    sheen_err err;
    const double k[4] = {-0.15, 0.06, 0.0005, -0.0008};
    assert_ok(sheen_camera_opencv(&p->camera, 480, 360, (const double[4]){520, 523, 236, 183}, k, 4, &err),
              err);
    test_board_make(&p->board, 9, 7, 0.02, 0.55, 0, 0);
    for (size_t i = 0; i < p->board.n_tags; i++)
        p->board.tags[i].printed = false;
    test_board_look(p->rt_cam_board, (const double[2]){0.004, -0.003}, 0.28, tilt_deg, 35, 12);
    const test_photo taken = {.board = &p->board,
                              .camera = &p->camera,
                              .rt_cam_board = {p->rt_cam_board[0], p->rt_cam_board[1], p->rt_cam_board[2],
                                               p->rt_cam_board[3], p->rt_cam_board[4], p->rt_cam_board[5]},
                              .blur_px = blur_px,
                              .noise_dn = noise_dn,
                              .gamma = gamma,
                              .seed = 5};
    p->grey = test_photo_render(&taken);
}

static void photo_release(photo *p)
{
    free(p->grey);
    sheen_board_release(&p->board);
}

static void agrees_with_its_twin_and_with_truth(void **state)
{
    (void)state;
    static const struct {
        double tilt_deg, blur_px, noise_dn, gamma, truth_px;
    } cases[] = {{0, 0.6, 0, 1, 0.03}, {30, 0.8, 2, 2.2, 0.05}, {50, 1.2, 3, 2.2, 0.12}};
    sheen_err err;
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        photo p;
        uint64_t seed = 11;
        double sum = 0, twin = 0;
        int n = 0;
        photo_make(&p, cases[c].tilt_deg, cases[c].blur_px, cases[c].noise_dn, cases[c].gamma);
        for (size_t i = 0; i < p.board.n_corners; i++) {
            double truth[2], a[2], b[2];
            test_board_project(truth, &p.camera, p.rt_cam_board, p.board.corners[i].p_board);
            if (truth[0] < 12 || truth[1] < 12 || truth[0] > 467 || truth[1] > 347)
                continue;
            for (int k = 0; k < 2; k++)
                a[k] = b[k] = truth[k] + 1.6 * (test_random(&seed) - 0.5);
            assert_ok(sheen_saddle_refine(a, p.grey, 480, 360, 5, &err), err);
            assert_ok(sheen_saddle_refine_ref(b, p.grey, 480, 360, 5, &err), err);
            twin = fmax(twin, hypot(a[0] - b[0], a[1] - b[1]));
            sum += (a[0] - truth[0]) * (a[0] - truth[0]) + (a[1] - truth[1]) * (a[1] - truth[1]);
            n++;
        }
        assert_true(n > 30);
        assert_close(twin, 0, 0.01);
        assert_close(sqrt(sum / (2 * n)), 0, cases[c].truth_px);
        photo_release(&p);
    }
}

static void refuses_edges_and_flat_places(void **state)
{
    (void)state;
    sheen_err err;
    uint8_t *flat = malloc(64 * 64);
    assert_non_null(flat);
    memset(flat, 90, 64 * 64);
    sheen_status (*const twins[])(double *, const uint8_t *, int, int, int,
                                  sheen_err *) = {sheen_saddle_refine, sheen_saddle_refine_ref};
    for (int i = 0; i < 2; i++) {
        double q[2] = {32.25, 31.75};
        assert_int_equal(twins[i](q, flat, 64, 64, 5, &err), SHEEN_EDATA);
        assert_close(q[0], 32.25, 0);
        static const double edges[][2] = {{3, 32}, {32, 3}, {60, 32}, {32, 60}, {-5, 32}, {1e9, 32}};
        for (size_t k = 0; k < sizeof edges / sizeof *edges; k++) {
            double at[2] = {edges[k][0], edges[k][1]};
            assert_fails(twins[i](at, flat, 64, 64, 5, &err), err, SHEEN_EDATA, "edge");
        }
        double nowhere[2] = {(double)NAN, 32};
        assert_fails(twins[i](nowhere, flat, 64, 64, 5, &err), err, SHEEN_EDATA, "edge");
        assert_fails(twins[i](q, flat, 64, 64, 0, &err), err, SHEEN_EARG, "out of range");
        assert_fails(twins[i](q, flat, 64, 64, 99, &err), err, SHEEN_EARG, "out of range");
    }
    free(flat);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_its_twin_and_with_truth),
        cmocka_unit_test(refuses_edges_and_flat_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
