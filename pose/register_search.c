// SPDX-License-Identifier: Apache-2.0
// register_search.c - the search for a mesh's place: starts, ranking, refinement, judgement.
#include "pose/register_search.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "pose/pose_tangent.h"
#include "pose/register_pictures.h"

enum {
    N_YAWS = 24,
    SEARCH_VIEWS = 6,
    FULL_VIEWS = 24,
    CRUDE_CELLS = 12,
    COARSE_CELLS = 24,
    FINE_CELLS = 64,
    KEEP_CRUDE = 30,
    KEEP = 6,
    FINALISTS = 3
};

static const double PI = 3.14159265358979323846;
static const double SEARCH_SIZE_PX = 90;
static const double FULL_SIZE_PX = 500; // of the object's longest side: more adds nothing but time
static const double DIFFERENT = 0.04;   // places further apart than this, in parts of the radius, are two
static const double AMBIGUOUS_FACTOR[2] = {
    1.5, 1.2}; // of the best one's misfit, which rough masks make larger for all
static const double POOR_SHARE[2] = {0.02, 0.05}; // of the object's size in the picture; of rough masks
static const double POOR_OVERLAP[2] = {0.9, 0.8};
static const double POOR_FOUND = 0.7;
static const double RULED_OUT = 4;         // times the best one's misfit in small pictures: never the place
static const double SMALL_BORDER_PX = 0.3; // a misfit that small pictures alone may make
static const double MAX_SIGMA_RAD = 0.3 * 3.14159265358979323846 / 180;
static const double MAX_SIGMA_SHARE = 0.02; // of the object's radius, for its worst point
static const double KNOWN_UNIT = 0.03;      // the scale is a unit's when it is this near to it

static const struct {
    double unit_m;
    const char *name;
} units[] = {{1, "m"}, {1e-3, "mm"}, {1e-2, "cm"}, {0.0254, "inch"}};

const char *sheen_unit_name(double unit_m)
{
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (fabs(units[i].unit_m / unit_m - 1) < 1e-9)
            return units[i].name;
    return "";
}

const char *sheen_up_name(unsigned up)
{
    static const char *const names[] = {"x", "-x", "y", "-y", "z", "-z"};
    for (int i = 0; i < 6; i++)
        if (up == 1U << i)
            return names[i];
    return "";
}

typedef struct candidate {
    sheen_placement placement;
    sheen_outline_misfit misfit;
    unsigned up;
    bool alive;
} candidate;

typedef struct search {
    const sheen_register_options *options;
    sheen_outline_mesh full, fine, coarse, crude; // all but the first for small pictures
    const sheen_outline_mesh *sliding;            // the one of these that starts slide with
    sheen_register_pictures small;
    double centre_obj[3], radius_obj;
    double low_obj[3], high_obj[3];
    candidate *starts;
    size_t n_starts;
    candidate left; // the best of those that small pictures ruled out
    bool has_left;
    sheen_status status; // of the parallel part
    sheen_err err;
} search;

// The rotation that brings a side up.
static void up_rotation(double R[3][3], unsigned up)
{
    int bit = 0;
    while (up > 1U << bit)
        bit++;
    const int axis = bit / 2;
    const double sign = bit % 2 ? -1 : 1;
    memset(R, 0, 9 * sizeof **R);
    R[2][axis] = sign;
    R[0][(axis + 1) % 3] = 1;
    R[1][(axis + 2) % 3] = sign; // keeps it a rotation
}

// Stands the object on the board, the middle of its box above (x, y).
static void stand(sheen_placement *p, const search *s, unsigned up, double yaw_rad, double scale,
                  const double xy[2])
{
    double R[3][3], centre[3], lowest = INFINITY;
    const double c = cos(yaw_rad), sn = sin(yaw_rad);
    up_rotation(R, up);
    *p = (sheen_placement){.scale = scale};
    for (int j = 0; j < 3; j++) {
        p->Rt_board_obj.R[0][j] = c * R[0][j] - sn * R[1][j];
        p->Rt_board_obj.R[1][j] = sn * R[0][j] + c * R[1][j];
        p->Rt_board_obj.R[2][j] = R[2][j];
    }
    for (size_t i = 0; i < s->coarse.n_vertices; i++) {
        double z = 0;
        for (size_t j = 0; j < 3; j++)
            z += p->Rt_board_obj.R[2][j] * (double)s->coarse.p_obj[3 * i + j];
        lowest = fmin(lowest, z);
    }
    sheen_Rt_direction(centre, &p->Rt_board_obj, s->centre_obj);
    p->Rt_board_obj.t[0] = xy[0] - scale * centre[0];
    p->Rt_board_obj.t[1] = xy[1] - scale * centre[1];
    p->Rt_board_obj.t[2] = -scale * lowest;
}

