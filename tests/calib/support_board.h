// SPDX-License-Identifier: Apache-2.0
// support_board.h - boards, and photographs of them, for tests: a small renderer of its own.
//
// The board's ink is looked up exactly, through the camera's full lens model, at 8 x 8 places in each pixel that an
// edge crosses; then blur, coding by a power law, noise, 8 bit.
#ifndef SHEEN_TESTS_SUPPORT_BOARD_H
#define SHEEN_TESTS_SUPPORT_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "base/board.h"
#include "base/camera.h"

// n_cols x n_rows squares, tags of tag_ratio of a square, ids from first_id on; corners and tags whose centre is
// within blank_radius_m of the board's centre are not printed. Release with sheen_board_release.
void test_board_make(sheen_board *board, int n_cols, int n_rows, double square_m, double tag_ratio,
                     int first_id, double blank_radius_m);
// board.json of it.
void test_board_save(const sheen_board *board, const char *path);

typedef struct test_photo {
    const sheen_board *board;
    const sheen_camera *camera;
    double rt_cam_board[6];
    double blur_px;  // sigma of the point spread
    double gamma;    // code = light^(1/gamma); 0: 1
    double noise_dn; // sigma, 8-bit steps
    // A grey disc (an object's outline) in the board's plane; radius 0: none.
    double cover_board[2], cover_radius_m;
    uint64_t seed;
} test_photo;

// width_px * height_px grey values; free() them.
uint8_t *test_photo_render(const test_photo *photo);

// A pose that looks at (target) on the board from distance_m, its axis tilted from the board's normal by tilt_deg
// towards azimuth_deg, rolled about itself.
void test_board_look(double rt_cam_board[6], const double target_board[2], double distance_m, double tilt_deg,
                     double azimuth_deg, double roll_deg);

// Where the camera sees a point of the board.
void test_board_project(double q_px[2], const sheen_camera *camera, const double rt_cam_board[6],
                        const double p_board[3]);

#endif
