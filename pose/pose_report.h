// SPDX-License-Identifier: Apache-2.0
// pose_report.h - the pose stage's report: one HTML page.
#ifndef SHEEN_POSE_POSE_REPORT_H
#define SHEEN_POSE_POSE_REPORT_H

#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

// Verdict, every frame with what its pose is worth, the cameras from above, reprojection errors, boards of a set, and
// the turntable where the object moved. EIO, EACCESS, ENOMEM.
sheen_status sheen_pose_report(const char *path, const sheen_session *s, const sheen_poses *poses,
                               sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
