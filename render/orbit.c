// SPDX-License-Identifier: Apache-2.0
// orbit.c - viewpoints about an object.
#include "render/orbit.h"

#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"

// Share of the smaller image side that the mesh's sphere fills.
static const double fill = 0.8;

// Distance at which a sphere's outline is a circle of fill * side: its half angle there is atan(r / f), and
// the sphere's is asin(radius / distance).
static double distance_for(const sheen_camera *cam, double radius_m)
{
    const double side_px = cam->width_px < cam->height_px ? cam->width_px : cam->height_px;
    const double f_px = fmin(cam->intrinsics[0], cam->intrinsics[1]);
    const double outline_px = fill * side_px / 2;
    return radius_m * hypot(1, f_px / outline_px);
}

// Rows: the picture's right, down and forward for a camera at this azimuth and elevation. Right is always
// horizontal, so straight above and below are no exceptions.
static void look(double R[3][3], double azimuth_rad, double elevation_rad)
{
    const double ca = cos(azimuth_rad), sa = sin(azimuth_rad), ce = cos(elevation_rad),
                 se = sin(elevation_rad);
    const double rows[3][3] = {{-sa, ca, 0}, {se * ca, se * sa, -ce}, {-ce * ca, -ce * sa, -se}};
    memcpy(R, rows, sizeof rows);
}

// The rotation by the shortest way that takes the forward axis to the unit direction v (v_z > -1).
static void shortest_turn(double R[3][3], const double v[3])
{
    const double k = 1 / (1 + v[2]);
    const double rows[3][3] = {{1 - k * v[0] * v[0], -k * v[0] * v[1], v[0]},
                               {-k * v[0] * v[1], 1 - k * v[1] * v[1], v[1]},
                               {-v[0], -v[1], v[2]}};
    memcpy(R, rows, sizeof rows);
}

sheen_status sheen_view_pose(double rt_cam_obj[6], const sheen_mesh *mesh, const double rt_world_obj[6],
                             const sheen_camera *cam, double azimuth_rad, double elevation_rad,
                             double distance_m, sheen_err *err)
{
    if (!isfinite(azimuth_rad) || !isfinite(elevation_rad) || !isfinite(distance_m) || distance_m < 0)
        return sheen_fail(err, SHEEN_EARG,
                          "a view wants a finite azimuth and elevation, and a distance that is not "
                          "negative");
    float centre_f[3], radius_m;
    sheen_mesh_sphere(mesh, centre_f, &radius_m);
    if (distance_m == 0)
        distance_m = distance_for(cam, (double)radius_m);

    sheen_Rt Rt_world_obj, Rt_look = {.t = {0, 0, distance_m}}, Rt_turn = {.t = {0, 0, 0}}, Rt_cam_obj;
    sheen_Rt_from_rt(&Rt_world_obj, rt_world_obj);
    const double centre_obj[3] = {(double)centre_f[0], (double)centre_f[1], (double)centre_f[2]};
    double centre_world[3], offset[3], v_cam[3];
    sheen_Rt_point(centre_world, &Rt_world_obj, centre_obj);
    look(Rt_look.R, azimuth_rad, elevation_rad);
    sheen_Rt_direction(offset, &Rt_look, centre_world);
    for (int k = 0; k < 3; k++)
        Rt_look.t[k] -= offset[k]; // the centre comes to (0, 0, distance)

    // The object stands in the middle of the picture, wherever the principal point is.
    const double middle_px[2] = {0.5 * (cam->width_px - 1), 0.5 * (cam->height_px - 1)};
    const sheen_status s = sheen_camera_unproject(cam, v_cam, middle_px, 1, err);
    if (s)
        return s;
    if (!(v_cam[2] > 0))
        return sheen_fail(err, SHEEN_EARG, "the lens model has no ray through the middle of the image");
    shortest_turn(Rt_turn.R, v_cam);
    sheen_Rt_compose(&Rt_cam_obj, &Rt_look, &Rt_world_obj);
    sheen_Rt_compose(&Rt_cam_obj, &Rt_turn, &Rt_cam_obj);
    sheen_rt_from_Rt(rt_cam_obj, &Rt_cam_obj);
    return SHEEN_OK;
}
