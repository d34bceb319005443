// SPDX-License-Identifier: Apache-2.0
// import.h - files that were made elsewhere into a session: photographs, camera, poses, mesh, masks, boards.
#ifndef SHEEN_CAPTURE_IMPORT_H
#define SHEEN_CAPTURE_IMPORT_H

#include "base/progress.h"
#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

// What to import; what is NULL is not asked for.
typedef struct sheen_import_options {
    const char *const *images; // PNG, JPEG, TIFF, EXR files, and folders of them
    size_t n_images;
    sheen_role role;
    bool set_transfer; // else: sRGB, but linear for pictures of floats
    sheen_transfer transfer;
    const char *camera;         // anything that sheen_camera_load_any reads
    const char *poses;          // anything that sheen_pose_file_load reads; its world is the board's frame
    const char *mesh;           // .ply, .obj, .glb; in the board's frame until it is registered
    const double *rt_board_obj; // of the mesh, 6 numbers; NULL with a new mesh: the identity
    const char *masks;          // folder of <frame name>.png
    const char *highlights;     // folder of <frame name>.png
    const char *board;          // board.json
    const char
        *calibration_board; // board.json of the board in the calibration frames, where it is another one
    bool set_moving;
    sheen_moving moving;
    sheen_progress progress;
} sheen_import_options;

typedef struct sheen_import_report {
    size_t n_frames;  // new frames
    size_t n_present; // pictures that the session had already
    size_t n_masks, n_highlights;
    size_t n_poses;         // frames that got a pose
    size_t n_unposed;       // input and test frames without one
    bool camera_from_poses; // the pose file brought the camera
} sheen_import_report;

// All or nothing: every file is read and checked (pictures are decoded whole), and only then does anything enter the
// session. A picture whose name and content the session has is skipped. Importing a camera, poses or a mesh replaces
// those that were there; a new mesh is taken to be in the board's frame.
// EIO, EACCESS, EFORMAT (damaged, cut short, not finite, of a size that does not fit), EARG (a name is taken by
// another picture; a file of an unknown kind), EDATA (no pose or mask belongs to a frame), ECANCEL, ENOMEM.
sheen_status sheen_import(sheen_session *session, const sheen_import_options *options,
                          sheen_import_report *report, sheen_err *err);

// A frame's name from a file's: without folder and ending, with '_' for what a name may not hold. EARG where it is
// longer than a name may be.
sheen_status sheen_import_name(char name[64], const char *path, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
