// SPDX-License-Identifier: Apache-2.0
// view_sphere.c - directions of view by a homography from the board's plane, and holes in the ring about the board.
//
// The camera's centre is that of the pose which the homography implies; its direction from the
// middle of the tags is what counts. Views from within some degrees of the zenith have no side and close no hole.
#include "calib/view_sphere.h"

#include <math.h>
#include <stdlib.h>

#include "calib/homography.h"

enum { MAX_POINTS = 1024 };
static const double pi = 3.14159265358979323846, zenith_cos = 0.9848; // 10 degrees

static bool bearings(double *q, const sheen_camera *camera, int width_px, int height_px, const double *q_px,
                     size_t n)
{
    if (!camera) {
        for (size_t i = 0; i < n; i++) {
            q[2 * i] = (q_px[2 * i] - 0.5 * (width_px - 1)) / width_px;
            q[2 * i + 1] = (q_px[2 * i + 1] - 0.5 * (height_px - 1)) / width_px;
        }
        return true;
    }
    double v_cam[3 * MAX_POINTS];
    if (sheen_camera_unproject(camera, v_cam, q_px, n, NULL))
        return false;
    for (size_t i = 0; i < n; i++) {
        q[2 * i] = v_cam[3 * i] / v_cam[3 * i + 2];
        q[2 * i + 1] = v_cam[3 * i + 1] / v_cam[3 * i + 2];
    }
    return true;
}

bool sheen_view_direction(double v_board[3], const sheen_camera *camera, int width_px, int height_px,
                          const sheen_tag_seen *tags, size_t n_tags)
{
    double xy[2 * MAX_POINTS], q_px[2 * MAX_POINTS], q[2 * MAX_POINTS], H[9], middle[2] = {0, 0};
    size_t n = 0;
    sheen_Rt Rt_cam_board;
    for (size_t i = 0; i < n_tags && n + 4 <= MAX_POINTS; i++)
        for (int k = 0; k < 4 && !tags[i].i_board; k++, n++)
            for (int j = 0; j < 2; j++) {
                xy[2 * n + (size_t)j] = tags[i].p_board[k][j];
                q_px[2 * n + (size_t)j] = tags[i].q_px[k][j];
                middle[j] += tags[i].p_board[k][j];
            }
    if (!n || !bearings(q, camera, width_px, height_px, q_px, n) || !sheen_homography_fit(H, xy, q, n))
        return false;
    middle[0] /= (double)n;
    middle[1] /= (double)n;
    if (!sheen_homography_pose(&Rt_cam_board, H, middle))
        return false;
    sheen_Rt Rt_board_cam;
    sheen_Rt_invert(&Rt_board_cam, &Rt_cam_board);
    double length = 0;
    for (int j = 0; j < 3; j++) {
        v_board[j] = Rt_board_cam.t[j] - (j < 2 ? middle[j] : 0);
        length += v_board[j] * v_board[j];
    }
    for (int j = 0; j < 3; j++)
        v_board[j] /= sqrt(length);
    return isfinite(v_board[0] + v_board[1] + v_board[2]);
}

double sheen_view_sphere_nearest_rad(const sheen_view_sphere *s, const double v_board[3])
{
    double most = -1;
    for (size_t i = 0; i < s->n_views; i++) {
        const double *v = s->v_board[i];
        most = fmax(most, v[0] * v_board[0] + v[1] * v_board[1] + v[2] * v_board[2]);
    }
    return acos(fmin(most, 1));
}

void sheen_view_sphere_add(sheen_view_sphere *s, const double v_board[3])
{
    if (s->n_views == SHEEN_VIEW_SPHERE_MAX)
        return;
    for (int j = 0; j < 3; j++)
        s->v_board[s->n_views][j] = v_board[j];
    s->n_views++;
}

typedef struct sided {
    double azimuth_rad, z;
} sided;

static int compare(const void *a, const void *b)
{
    const double x = ((const sided *)a)->azimuth_rad, y = ((const sided *)b)->azimuth_rad;
    return (x > y) - (x < y);
}

double sheen_view_sphere_hole_rad(const sheen_view_sphere *s, double *middle_rad)
{
    sided views[SHEEN_VIEW_SPHERE_MAX + 1];
    double first = 0, largest = -1;
    size_t n = 0;
    for (size_t i = 0; i < s->n_views; i++)
        if (s->v_board[i][2] <= zenith_cos) {
            views[n] = (sided){atan2(s->v_board[i][1], s->v_board[i][0]), s->v_board[i][2]};
            first = n++ ? first : views[0].azimuth_rad;
        }
    *middle_rad = n ? pi : 0; // behind; where there is nothing at all, begin in front
    if (n < 2)
        return pi;
    qsort(views, n, sizeof *views, compare);
    views[n] = (sided){views[0].azimuth_rad + 2 * pi, views[0].z};
    for (size_t i = 0; i < n; i++) {
        const double middle = 0.5 * (views[i].azimuth_rad + views[i + 1].azimuth_rad);
        const double z = 0.5 * (views[i].z + views[i + 1].z), flat = sqrt(1 - z * z);
        const double v_board[3] = {flat * cos(middle), flat * sin(middle), z};
        const double hole = sheen_view_sphere_nearest_rad(s, v_board);
        if (hole > largest) {
            largest = hole;
            *middle_rad = remainder(middle - first, 2 * pi);
        }
    }
    return largest;
}

const char *sheen_view_side(double angle_rad)
{
    static const char *const sides[] = {"the front", "the front right",    "the right", "behind on the right",
                                        "behind",    "behind on the left", "the left",  "the front left"};
    const int eighth = (int)floor(angle_rad / (0.25 * pi) + 0.5);
    return sides[(eighth % 8 + 8) % 8];
}