// The scale at which the mesh covers as much as the masks, by drawing it.
static sheen_status size_up(double *scale, search *s, unsigned up, const double xy[2], sheen_err *err)
{
    const double wanted = sheen_register_mask_area(&s->small);
    for (int round = 0; round < 6; round++) {
        sheen_placement p;
        stand(&p, s, up, 0.4, *scale, xy);
        for (size_t v = 0; v < s->small.n_views; v++) {
            const sheen_status st = sheen_outline_draw(&s->small.outlines[v], &s->coarse, &p,
                                                       &s->small.views[v].canvas, 1e3, err);
            if (st)
                return st;
        }
        const double area = sheen_register_cover_area(&s->small);
        const double grow = sqrt(wanted / fmax(area, 1));
        *scale *= fmin(4, fmax(0.25, grow));
        if (fabs(grow - 1) < 0.01)
            break;
    }
    return SHEEN_OK;
}

// The size of what the masks show, from the distance and the extent of the masks: a first guess.
static double first_scale(const search *s, const double centre_board[3])
{
    const sheen_outline_canvas *c = &s->small.views[0].canvas;
    double p_cam[3], q[2], dq[6];
    sheen_Rt_point(p_cam, &c->Rt_cam_board, centre_board);
    if (sheen_camera_project(c->camera, q, dq, p_cam, 1, NULL) || !isfinite(dq[0]))
        return 0.05 / s->radius_obj;
    const double px_per_m = c->factor * sqrt(fabs(dq[0] * dq[4] - dq[1] * dq[3]));
    const double radius_px = sqrt(sheen_register_mask_area(&s->small) / (double)s->small.n_views / PI);
    return radius_px / px_per_m / s->radius_obj;
}

static sheen_status make_starts(search *s, sheen_err *err)
{
    double centre_board[3];
    sheen_status st = sheen_register_centre(centre_board, &s->small, err);
    if (st)
        return st;
    s->starts = calloc((size_t)6 * N_YAWS, sizeof *s->starts);
    if (!s->starts)
        return sheen_fail_memory(err, 6.0 * N_YAWS * sizeof *s->starts, "starts");
    const unsigned ups = s->options->ups ? s->options->ups : SHEEN_UP_ANY;
    for (unsigned up = 1; up <= SHEEN_UP_MINUS_Z; up <<= 1) {
        if (!(ups & up))
            continue;
        double scale = s->options->unit_m > 0 ? s->options->unit_m : first_scale(s, centre_board);
        if (!(s->options->unit_m > 0))
            st = size_up(&scale, s, up, centre_board, err);
        if (st)
            return st;
        for (int i = 0; i < N_YAWS; i++) {
            candidate *c = &s->starts[s->n_starts++];
            c->up = up;
            stand(&c->placement, s, up, 2 * PI * i / N_YAWS, scale, centre_board);
        }
    }
    return SHEEN_OK;
}

// Slides each start on the board.
static void slide(void *self, size_t begin, size_t end)
{
    search *s = self;
    const bool sized = s->options->unit_m > 0;
    const sheen_outline_fit_options o = {.free = {false, false, true, true, true, false, !sized},
                                         .pivot_on_board = true,
                                         .reach_px = 30,
                                         .spacing_px = 2,
                                         .max_steps = 6};
    sheen_outline outlines[SEARCH_VIEWS] = {{0}};
    const sheen_outline_views views = {s->small.views, outlines, s->small.n_views};
    for (size_t i = begin; i < end; i++) {
        sheen_err err = {0};
        candidate *c = &s->starts[i];
        const sheen_status st = sheen_outline_fit(&c->placement, &c->misfit, s->sliding, &views,
                                                  s->centre_obj, &o, &err);
        c->alive = !st;
        if (st && st != SHEEN_EDATA)
            __atomic_store_n((int *)&s->status, (int)st, __ATOMIC_RELAXED);
    }
    for (int v = 0; v < SEARCH_VIEWS; v++)
        sheen_outline_release(&outlines[v]);
}

