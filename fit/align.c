// SPDX-License-Identifier: Apache-2.0
// align.c - gains, then poses, coarse to fine; each kept where the points left out agree better with it.
//
// Pictures are sampled through a Gaussian about each point, wide at first (so that a pose some pixels off still finds its
// way) and narrow in the end.
#include "fit/align.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "calib/cholesky.h"
#include "fit/align_state.h"

enum { LEAST_POINTS = 300 };

static const double spacing_px[3] = {1.6, 0.8, 0.45}; // of the Gaussian's taps, coarse to fine
static const int rounds[3] = {5, 4, 5};
static const size_t strides[3] = {4, 4, 1}; // a part of the points finds the way; all of them the end of it

// Robust scale on the points that were left out, finely sampled.
static sheen_status left_out(sheen_align_state *st, double *error, sheen_err *err)
{
    st->spacing_px = spacing_px[2];
    st->stride = strides[2];
    const sheen_status s = sheen_align_observe(st, err);
    if (s)
        return s;
    sheen_align_measure(st);
    st->parity = 1;
    *error = sheen_align_settle(st);
    st->parity = 0;
    return SHEEN_OK;
}

static sheen_status refine_gains(sheen_align_state *st, int level, int turns, sheen_err *err)
{
    st->spacing_px = spacing_px[level];
    st->stride = strides[level];
    sheen_status s = sheen_align_observe(st, err);
    for (int i = 0; i < turns && !s; i++) {
        sheen_align_measure(st);
        s = sheen_align_solve_gains(st, err);
    }
    return s;
}

static sheen_status refine_poses(sheen_align_state *st, int with_gains, sheen_err *err)
{
    for (int level = 0; level < 3; level++)
        for (int i = 0; i < rounds[level]; i++) {
            double step_px;
            st->spacing_px = spacing_px[level];
            st->stride = strides[level];
            sheen_status s = sheen_align_observe(st, err);
            if (s)
                return s;
            sheen_align_measure(st);
            if (with_gains) {
                if ((s = sheen_align_solve_gains(st, err)))
                    return s;
                sheen_align_measure(st);
            }
            if ((s = sheen_align_move(st, &step_px, err)))
                return s;
            if (step_px < 0.02)
                break;
        }
    return SHEEN_OK;
}

// Image of a point under a pose of which one number is moved.
static int project_moved(double q_px[2], const sheen_camera *cam, const double rt[6], int number, double by,
                         const double p_obj[3])
{
    double moved[6], p_cam[3];
    sheen_Rt Rt;
    memcpy(moved, rt, sizeof moved);
    moved[number] += by;
    sheen_Rt_from_rt(&Rt, moved);
    sheen_Rt_point(p_cam, &Rt, p_obj);
    return !sheen_camera_project(cam, q_px, NULL, p_cam, 1, NULL);
}

// What the pose's covariance says of where a point of the object is in the picture; 0: it says nothing.
static double known_to_px(const sheen_photo *photo, const sheen_camera *cam, const double p_obj[3])
{
    static const double step = 1e-6;
    double J[6][2], variance_px2 = 0;
    for (int k = 0; k < 6; k++) {
        double a[2], b[2];
        if (!project_moved(a, cam, photo->rt_cam_obj, k, -step, p_obj) ||
            !project_moved(b, cam, photo->rt_cam_obj, k, step, p_obj))
            return 0;
        for (int i = 0; i < 2; i++)
            J[k][i] = (b[i] - a[i]) / (2 * step);
    }
    for (int k = 0; k < 6; k++)
        for (int l = 0; l < 6; l++)
            variance_px2 += photo->covariance[6 * k + l] * (J[k][0] * J[l][0] + J[k][1] * J[l][1]);
    return sqrt(fmax(0, variance_px2));
}

