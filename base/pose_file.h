// SPDX-License-Identifier: Apache-2.0
// pose_file.h - cameras and poses as other programs write them.
//
// Read here: transforms.json (NeRF tools: OpenGL camera axes x right, y up, z back; camera-to-world
// `transform_matrix` per frame; fl_x fl_y cx cy k1 k2 p1 p2 [k3 k4] w h at the top or per frame,
// or camera_angle_x), COLMAP text models (a folder with cameras.txt and images.txt; world-to-camera
// quaternion qw qx qy qz), and sheen's own poses.json. All are turned into sheen's convention:
// OpenCV camera axes, world-to-camera, (0,0) at the centre of the top-left pixel (both foreign
// formats put that point at (0.5, 0.5): cx and cy lose half a pixel).
#ifndef SHEEN_BASE_POSE_FILE_H
#define SHEEN_BASE_POSE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_view {
    char name[128];          // file name without folder and extension
    char file[512];          // as written in the file; "" where it names none
    double rt_cam_world[6];  // world: the frame in which the file states its poses
    int i_camera;            // index into cameras, or -1 where the file states none
    int width_px, height_px; // 0 where not stated
} sheen_view;

typedef struct sheen_pose_file {
    sheen_view *views;
    size_t n_views;
    sheen_camera *cameras;
    size_t n_cameras;
} sheen_pose_file;

// A file, or a folder that holds cameras.txt and images.txt. EFORMAT for anything not finite, not a
// rotation, without frames, or naming one frame twice; EUNSUP for a lens model that mrcal has not.
sheen_status sheen_pose_file_load(sheen_pose_file *out, const char *path, sheen_err *err);
void sheen_pose_file_release(sheen_pose_file *p);

// From memory, one format each.
sheen_status sheen_transforms_parse(sheen_pose_file *out, const void *data, size_t size_bytes,
                                    sheen_err *err);
sheen_status sheen_colmap_parse(sheen_pose_file *out, const void *cameras_txt, size_t cameras_bytes,
                                const void *images_txt, size_t images_bytes, sheen_err *err);
// "schema": "sheen-poses/1": per frame "name" and "rt_cam_board" (frames without a pose are left out).
sheen_status sheen_poses_json_parse(sheen_pose_file *out, const void *data, size_t size_bytes,
                                    sheen_err *err);

// A camera alone, told by its content: .cameramodel; OpenCV's or ROS's calibration yaml
// (camera_matrix, distortion_coefficients / dist_coeffs of 0, 4, 5, 8 or 12; image_width/height or
// image_size); COLMAP cameras.txt with one camera; transforms.json. Where the file states no size,
// width_px and height_px (> 0) are taken.
sheen_status sheen_camera_load_any(sheen_camera *cam, const char *path, int width_px, int height_px,
                                   sheen_err *err);
sheen_status sheen_opencv_yaml_parse(sheen_camera *cam, const void *data, size_t size_bytes, int width_px,
                                     int height_px, sheen_err *err);
// COLMAP's cameras.txt alone; *n_cameras of them, caller frees.
sheen_status sheen_colmap_cameras_parse(sheen_camera **cameras_out, int **ids_out, size_t *n_cameras,
                                        const void *data, size_t size_bytes, sheen_err *err);

// Whether a file of that kind has a place for the camera's lens.
bool sheen_transforms_holds(const sheen_camera *cam);
bool sheen_colmap_holds(const sheen_camera *cam);

// Writes transforms.json (for exports and for tests): one camera, n views.
sheen_status sheen_transforms_save(const char *path, const sheen_camera *cam, const sheen_view *views,
                                   size_t n_views, sheen_err *err);
// Writes a COLMAP text model into a folder, which is made: one camera (PINHOLE, OPENCV or FULL_OPENCV), n views by their
// `file`, and points (p_world [n][3], rgb [n][3] in sRGB) without tracks. EUNSUP: another lens model.
sheen_status sheen_colmap_save(const char *dir, const sheen_camera *cam, const sheen_view *views,
                               size_t n_views, const float *p_world, const uint8_t *rgb, size_t n_points,
                               sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
