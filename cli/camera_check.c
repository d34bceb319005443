// SPDX-License-Identifier: Apache-2.0
// camera_check.c - is the session's camera still the one that was calibrated.
#include <math.h>
#include <string.h>

#include "base/json.h"
#include "cli/stages.h"

static const double GROWN = 3,
                    GROWN_FLOOR_PX = 0.15; // times the calibration's error, and at least so much more

static void check_owner(sheen_cli *cli, const sheen_session *s, const sheen_camera *camera)
{
    for (size_t i = 0; i < s->n_frames && camera->taken_by[0]; i++) {
        char by[160];
        sheen_frame_taken_by(by, &s->frames[i]);
        if (!by[0] || !strcmp(by, camera->taken_by))
            continue;
        sheen_cli_warn(cli, "the camera was calibrated as '%s' but frame '%s' is by '%s': calibrate that",
                       camera->taken_by, s->frames[i].name, by);
        return;
    }
}

static void check_residuals(sheen_cli *cli, const sheen_session *s, double rms_px)
{
    char path[SHEEN_PATH_MAX];
    sheen_json *root;
    double calibrated_px;
    if (sheen_session_path(path, s, SHEEN_SESSION_CALIBRATION, NULL) || sheen_json_load(&root, path, NULL))
        return;
    if (!sheen_json_number(root, "rms_px", &calibrated_px, NULL) && rms_px > GROWN * calibrated_px &&
        rms_px > calibrated_px + GROWN_FLOOR_PX)
        sheen_cli_warn(
            cli,
            "corners fit to %.2f px, %.1f times worse than when the camera was calibrated: was its focus, "
            "its zoom or the board changed? Calibrate again",
            rms_px, rms_px / calibrated_px);
    sheen_json_free(&root);
}

void sheen_cli_check_camera(sheen_cli *cli, const sheen_session *s, double rms_px)
{
    char path[SHEEN_PATH_MAX];
    sheen_camera camera;
    if (sheen_session_path(path, s, SHEEN_SESSION_CAMERA, NULL) || sheen_camera_load(&camera, path, NULL))
        return;
    check_owner(cli, s, &camera);
    check_residuals(cli, s, rms_px);
}
