// SPDX-License-Identifier: Apache-2.0
// stages.h - how the answer of a stage is said, by its own command and by `sheen run`.
#ifndef SHEEN_CLI_STAGES_H
#define SHEEN_CLI_STAGES_H

#include "calib/calibrate.h"
#include "cli/cli.h"
#include "fit/evaluate_session.h"
#include "fit/fit_session.h"
#include "pose/pose_session.h"
#include "render/draw.h"
#include "render/model.h"

// Each says the result, and puts it into the open object cli->out.
void sheen_cli_say_calibration(sheen_cli *cli, const sheen_calibration *c);
void sheen_cli_say_poses(sheen_cli *cli, const sheen_pose_summary *p, const sheen_poses *poses);
// Warns where frames are by another camera or focus than the calibration's, or fit much worse than it did. rms_px: of
// the poses, median.
void sheen_cli_check_camera(sheen_cli *cli, const sheen_session *s, double rms_px);
// Warns where what the session says of what moved is not what its poses and its background say (the quality limit is missed then).
// *both: camera and object moved.
sheen_status sheen_cli_check_moved(sheen_cli *cli, const sheen_session *s, const sheen_poses *poses,
                                   bool *both, sheen_err *err);
void sheen_cli_say_fit(sheen_cli *cli, const sheen_fit_summary *f);
sheen_status sheen_cli_say_evaluation(sheen_cli *cli, const sheen_evaluation *e, sheen_err *err);

// ---- cmd_run.c

typedef struct sheen_cli_run_options {
    int n_threads; // 0: one a processor
    bool no_film;
    int film_size_px[2]; // 0 x 0: 640 wide
} sheen_cli_run_options;

// Every stage of the session at `path` that is missing or out of date, in order; each is a member of cli->out.
sheen_status sheen_cli_run_stages(sheen_cli *cli, const char *path, const sheen_cli_run_options *options,
                                  sheen_err *err);

// ---- view.c: drawing a session's model

// What every drawing of a session needs.
typedef struct sheen_cli_view {
    sheen_model model;
    sheen_camera camera; // the session's
    double rt_board_obj[6];
    sheen_drawing *drawing;
    sheen_draw_options options;
    bool lights_turn; // with an object that turned, as in the first photograph; else it turns under them
    double
        turn_lights_rad; // besides, about an axis through the board's origin, counter-clockwise from its tip
    double turn_axis_board[3]; // unit; its z unless asked otherwise
} sheen_cli_view;

// What a person may change about a model before it is drawn.
typedef struct sheen_cli_changes {
    double k_s_factor;    // highlights' strength; 1: as fitted
    double sigma_rad;     // roughness; 0: as fitted
    double tint_rgb[3];   // times the highlights' colour; 1 1 1: as fitted
    const char *panorama; // a picture file whose light replaces the model's; NULL: as fitted
    bool fill_holes;      // surface that no photograph saw takes its surroundings' colour
} sheen_cli_changes;

// Holes are marked magenta, the background is a dark grey.
sheen_status sheen_cli_view_open(sheen_cli_view *v, const sheen_session *s, sheen_err *err);
sheen_status sheen_cli_view_change(sheen_cli_view *v, const sheen_cli_changes *c, sheen_err *err);
void sheen_cli_view_close(sheen_cli_view *v);

// A pinhole of the session's camera's field of view (along the width) for pictures of this size; 0 x 0: its own.
sheen_status sheen_cli_view_pinhole(sheen_camera *out, const sheen_cli_view *v, const int size_px[2],
                                    sheen_err *err);
// From a pose about the board (its pose alone: _pose), or one given. `layers` are zeroed, or an earlier picture's.
sheen_status sheen_cli_view_pose(double rt_cam_obj[6], const sheen_cli_view *v, const sheen_camera *cam,
                                 const double look[3], sheen_err *err);
sheen_status sheen_cli_view_look(sheen_layers *layers, const sheen_cli_view *v, const sheen_camera *cam,
                                 const double look[3], sheen_err *err);
sheen_status sheen_cli_view_draw(sheen_layers *layers, const sheen_cli_view *v, const sheen_camera *cam,
                                 const double rt_cam_obj[6], sheen_err *err);

typedef struct sheen_cli_orbit {
    int size_px[2]; // 0 x 0: the camera's
    double elevation_deg, distance_m, duration_s;
    int frames_per_s;
    const char *layer;
} sheen_cli_orbit;

// Once about the object, as a film.
sheen_status sheen_cli_orbit_film(const sheen_cli_view *v, const char *path, const sheen_cli_orbit *o,
                                  const sheen_progress *progress, sheen_err *err);

// "diffuse", "specular", else the composite.
const sheen_image *sheen_cli_layer(const sheen_layers *l, const char *layer);

#endif