static int by_misfit(const void *a, const void *b)
{
    const candidate *x = a, *y = b;
    if (x->alive != y->alive)
        return x->alive ? -1 : 1;
    return (x->misfit.border_px > y->misfit.border_px) - (x->misfit.border_px < y->misfit.border_px);
}

// How far the corners of the object's box lie apart in two placements, at most.
static double apart_m(const search *s, const sheen_placement *a, const sheen_placement *b)
{
    double most = 0;
    for (int corner = 0; corner < 8; corner++) {
        double p[3], q[3], d[3];
        for (int k = 0; k < 3; k++) {
            const double x = corner >> k & 1 ? s->high_obj[k] : s->low_obj[k];
            p[k] = a->scale * x;
            q[k] = b->scale * x;
        }
        sheen_Rt_point(p, &a->Rt_board_obj, p);
        sheen_Rt_point(q, &b->Rt_board_obj, q);
        sheen_sub(d, p, q);
        most = fmax(most, sheen_norm(d));
    }
    return most;
}

// Drops candidates that ended where a better one did; list is sorted, best first. Returns how many are left.
static size_t drop_doubles(const search *s, candidate *list, size_t n)
{
    size_t kept = 0;
    for (size_t i = 0; i < n && list[i].alive; i++) {
        bool is_new = true;
        for (size_t k = 0; k < kept && is_new; k++)
            is_new = apart_m(s, &list[k].placement, &list[i].placement) >
                     DIFFERENT * list[i].placement.scale * s->radius_obj;
        if (is_new)
            list[kept++] = list[i];
    }
    return kept;
}

static sheen_status fit_all(search *s, size_t *n, const sheen_outline_mesh *mesh,
                            sheen_register_pictures *pictures, const sheen_outline_fit_options *o,
                            sheen_err *err)
{
    const sheen_outline_views views = {pictures->views, pictures->outlines, pictures->n_views};
    for (size_t i = 0; i < *n; i++) {
        candidate *c = &s->starts[i];
        const sheen_status st = sheen_outline_fit(&c->placement, &c->misfit, mesh, &views, s->centre_obj, o,
                                                  err);
        c->alive = !st;
        if (st && st != SHEEN_EDATA)
            return st;
    }
    qsort(s->starts, *n, sizeof *s->starts, by_misfit);
    *n = drop_doubles(s, s->starts, *n);
    return SHEEN_OK;
}

static sheen_status prepare(search *s, const sheen_mesh *mesh, const sheen_register_options *options,
                            sheen_err *err)
{
    float low[3], high[3];
    *s = (search){.options = options};
    if (!mesh->n_triangles)
        return sheen_fail(err, SHEEN_EARG, "the mesh has no triangles");
    sheen_mesh_bounds(mesh, low, high);
    for (int k = 0; k < 3; k++) {
        s->low_obj[k] = (double)low[k];
        s->high_obj[k] = (double)high[k];
        s->centre_obj[k] = 0.5 * (s->low_obj[k] + s->high_obj[k]);
        s->radius_obj += pow(0.5 * (s->high_obj[k] - s->low_obj[k]), 2);
    }
    s->radius_obj = sqrt(s->radius_obj);
    if (!(s->radius_obj > 0) || !isfinite(s->radius_obj))
        return sheen_fail(err, SHEEN_EARG, "the mesh has no size, or one that is not finite");
    sheen_status st = sheen_outline_mesh_make(&s->full, mesh, err);
    if (!st)
        st = sheen_outline_mesh_coarsen(&s->fine, &s->full, FINE_CELLS, err);
    if (!st)
        st = sheen_outline_mesh_coarsen(&s->coarse, &s->full, COARSE_CELLS, err);
    if (!st)
        st = sheen_outline_mesh_coarsen(&s->crude, &s->full, CRUDE_CELLS, err);
    if (!st && !s->coarse.n_triangles)
        st = sheen_fail(err, SHEEN_EARG, "the mesh has no surface");
    return st;
}

static void release(search *s)
{
    sheen_outline_mesh_release(&s->full);
    sheen_outline_mesh_release(&s->fine);
    sheen_outline_mesh_release(&s->coarse);
    sheen_outline_mesh_release(&s->crude);
    sheen_register_pictures_release(&s->small);
    free(s->starts);
}