static void start_view(sheen_align_state *st, size_t view, const sheen_mesh *mesh)
{
    const sheen_photo *photo = &st->photos->photos[view];
    const sheen_camera *cam = &st->photos->cam;
    sheen_align_pose *v = &st->views[view];
    float centre_obj[3], radius_m;
    sheen_mesh_sphere(mesh, centre_obj, &radius_m);
    sheen_Rt_from_rt(&v->Rt_cam_obj, photo->rt_cam_obj);
    const double c[3] = {(double)centre_obj[0], (double)centre_obj[1], (double)centre_obj[2]};
    sheen_Rt_point(v->centre_cam, &v->Rt_cam_obj, c);
    const double per_m = cam->intrinsics[0] / sheen_norm(v->centre_cam), r = 0.6 * (double)radius_m;
    for (int k = 0; k < 3; k++) {
        v->px_per[k] = per_m * r;
        v->px_per[3 + k] = per_m;
    }
    v->px_per[5] = per_m * r / sheen_norm(v->centre_cam); // towards the camera it only grows
    const double known_px = known_to_px(photo, cam, c);
    v->prior_px = known_px > 0 ? known_px : st->o->prior_px > 0 ? st->o->prior_px : 2;
}

// Standard deviations of the poses from the last normal equations, and how far they went.
static void summarize(sheen_align_result *out, sheen_align_state *st)
{
    const size_t N = 6 * st->n_views;
    double *inverse = malloc(N * N * sizeof *inverse);
    const int known = out->poses_kept && inverse && !sheen_align_equations(st, NULL) &&
                      sheen_cholesky(st->A, (int)N);
    if (known)
        sheen_cholesky_invert(inverse, st->A, (int)N);
    for (size_t v = 0; v < st->n_views; v++) {
        sheen_align_view *o = &out->views[v];
        double left = 0;
        for (size_t k = 0; k < 6 && known; k++)
            left += inverse[(6 * v + k) * (N + 1)] * pow(st->views[v].px_per[k], 2);
        o->moved_px = sheen_align_moved_px(&st->views[v]);
        o->sigma_px = known ? sqrt(left) : (double)NAN;
        for (int c = 0; c < 3; c++)
            o->gain[c] = exp(st->views[v].log_gain[c]);
    }
    free(inverse);
}

static void hand_out(sheen_photos *photos, const sheen_align_result *r, const sheen_align_state *st)
{
    for (size_t v = 0; v < st->n_views && r->poses_kept; v++)
        sheen_rt_from_Rt(photos->photos[v].rt_cam_obj, &st->views[v].Rt_cam_obj);
}

typedef sheen_status believable_of(int *believable, sheen_align_state *, const sheen_align_pose *given,
                                   sheen_err *);

// Keeps what `st` holds where the points left out say so; else goes back. *error: their disagreement then.
static sheen_status decide(int *kept, double *error, sheen_align_state *st, const sheen_align_pose *before,
                           believable_of *believable, sheen_err *err)
{
    sheen_status s = left_out(st, error, err);
    if (s || (s = believable(kept, st, before, err)) || *kept)
        return s;
    memcpy(st->views, before, st->n_views * sizeof *before);
    return left_out(st, error, err);
}

// With the poses found, are the gains still worth having? Poses that are off can look like gains that differ.
static sheen_status reconsider_gains(sheen_align_result *out, sheen_align_state *st,
                                     sheen_align_pose *without, sheen_err *err)
{
    memcpy(without, st->views, st->n_views * sizeof *without);
    for (size_t v = 0; v < st->n_views; v++)
        memset(without[v].log_gain, 0, sizeof without[v].log_gain);
    sheen_status s = sheen_align_gains_believable(&out->gains_kept, st, without, err);
    if (s || out->gains_kept)
        return s;
    memcpy(st->views, without, st->n_views * sizeof *without);
    return left_out(st, &out->error_after, err);
}

static sheen_status refine(sheen_align_result *out, sheen_align_state *st, sheen_align_pose *before,
                           sheen_err *err)
{
    const size_t size = st->n_views * sizeof *before;
    sheen_status s = left_out(st, &out->error_before, err);
    out->error_after = out->error_before;
    if (!s && st->o->gains) {
        memcpy(before, st->views, size);
        if (!(s = refine_gains(st, 0, 6, err)) && !(s = refine_gains(st, 2, 3, err)))
            s = decide(&out->gains_kept, &out->error_after, st, before, sheen_align_gains_believable, err);
    }
    if (!s && st->o->poses) {
        memcpy(before, st->views, size);
        if (!(s = refine_poses(st, out->gains_kept, err)))
            s = decide(&out->poses_kept, &out->error_after, st, before, sheen_align_poses_believable, err);
    }
    return !s && out->gains_kept && out->poses_kept ? reconsider_gains(out, st, before, err) : s;
}

