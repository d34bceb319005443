// SPDX-License-Identifier: Apache-2.0
// export_first_view.c - from where an exported object is looked at first: the photograph's side that shines most.
//
// The object is drawn small from the azimuth and elevation of each photograph (of at most MOST of them, evenly chosen),
// and the specular layer with the largest variance wins: a few bright highlights rather than an even gloss.
#include <math.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "cli/export.h"

enum { MOST = 12, WIDTH_PX = 160, HEIGHT_PX = 120 };
static const double deg_per_rad = 180 / 3.14159265358979323846;

// Direction from the object's middle to the camera, about the board's z.
static void direction_of(double look_deg[2], const sheen_cli_view *v, const sheen_frame_pose *pose)
{
    float centre_f[3], radius_m;
    sheen_Rt board_obj, cam_board, board_cam;
    double middle[3];
    sheen_mesh_sphere(&v->model.mesh, centre_f, &radius_m);
    const double centre[3] = {(double)centre_f[0], (double)centre_f[1], (double)centre_f[2]};
    sheen_Rt_from_rt(&board_obj, v->rt_board_obj);
    sheen_Rt_from_rt(&cam_board, pose->rt_cam_board);
    sheen_Rt_invert(&board_cam, &cam_board);
    sheen_Rt_point(middle, &board_obj, centre);
    const double d[3] = {board_cam.t[0] - middle[0], board_cam.t[1] - middle[1], board_cam.t[2] - middle[2]};
    look_deg[0] = atan2(d[1], d[0]) * deg_per_rad;
    look_deg[1] = atan2(d[2], hypot(d[0], d[1])) * deg_per_rad;
}

static sheen_status contrast_of(double *contrast, const sheen_cli_view *v, const double look_deg[2],
                                sheen_err *err)
{
    sheen_camera cam;
    sheen_layers layers = {0};
    const double look[3] = {look_deg[0], look_deg[1], 0};
    const int size_px[2] = {WIDTH_PX, HEIGHT_PX};
    sheen_status s = sheen_cli_view_pinhole(&cam, v, size_px, err);
    if (!s)
        s = sheen_cli_view_look(&layers, v, &cam, look, err);
    if (s) {
        sheen_layers_release(&layers);
        return s;
    }
    double sum = 0, sum2 = 0, n = 0;
    for (size_t i = 0; i < (size_t)WIDTH_PX * HEIGHT_PX; i++) {
        if (!(layers.coverage.data[i] > 0.5f))
            continue;
        const double y = fmin(1, (double)sheen_luminance(layers.specular.data + 3 * i));
        sum += y;
        sum2 += y * y;
        n++;
    }
    *contrast = n > 0 ? sum2 / n - (sum / n) * (sum / n) : 0;
    sheen_layers_release(&layers);
    return SHEEN_OK;
}

sheen_status sheen_export_first_view(double look_deg[2], const sheen_cli_view *v, const sheen_session *s,
                                     sheen_err *err)
{
    sheen_poses poses;
    double best = -1;
    look_deg[0] = 30;
    look_deg[1] = 25;
    sheen_status st = sheen_poses_load(&poses, s, err);
    if (st)
        return st;
    const sheen_frame_pose *inputs[MOST];
    size_t n = 0, n_inputs = 0;
    for (int round = 0; round < 2; round++) { // first counted, then chosen
        size_t i_input = 0;
        for (size_t i = 0; i < poses.n_poses; i++) {
            const sheen_frame_info *f = sheen_session_find(s, poses.poses[i].name);
            if (!f || f->role != SHEEN_ROLE_INPUT)
                continue;
            if (round && n < MOST && i_input * MOST >= n * n_inputs)
                inputs[n++] = &poses.poses[i];
            i_input++;
        }
        n_inputs = i_input;
    }
    for (size_t i = 0; !st && i < n; i++) {
        double look[2], contrast;
        direction_of(look, v, inputs[i]);
        if (!isfinite(look[0]) || !isfinite(look[1]))
            continue;
        st = contrast_of(&contrast, v, look, err);
        if (!st && contrast > best) {
            best = contrast;
            look_deg[0] = look[0];
            look_deg[1] = look[1];
        }
    }
    sheen_poses_release(&poses);
    return st;
}