// The finalists in full pictures: the whole pose, and the scale where it is not known.
static sheen_status finish_all(search *s, size_t *n, sheen_register_pictures *full, bool with_scale,
                               bool edges, sheen_err *err)
{
    sheen_outline_fit_options o = {.free = {true, true, true, true, true, true, with_scale, true},
                                   .reach_px = fmax(6, 4 * full->factor / fmax(s->small.factor, 1e-9)),
                                   .spacing_px = 2,
                                   .max_steps = 15};
    sheen_status st = fit_all(s, n, &s->full, full, &o, err);
    if (!st && *n && edges) {
        o.edges = true;
        o.reach_px = 4;
        st = fit_all(s, n, &s->full, full, &o, err);
    }
    return st;
}

static double size_px(const sheen_register_pictures *p)
{
    return sqrt(sheen_register_mask_area(p) / (double)p->n_views);
}

static void judge(sheen_registration *out, const search *s, const candidate *best, const candidate *second,
                  const sheen_register_pictures *full)
{
    const double border_px = best->misfit.border_px,
                 poor_px = fmax(1, POOR_SHARE[s->options->rough_masks] * size_px(full));
    out->state = SHEEN_REGISTER_SURE;
    if (second) {
        out->second_border_px = second->misfit.border_px / full->factor;
        out->second_distance_m = apart_m(s, &best->placement, &second->placement);
        double wd[6];
        sheen_pose_difference(wd, &second->placement.Rt_board_obj, &best->placement.Rt_board_obj);
        out->second_angle_rad = sheen_norm(wd);
    }
    if (border_px > poor_px || best->misfit.overlap < POOR_OVERLAP[s->options->rough_masks] ||
        best->misfit.found < POOR_FOUND) {
        out->state = SHEEN_REGISTER_POOR;
        snprintf(out->reason, sizeof out->reason,
                 "the mesh does not fit the masks (outlines %.1f px apart, overlap %.0f %%): is it this "
                 "object, and "
                 "does it stand on the board; give its up axis, unit, or correspondences",
                 border_px / full->factor, 100 * best->misfit.overlap);
    } else if (second &&
               second->misfit.border_px < AMBIGUOUS_FACTOR[s->options->rough_masks] * fmax(border_px, 0.2)) {
        out->state = SHEEN_REGISTER_AMBIGUOUS;
        snprintf(out->reason, sizeof out->reason,
                 "ambiguous: turned by %.0f degrees it fits as well (outlines %.2f and %.2f px apart), as a "
                 "shape of "
                 "revolution or symmetry does: give correspondences",
                 out->second_angle_rad * 180 / PI, border_px / full->factor, out->second_border_px);
    } else if (!(out->sigma_rad < MAX_SIGMA_RAD)) {
        out->state = SHEEN_REGISTER_AMBIGUOUS;
        snprintf(out->reason, sizeof out->reason,
                 "ambiguous: the outlines determine its turn to %.1f degrees only: give correspondences",
                 out->sigma_rad * 180 / PI);
    } else if (!(out->sigma_m < MAX_SIGMA_SHARE * best->placement.scale * s->radius_obj)) {
        out->state = SHEEN_REGISTER_AMBIGUOUS;
        snprintf(out->reason, sizeof out->reason,
                 "ambiguous: the outlines determine its place to %.1f mm only: give correspondences, or "
                 "frames from "
                 "other sides",
                 1e3 * out->sigma_m);
    }
}

static double lowest_m(const search *s, const sheen_placement *p)
{
    double lowest = INFINITY;
    for (size_t i = 0; i < s->full.n_vertices; i++) {
        double z = 0;
        for (size_t k = 0; k < 3; k++)
            z += p->Rt_board_obj.R[2][k] * (double)s->full.p_obj[3 * i + k];
        lowest = fmin(lowest, p->scale * z + p->Rt_board_obj.t[2]);
    }
    return lowest;
}

static double near_unit(double scale)
{
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (fabs(log(scale / units[i].unit_m)) < KNOWN_UNIT)
            return units[i].unit_m;
    return 0;
}

