// SPDX-License-Identifier: Apache-2.0
// calibrate.h - a camera's lens from views of the board, through mrcal, with a summary that says how far to trust it.
#ifndef SHEEN_CALIB_CALIBRATE_H
#define SHEEN_CALIB_CALIBRATE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/board.h"
#include "base/camera.h"
#include "base/progress.h"
#include "calib/compare.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SHEEN_CALIBRATE_MIN_FRAMES = 5,   // fewer do not determine a lens reliably
    SHEEN_CALIBRATE_MIN_CORNERS = 12, // of a usable frame, in at least 3 rows and 3 columns
    SHEEN_COVERAGE_COLS = 6,
    SHEEN_COVERAGE_ROWS = 4
};

typedef struct sheen_calibrate_options {
    sheen_progress progress;
    int n_threads;         // 0: one per processor
    const char *lensmodel; // "LENSMODEL_OPENCV4", 5 or 8; NULL: OPENCV8
} sheen_calibrate_options;

typedef struct sheen_calibration_frame {
    char name[64];
    bool used;
    char reason[160]; // why it was not used
    int n_corners, n_outliers;
    double rms_px; // per axis, of its inliers; NaN where not used
    double rt_cam_board[6];
} sheen_calibration_frame;

typedef struct sheen_calibration {
    sheen_camera camera;
    size_t n_frames;
    sheen_calibration_frame *frames;                     // in the order of the views
    int n_used, n_corners, n_outliers;                   // corners and outliers of used frames
    double rms_px;                                       // per axis, over inliers
    int i_worst;                                         // used frame with the largest rms
    int cells[SHEEN_COVERAGE_ROWS][SHEEN_COVERAGE_COLS]; // inliers in each cell of the image
    double coverage;                                     // share of those cells that hold a corner
    double warp_m[2];  // how far the board's middle stands out of its edges: along x, along y
    double distance_m; // median distance of the board
    double tilt_rad;   // largest angle between the board's normals of two frames
    // One camera from the even frames, one from the odd: how they differ at distance_m; NaN where they differ so
    // much that one looks where the other cannot. False with fewer than twice the smallest number of frames.
    bool has_halves;
    sheen_camera_difference halves;
    // One standard deviation of where a point at distance_m is projected, in the direction in which it is
    // largest, given the noise found in the corners: at the image's centre, and the largest over the middles of
    // the coverage cells. NaN where it could not be had.
    double sigma_centre_px, sigma_worst_px;
    bool good;         // meets the limits that the verdict speaks of
    char verdict[320]; // one sentence: how good, and what to do next
} sheen_calibration;

// From views of one board through one camera. EARG: unknown lens model; EDATA: too few usable views, views of
// different sizes, corners that are not finite, or no convergence. Release *out after success.
sheen_status sheen_calibrate(sheen_calibration *out, const sheen_board *board, const sheen_board_view *views,
                             size_t n_views, const sheen_calibrate_options *options, sheen_err *err);
void sheen_calibration_release(sheen_calibration *c);

#ifdef __cplusplus
}
#endif
#endif
