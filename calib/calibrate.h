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
#include "calib/vignetting.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SHEEN_CALIBRATE_MIN_FRAMES = 5,   // fewer do not determine a lens reliably
    SHEEN_CALIBRATE_MIN_CORNERS = 12, // of a usable frame, in at least 3 rows and 3 columns
    SHEEN_COVERAGE_COLS = 6,
    SHEEN_COVERAGE_ROWS = 4,
    SHEEN_SIGMA_COLS = 24, // of the map of uncertainty
    SHEEN_SIGMA_ROWS = 18,
    SHEEN_MAX_CANDIDATES = 8,
    SHEEN_REGION_MAX = 4 * SHEEN_SIGMA_ROWS + 1
};

#define SHEEN_VALID_SIGMA_PX 0.5

typedef struct sheen_calibrate_options {
    sheen_progress progress;
    int n_threads; // 0: one per processor
    // "opencv4", "opencv5", "opencv8", "cahvor", "splined", mrcal's name of one of them, or "auto": the one that
    // predicts views best from which it was not made. NULL: opencv8.
    const char *lensmodel;
} sheen_calibrate_options;

typedef struct sheen_calibration_frame {
    char name[64];
    bool used;
    char reason[160]; // why it was not used
    int n_corners, n_outliers;
    double rms_px; // per axis, of its inliers; NaN where not used
    double rt_cam_board[6];
} sheen_calibration_frame;

typedef struct sheen_calibration_corner {
    int i_frame, row, col; // of sheen_calibration.frames; as in sheen_board_corner
    double q_px[2];        // as found in the picture
    double residual_px[2]; // where the solution puts it, minus q_px; 0 for an outlier
    bool outlier;
} sheen_calibration_corner;

// A lens model that was tried: its error (rms px per axis) on the half of the frames that it was not solved with.
typedef struct sheen_calibration_candidate {
    const char *name;
    double held_out_px; // NaN: it could not be solved
} sheen_calibration_candidate;

// A coverage cell's inliers: their mean residual, and its rms per axis.
typedef struct sheen_calibration_region {
    int n;
    double mean_px[2], rms_px;
} sheen_calibration_region;

typedef struct sheen_calibration {
    sheen_camera camera;
    int board_cols, board_rows; // squares of the board, and their side
    double square_m;
    size_t n_frames;
    sheen_calibration_frame *frames;   // in the order of the views
    int n_used, n_corners, n_outliers; // corners and outliers of used frames
    sheen_calibration_corner *corners; // of used frames, n_corners of them
    double rms_px;                     // per axis, over inliers
    double noise_px; // of one corner per axis: rms_px with the fitted parameters counted off
    int i_worst;     // used frame with the largest rms
    int cells[SHEEN_COVERAGE_ROWS][SHEEN_COVERAGE_COLS]; // inliers in each cell of the image
    sheen_calibration_region regions[SHEEN_COVERAGE_ROWS * SHEEN_COVERAGE_COLS];
    // Root of the mean over regions of n |mean|^2 / (2 noise^2): 1 where residuals are noise alone, more where a
    // region's lean to one side.
    double pattern;
    double coverage;   // share of those cells that hold a corner
    double warp_m[2];  // how far the board's middle stands out of its edges: along x, along y
    double distance_m; // median distance of the board
    double tilt_rad;   // largest angle between the board's normals of two frames
    // One camera from the even frames, one from the odd: how they differ at distance_m; NaN where they differ so
    // much that one looks where the other cannot. False with fewer than twice the smallest number of frames.
    bool has_halves;
    sheen_camera_difference halves;
    // That difference, over the part of the image where corners are, in units of what the uncertainty predicts for
    // it: about 1 where the prediction is right. NaN where it could not be had.
    double normalised_error;
    int n_candidates; // of --model auto; 0 otherwise
    sheen_calibration_candidate candidates[SHEEN_MAX_CANDIDATES];
    // One standard deviation of where a point at distance_m is projected, in the direction in which it is
    // largest, given the noise found in the corners: at the image's centre, and the largest over the middles of
    // the coverage cells. NaN where it could not be had.
    double sigma_centre_px, sigma_worst_px;
    double sigma_px[SHEEN_SIGMA_ROWS][SHEEN_SIGMA_COLS]; // the same over the middles of a finer grid
    double
        *lens_covariance; // [n_intrinsics][n_intrinsics] of camera.intrinsics, zero where the model holds one
    // The part of the image about its centre where that is at most SHEEN_VALID_SIGMA_PX: a closed outline in px.
    int n_region;
    double region_px[SHEEN_REGION_MAX][2];
    double valid_share; // of the image's area
    sheen_vignetting vignetting;
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
