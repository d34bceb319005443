// SPDX-License-Identifier: Apache-2.0
// session.h - a session is a folder; this is the one place that knows what is where in it.
//
// docs/session-format.md is the specification. Every write is atomic, nothing states that a stage
// is running: what is done is read from the files.
#ifndef SHEEN_BASE_SESSION_H
#define SHEEN_BASE_SESSION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/camera.h"
#include "base/file.h"
#include "base/image.h"
#include "base/json.h"
#include "base/pixel_format.h"

#ifdef __cplusplus
extern "C" {
#endif

// Files of a session, relative to it.
#define SHEEN_SESSION_MANIFEST "session.json"
#define SHEEN_SESSION_FRAMES "frames"
#define SHEEN_SESSION_MASKS "masks" // <frame name>.png; white: object
#define SHEEN_SESSION_HIGHLIGHTS                                                                             \
    "highlights" // <frame name>.png; white: known to be a highlight (sessions with known truth)
#define SHEEN_SESSION_CAMERA "camera.cameramodel"
#define SHEEN_SESSION_CALIBRATION "calibration.json"
#define SHEEN_SESSION_BOARD "board.json"
#define SHEEN_SESSION_CALIBRATION_BOARD "calibration-board.json" // for calibration frames, where it differs
#define SHEEN_SESSION_DETECTIONS "detections"                    // .vnl
#define SHEEN_SESSION_POSES "poses.json"
#define SHEEN_SESSION_REGISTRATION "registration.json" // rt_board_obj
#define SHEEN_SESSION_MESH "mesh"                      // mesh.ply, .obj or .glb
#define SHEEN_SESSION_MODEL "model"
#define SHEEN_SESSION_EVALUATION "evaluation"
#define SHEEN_SESSION_RENDERS "renders"

// What a frame is for.
typedef enum sheen_role {
    SHEEN_ROLE_INPUT,       // the object; fitted
    SHEEN_ROLE_CALIBRATION, // the board alone; calibrated from
    SHEEN_ROLE_TEST,        // the object; held out, for eval only
    SHEEN_ROLE_BACKGROUND, // the scene without the object, from where the camera stood; masks are made with it
    SHEEN_ROLE_COUNT
} sheen_role;

// Frames that show the object.
static inline bool sheen_role_shows_object(sheen_role r)
{
    return r == SHEEN_ROLE_INPUT || r == SHEEN_ROLE_TEST;
}

const char *sheen_role_name(sheen_role r); // "input", "calibration", "test", "background"
sheen_status sheen_role_from_name(sheen_role *out, const char *name, sheen_err *err);

// What stood still under the lights: see "world" in docs/conventions.md.
typedef enum sheen_moving { SHEEN_MOVING_CAMERA, SHEEN_MOVING_OBJECT } sheen_moving;

const char *sheen_moving_name(sheen_moving m); // "camera", "object"
sheen_status sheen_moving_from_name(sheen_moving *out, const char *name, sheen_err *err);

// A setting of the camera as it was read back with a frame: V4L2's number of the control, and its value.
typedef struct sheen_frame_control {
    uint32_t id;
    int32_t value;
} sheen_frame_control;

enum { SHEEN_FRAME_MAX_CONTROLS = 40 };

// Whether the camera's automatics were off and its settings those of the session, as read back with the frame.
typedef enum sheen_lock {
    SHEEN_LOCK_UNKNOWN, // not a frame of a camera that we ran
    SHEEN_LOCK_OFF,     // recorded without a lock, as asked for
    SHEEN_LOCK_HELD
} sheen_lock;

// What the software that drives a camera (libcamera) says of one frame. 0: not said.
typedef struct sheen_frame_pipeline {
    double exposure_us, analogue_gain, digital_gain;
    double red_gain, blue_gain; // white balance, relative to green
    double black_levels[4];     // of a mosaic's channels, of 65535
} sheen_frame_pipeline;

// What a frame that was put together from several exposures tells of itself.
enum { SHEEN_BRACKET_MAX = 9 };
typedef struct sheen_frame_bracket {
    int n_exposures; // 0: the frame is of one exposure
    double exposure_s[SHEEN_BRACKET_MAX];
    double noise[2]; // variance of one exposure's linear value x: noise[0] + noise[1] x, full scale 1
    double residual; // how far the exposures disagree, relative, rms: the error of the curve that was assumed
} sheen_frame_bracket;

// One frame's sidecar, frames/<name>.json.
typedef struct sheen_frame_info {
    char name[64]; // unique in the session; [A-Za-z0-9._-], not beginning with a dot
    char file[80]; // payload's file name in frames/
    sheen_role role;
    int width_px, height_px;
    uint32_t fourcc;  // V4L2's code of a raw payload; 0 where the file is a picture file
    int stride_bytes; // of a raw payload; 0 otherwise
    sheen_transfer transfer;
    int64_t t_ns;     // device time at start of exposure, CLOCK_MONOTONIC; -1 unknown
    int64_t sequence; // driver's counter; -1 unknown
    double table_asked_deg, table_measured_deg; // NaN: no turntable
    char payload_digest[33];                    // XXH3-128
    char source[256];                           // where it came from: device URI or file name
    char device[128];                           // camera, as it names itself, and its place; "": unknown
    sheen_colorimetry color;                    // of a camera's frame, as the driver reports it
    sheen_lock lock;
    int n_controls;
    sheen_frame_control controls[SHEEN_FRAME_MAX_CONTROLS];
    sheen_frame_pipeline pipeline;
    sheen_frame_bracket bracket;
} sheen_frame_info;

// Fills in "unknown" everywhere.
void sheen_frame_info_init(sheen_frame_info *f);
// A sidecar from memory; f->name is left as it is. Every member is checked. EFORMAT.
sheen_status sheen_frame_info_parse(sheen_frame_info *f, const void *data, size_t size_bytes, sheen_err *err);
// The camera of a frame and its focus, as sheen_camera.taken_by has it; "" where the frame does not say. Where the
// camera is plugged in does not count.
void sheen_frame_taken_by(char out[160], const sheen_frame_info *f);
// True for a name that a frame may have: 1 to 60 of [A-Za-z0-9._-], not beginning with a dot.
bool sheen_frame_name_ok(const char *name);

typedef struct sheen_session {
    char path[SHEEN_PATH_MAX];
    sheen_moving moving;
    char created[32];         // ISO 8601, UTC
    sheen_frame_info *frames; // sorted by name
    size_t n_frames;
} sheen_session;

// Opens an existing session. Frames whose payload or sidecar is missing (a cut during writing)
// are not listed. EIO, EFORMAT; the sentence says what to do.
sheen_status sheen_session_open(sheen_session *s, const char *path, sheen_err *err);
// Opens it to add to it, or makes an empty one where the path does not exist or is an empty folder. Temporary files
// that a power cut left in it are swept out. EARG for a folder that holds other things.
sheen_status sheen_session_create(sheen_session *s, const char *path, sheen_moving moving, sheen_err *err);
void sheen_session_release(sheen_session *s);
// Writes the manifest (after `moving` has changed).
sheen_status sheen_session_save(const sheen_session *s, sheen_err *err);

// Path of a file in the session.
sheen_status sheen_session_path(char out[SHEEN_PATH_MAX], const sheen_session *s, const char *file,
                                sheen_err *err);
bool sheen_session_has(const sheen_session *s, const char *file);
// The mesh's file name in the session ("mesh.ply"), or NULL where there is none.
const char *sheen_session_mesh_file(const sheen_session *s);

// Which of a turntable's rounds a frame is of: one that its recording took is called "r<round>-..." (capture/turn_steps.h).
// 0: none.
int sheen_frame_round(const sheen_frame_info *f);

// Adds a frame: payload first, then its sidecar, each atomically; both or neither count. info->file,
// payload_digest are set here from info->name and `extension`. The list in *s grows by one.
// EARG: bad or taken name.
sheen_status sheen_session_add_frame(sheen_session *s, sheen_frame_info *info, const char *extension,
                                     const void *payload, size_t size_bytes, sheen_err *err);
// The two halves of sheen_session_add_frame, for a writer in a thread of its own. The first looks at nothing of *s but
// its path and writes files only (the caller has seen to it that the name is free); the second makes the list grow.
sheen_status sheen_session_write_frame(const sheen_session *s, sheen_frame_info *info, const char *extension,
                                       const void *payload, size_t size_bytes, sheen_err *err);
sheen_status sheen_session_enter_frame(sheen_session *s, const sheen_frame_info *info, sheen_err *err);
// Writes a mask of a frame: <folder>/<name>.png, bytes as given. folder: SHEEN_SESSION_MASKS or _HIGHLIGHTS.
sheen_status sheen_session_add_mask(const sheen_session *s, const char *folder, const char *name,
                                    const void *png, size_t size_bytes, sheen_err *err);
// A name that is free: "000000", "000001", ...
void sheen_session_next_name(const sheen_session *s, char name[64]);
const sheen_frame_info *sheen_session_find(const sheen_session *s, const char *name);
size_t sheen_session_count_role(const sheen_session *s, sheen_role role);

// The payload as stored (caller frees), and decoded. EFORMAT where it is not what was recorded (digest, size);
// EUNSUP for raw payloads that this build cannot develop.
sheen_status sheen_session_payload(uint8_t **data_out, size_t *size_bytes, const sheen_session *s,
                                   const sheen_frame_info *f, sheen_err *err);
sheen_status sheen_session_raster(sheen_raster *out, const sheen_session *s, const sheen_frame_info *f,
                                  sheen_err *err);
// Its brightness as the eye divides it, 0..1, one channel.
sheen_status sheen_session_grey(sheen_image *out, const sheen_session *s, const sheen_frame_info *f,
                                sheen_err *err);
// RGB, linear light, by what the session knows of its camera (radiometry.h). EDATA where that is of other settings.
sheen_status sheen_session_image(sheen_image *out, const sheen_session *s, const sheen_frame_info *f,
                                 sheen_err *err);
// The object's mask of this frame, one channel 0..1; an empty image (data NULL) where there is none.
sheen_status sheen_session_mask(sheen_image *out, const sheen_session *s, const sheen_frame_info *f,
                                sheen_err *err);

// Files that enter a session together: all of them or, after a power cut at any moment, none.
// sheen_session_stage makes *staged an empty folder inside s; frames are added to it, and files written into it
// (sheen_session_path), as if it were the session. Then exactly one of:
// sheen_session_commit moves everything into s, replacing files of the same name, and reads its frames anew (a
// new mesh also replaces one of another type). From its first step on the commit is certain: sheen_session_open
// completes one that was interrupted. sheen_session_unstage throws everything away. Both release *staged.
sheen_status sheen_session_stage(sheen_session *staged, const sheen_session *s, sheen_err *err);
sheen_status sheen_session_commit(sheen_session *s, sheen_session *staged, sheen_err *err);
void sheen_session_unstage(sheen_session *staged);

// A mask picture from memory, one channel 0..1 of width_px x height_px; EFORMAT where its size differs.
sheen_status sheen_mask_parse(sheen_image *out, const void *data, size_t size_bytes, int width_px,
                              int height_px, sheen_err *err);

// A frame's pose from poses.json.
typedef struct sheen_frame_pose {
    char name[64];
    bool found; // false: no pose could be had; `reason` says why
    double rt_cam_board[6];
    double covariance[36]; // of rt_cam_board, row-major; zero where poses were imported
    double rms_px;         // per axis, of the inliers; NaN where imported
    int n_points, n_outliers;
    char reason[160];
} sheen_frame_pose;

// Where one of several boards is, in the frame of the first.
typedef struct sheen_board_place {
    char name[32];
    bool found;             // false: nothing ties it to the first; `reason` says so
    double rt_ref_board[6]; // from this board's frame to the first one's
    double covariance[36];  // of it; zero for the first
    int n_frames, n_moved;  // frames in which it counts, and in which it stands elsewhere
    char reason[160];       // what is to be said of it
} sheen_board_place;

typedef struct sheen_poses {
    sheen_frame_pose *poses;
    size_t n_poses;
    sheen_board_place *boards; // of a set; none for a single board
    size_t n_boards;
    bool imported; // given by the person rather than measured from boards
} sheen_poses;

sheen_status sheen_poses_load(sheen_poses *out, const sheen_session *s, sheen_err *err);
sheen_status sheen_poses_parse(sheen_poses *out, const void *data, size_t size_bytes, sheen_err *err);
// Poses that were measured are stamped with sheen_poses_inputs, what they were made from.
sheen_status sheen_poses_save(const sheen_poses *p, const sheen_session *s, sheen_err *err);
extern const char *const sheen_poses_inputs[];
void sheen_poses_release(sheen_poses *p);
const sheen_frame_pose *sheen_poses_find(const sheen_poses *p, const char *name);

// rt_board_obj of registration.json; the identity where the session has none (the mesh is in the
// board's frame).
sheen_status sheen_registration_load(double rt_board_obj[6], const sheen_session *s, sheen_err *err);
sheen_status sheen_registration_save(const double rt_board_obj[6], const sheen_session *s, sheen_err *err);

// Stamps: what a stage was made from. A stage writes the digests of its inputs into its result as
//     "inputs": {"camera.cameramodel": "<digest>", "frames": "<digest of all payload digests of a role>"}
// and is out of date when one differs. `files` ends with NULL; "frames:<role>" stands for the frames of a role,
// with their masks, "highlights:<role>" for their highlights. A file that is missing is "".
struct sheen_json_writer;
sheen_status sheen_stamp_write(struct sheen_json_writer *w, const sheen_session *s, const char *const *files,
                               sheen_err *err);
// True where the result's stamp names exactly these files with the digests that they have now.
bool sheen_stamp_is_current(const sheen_json *result, const sheen_session *s, const char *const *files);

#ifdef __cplusplus
}
#endif
#endif