static sheen_status allocate(sheen_align_state *st, sheen_align_pose **before, sheen_align_result *out,
                             sheen_err *err)
{
    const size_t n = st->n_views, N = 6 * n;
    st->views = calloc(n, sizeof *st->views);
    *before = calloc(n, sizeof **before);
    st->seen = calloc(n * st->n_points, sizeof *st->seen);
    st->A = malloc(N * N * sizeof *st->A);
    st->b = malloc(N * sizeof *st->b);
    st->scratch = malloc(n * sizeof *st->scratch);
    out->views = calloc(n, sizeof *out->views);
    if (!st->views || !*before || !st->seen || !st->A || !st->b || !st->scratch || !out->views)
        return sheen_fail_memory(err, (double)(N * N * sizeof *st->A + n * st->n_points * sizeof *st->seen),
                                 "the poses' refinement");
    return SHEEN_OK;
}

sheen_status sheen_align_photos(sheen_align_result *out, sheen_photos *photos, const sheen_mesh *mesh,
                                const sheen_scene *scene, const sheen_align_options *options, sheen_err *err)
{
    sheen_align_points points;
    sheen_align_pose *before = NULL;
    *out = (sheen_align_result){.n_views = photos->count};
    sheen_status s = sheen_align_points_take(&points, photos, mesh, scene, options->texels_per_edge,
                                             options->lights, options->n_threads, err);
    if (s)
        return s;
    sheen_align_state st = {.o = options,
                            .photos = photos,
                            .points = &points,
                            .scale = 0.02,
                            .stride = 1,
                            .prior_ev = options->prior_ev > 0 ? options->prior_ev : 0.5,
                            .white_lin = options->white_lin > 0 ? options->white_lin : 0.97,
                            .n_views = photos->count,
                            .n_points = points.n_points};
    out->n_points = points.n_points;
    if ((s = allocate(&st, &before, out, err)))
        goto done;
    for (size_t v = 0; v < st.n_views; v++)
        start_view(&st, v, mesh);
    if (points.n_points >= LEAST_POINTS && !(s = refine(out, &st, before, err))) {
        summarize(out, &st);
        hand_out(photos, out, &st);
    }

done:
    sheen_align_points_release(&points);
    free(st.views);
    free(before);
    free(st.seen);
    free(st.A);
    free(st.b);
    free(st.scratch);
    if (s)
        sheen_align_result_release(out);
    return s;
}

void sheen_align_result_release(sheen_align_result *r)
{
    free(r->views);
    *r = (sheen_align_result){0};
}

sheen_status sheen_align_divide(sheen_image *taken, sheen_photos *photos, const sheen_align_result *r,
                                sheen_err *err)
{
    for (size_t v = 0; v < photos->count; v++) {
        sheen_image *image = &photos->photos[v].image, divided;
        const sheen_status s = sheen_image_init(&divided, image->width_px, image->height_px, 3, err);
        if (s) {
            for (size_t i = 0; i < v; i++) {
                sheen_image_release(&photos->photos[i].image);
                photos->photos[i].image = taken[i];
            }
            return s;
        }
        const size_t n = (size_t)image->width_px * (size_t)image->height_px;
        for (size_t i = 0; i < n; i++)
            for (size_t c = 0; c < 3; c++)
                divided.data[3 * i + c] = image->data[3 * i + c] / (float)r->views[v].gain[c];
        taken[v] = *image;
        *image = divided;
    }
    return SHEEN_OK;
}

void sheen_align_give_back(sheen_photos *photos, sheen_image *taken)
{
    for (size_t v = 0; v < photos->count; v++) {
        sheen_image_release(&photos->photos[v].image);
        photos->photos[v].image = taken[v];
        taken[v] = (sheen_image){0};
    }
}
