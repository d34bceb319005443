// SPDX-License-Identifier: Apache-2.0
// calibrate_session.h - the calibration stage: from a session's frames, or from image files, to a camera.
#ifndef SHEEN_CALIB_CALIBRATE_SESSION_H
#define SHEEN_CALIB_CALIBRATE_SESSION_H

#include <stdbool.h>
#include <stddef.h>

#include "base/session.h"
#include "calib/calibrate.h"

#ifdef __cplusplus
extern "C" {
#endif

// Calibrates from the session's calibration frames, with calibration-board.json where there is one and board.json
// otherwise; from its input frames and board.json where it has no calibration frames. Writes
// detections/calibration.vnl, camera.cameramodel and, last, calibration.json. On failure the session is left as it
// was; EDATA where the frames do not do. Release *out after success.
sheen_status sheen_calibrate_session(sheen_calibration *out, const sheen_session *s,
                                     const sheen_calibrate_options *options, sheen_err *err);
// True where calibration.json was made from the frames and boards that the session has now.
bool sheen_calibration_is_current(const sheen_session *s);
// What it is made from, for stamps (session.h): a role's frames, a board, NULL. Names of constant storage.
void sheen_calibration_inputs(const char *inputs[3], const sheen_session *s);

// The same from image files (sRGB); nothing is written.
sheen_status sheen_calibrate_files(sheen_calibration *out, const char *const *paths, size_t n_paths,
                                   const char *board_path, const sheen_calibrate_options *options,
                                   sheen_err *err);

// The same from a table of corners (vnl.h) of pictures of size_px[2].
sheen_status sheen_calibrate_table(sheen_calibration *out, const char *vnl_path, const int size_px[2],
                                   const char *board_path, const sheen_calibrate_options *options,
                                   sheen_err *err);

// camera.cameramodel with all digits, the valid region, and all that mrcal's tools need to show its uncertainty and
// residuals. EIO, ENOMEM.
sheen_status sheen_calibration_save_camera(const sheen_calibration *c, const char *path, sheen_err *err);

// calibration.json, schema "sheen-calibration/1"; with s (may be NULL) also the digests of what it was made from.
sheen_status sheen_calibration_save(const sheen_calibration *c, const sheen_session *s, const char *path,
                                    sheen_err *err);

// All its figures, into an open object.
struct sheen_json_writer;
void sheen_calibration_write(struct sheen_json_writer *w, const sheen_calibration *c);

#ifdef __cplusplus
}
#endif
#endif