// Scale and pose to their end: where the scale turns out to be a unit's, the pose is fitted at exactly that.
static sheen_status settle_scale(search *s, size_t *n, sheen_registration *out, sheen_register_pictures *full,
                                 sheen_err *err)
{
    const sheen_register_options *o = s->options;
    out->unit_m = o->unit_m > 0 ? o->unit_m : 0;
    const bool free_scale = !(o->unit_m > 0) || o->fit_scale;
    sheen_status st = finish_all(s, n, full, free_scale, o->edges, err);
    if (st || !*n || o->unit_m > 0 || o->fit_scale)
        return st;
    out->unit_m = near_unit(s->starts[0].placement.scale);
    if (!(out->unit_m > 0))
        return st;
    for (size_t i = 0; i < *n; i++) {
        // about its centre, as far as its scale is a unit's too
        candidate *c = &s->starts[i];
        double arm[3], before[3];
        const double k = out->unit_m / c->placement.scale;
        if (fabs(log(k)) > 2 * KNOWN_UNIT)
            continue;
        sheen_Rt_direction(arm, &c->placement.Rt_board_obj, s->centre_obj);
        for (int j = 0; j < 3; j++) {
            before[j] = c->placement.scale * arm[j] + c->placement.Rt_board_obj.t[j];
            c->placement.Rt_board_obj.t[j] = before[j] - out->unit_m * arm[j];
        }
        c->placement.scale = out->unit_m;
    }
    return finish_all(s, n, full, false, o->edges, err);
}

// Of the vertex that is known worst: the root of its mean squared distance from where it is.
static double sigma_of_vertices(const search *s, const candidate *c)
{
    enum { N = SHEEN_OUTLINE_UNKNOWNS };
    const double *C = c->misfit.covariance;
    double worst = 0;
    for (size_t i = 0; i < s->full.n_vertices; i++) {
        double p[3], variance = 0;
        for (size_t k = 0; k < 3; k++)
            p[k] = c->placement.scale * ((double)s->full.p_obj[3 * i + k] - s->centre_obj[k]);
        sheen_Rt_direction(p, &c->placement.Rt_board_obj, p);
        for (int k = 0; k < 3; k++) {
            // how the point's k follows turn, move and scale
            double J[N] = {0}, sum = 0;
            J[(k + 1) % 3] = p[(k + 2) % 3];
            J[(k + 2) % 3] = -p[(k + 1) % 3];
            J[3 + k] = 1;
            J[SHEEN_OUTLINE_SCALE] = p[k];
            for (int u = 0; u < N; u++)
                for (int v = 0; v < N; v++)
                    sum += J[u] != 0 && J[v] != 0 ? J[u] * C[N * u + v] * J[v] : 0;
            variance += sum;
        }
        worst = fmax(worst, variance);
    }
    return sqrt(worst);
}

static sheen_status report(sheen_registration *out, search *s, size_t n, const sheen_register_pictures *full,
                           sheen_err *err)
{
    if (!n)
        return sheen_fail(err, SHEEN_EDATA, "the mesh fits nowhere near the masks%s",
                          s->options->unit_m > 0 ? ": is it of the unit that was told" : "");
    const candidate *best = &s->starts[0];
    out->placement = best->placement;
    out->misfit = best->misfit;
    out->up = best->up;
    out->n_views = full->n_views;
    out->second_border_px = (double)NAN;
    for (size_t k = 0; k < 3; k++)
        out->sigma_rad = fmax(out->sigma_rad,
                              sqrt(best->misfit.covariance[(SHEEN_OUTLINE_UNKNOWNS + 1) * k]));
    out->sigma_m = sigma_of_vertices(s, best);
    out->misfit.offset_px /= full->factor;
    out->misfit.border_px /= full->factor;
    out->misfit.rms_px /= full->factor;
    out->height_m = lowest_m(s, &best->placement);
    s->left.misfit.border_px *= full->factor / s->small.factor;
    judge(out, s, best, n > 1 ? &s->starts[1] : s->has_left ? &s->left : NULL, full);
    return SHEEN_OK;
}

// How many are worth full pictures.
static size_t finalists(search *s, size_t n)
{
    size_t kept = n < FINALISTS ? n : FINALISTS;
    while (kept > 1 && s->starts[kept - 1].misfit.border_px >
                           RULED_OUT * fmax(s->starts[0].misfit.border_px, SMALL_BORDER_PX))
        kept--;
    s->has_left = kept < n;
    if (s->has_left)
        s->left = s->starts[kept];
    return kept;
}

