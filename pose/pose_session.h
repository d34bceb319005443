// SPDX-License-Identifier: Apache-2.0
// pose_session.h - the pose stage: poses.json for a session's input and test frames.
#ifndef SHEEN_POSE_POSE_SESSION_H
#define SHEEN_POSE_POSE_SESSION_H

#include <stdbool.h>

#include "base/progress.h"
#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_pose_options {
    sheen_progress progress;
    int n_threads; // 0: one per processor
    bool force;    // measure anew where poses were imported
} sheen_pose_options;

typedef struct sheen_pose_summary {
    bool left_alone; // the session's poses were imported: nothing was done
    int n_frames, n_found, n_from_tags;
    double rms_median_px;                 // over frames with a pose; NaN where left alone
    double sigma_median_m, sigma_worst_m; // one standard deviation of the translation, its largest axis
    int n_blurred; // frames left out because they fit far worse than the others: something moved during exposure
    bool alike;    // two frames or more, and all from the same place: nothing is gained by them
} sheen_pose_summary;

// Finds the board in every input and test frame and writes detections/board.vnl and poses.json. Frames without a
// pose are in poses.json with the reason. Several boards (board.json with a list) are surveyed together: poses are then
// in the frame of the first. EDATA: no frame has a pose, or frames and camera.cameramodel differ in
// size; EIO, EFORMAT; the session is then left as it was. `poses_out` (may be NULL) receives the poses; release it.
sheen_status sheen_pose_session(sheen_pose_summary *out, sheen_poses *poses_out, const sheen_session *s,
                                const sheen_pose_options *options, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