// Slides the first n starts with a mesh; n becomes how many places they came to, best first, at most `keep`.
static sheen_status slide_all(search *s, size_t *n, const sheen_outline_mesh *mesh, size_t keep,
                              sheen_err *err)
{
    const size_t portion = 8;
    sheen_status st = SHEEN_OK;
    s->sliding = mesh->n_triangles ? mesh : &s->coarse;
    for (size_t i = 0; i < *n && !st; i += portion * 4) { // in parts, so that it can be stopped
        const size_t count = *n - i < portion * 4 ? *n - i : portion * 4;
        search part = *s;
        part.starts = s->starts + i;
        sheen_parallel_for(count, portion, s->options->n_threads, slide, &part);
        st = part.status
                 ? sheen_fail(err, part.status, "cannot draw outlines")
                 : sheen_progress_step(&s->options->progress, "starts", (int)(i + count), (int)*n, err);
    }
    if (st)
        return st;
    qsort(s->starts, *n, sizeof *s->starts, by_misfit);
    *n = drop_doubles(s, s->starts, *n);
    *n = *n < keep ? *n : keep;
    return SHEEN_OK;
}

static sheen_status search_small(search *s, size_t *n, sheen_err *err)
{
    sheen_status st = make_starts(s, err);
    *n = s->n_starts;
    if (!st)
        st = slide_all(s, n, &s->crude, KEEP_CRUDE, err);
    if (!st)
        st = slide_all(s, n, &s->coarse, KEEP, err);
    if (st)
        return st;
    // on the board first, then free
    sheen_outline_fit_options o = {.free = {false, false, true, true, true, false, !(s->options->unit_m > 0)},
                                   .pivot_on_board = true,
                                   .reach_px = 15,
                                   .spacing_px = 1,
                                   .max_steps = 12};
    st = fit_all(s, n, &s->fine, &s->small, &o, err);
    o.free[0] = o.free[1] = o.free[5] = true;
    o.pivot_on_board = false;
    o.reach_px = 8;
    if (!st)
        st = fit_all(s, n, &s->fine, &s->small, &o, err);
    if (!st)
        *n = finalists(s, *n);
    return st;
}

sheen_status sheen_register_search(sheen_registration *out, const sheen_mesh *mesh,
                                   const sheen_camera *camera, const sheen_register_view *views,
                                   size_t n_views, const sheen_register_options *options, sheen_err *err)
{
    search s;
    sheen_register_pictures full = {0};
    size_t n = 0;
    *out = (sheen_registration){.second_border_px = (double)NAN};
    sheen_status st = prepare(&s, mesh, options, err);
    if (!st)
        st = sheen_register_pictures_make(&s.small, camera, views, n_views, SEARCH_VIEWS, SEARCH_SIZE_PX,
                                          err);
    if (!st)
        st = search_small(&s, &n, err);
    if (!st)
        st = sheen_register_pictures_make(&full, camera, views, n_views, FULL_VIEWS, FULL_SIZE_PX, err);
    if (!st)
        st = settle_scale(&s, &n, out, &full, err);
    if (!st)
        st = report(out, &s, n, &full, err);
    sheen_register_pictures_release(&full);
    release(&s);
    return st;
}

sheen_status sheen_register_refine(sheen_registration *out, const sheen_mesh *mesh,
                                   const sheen_camera *camera, const sheen_register_view *views,
                                   size_t n_views, const sheen_placement *start,
                                   const sheen_register_options *options, sheen_err *err)
{
    search s;
    sheen_register_pictures full = {0};
    size_t n = 1;
    *out = (sheen_registration){.second_border_px = (double)NAN};
    sheen_status st = prepare(&s, mesh, options, err);
    if (!st && !(s.starts = calloc(1, sizeof *s.starts)))
        st = sheen_fail_memory(err, sizeof *s.starts, "starts");
    if (!st) {
        s.starts[0].placement = *start;
        st = sheen_register_pictures_make(&full, camera, views, n_views, FULL_VIEWS, FULL_SIZE_PX, err);
    }
    s.small.factor = full.factor / 4;
    if (!st)
        st = settle_scale(&s, &n, out, &full, err);
    if (!st)
        st = report(out, &s, n, &full, err);
    sheen_register_pictures_release(&full);
    release(&s);
    return st;
}
