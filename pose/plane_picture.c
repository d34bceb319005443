// SPDX-License-Identifier: Apache-2.0
// plane_picture.c - a grid of places on the plane, looked up in every photograph; the colour of the most.
#include "pose/plane_picture.h"

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/parallel.h"
#include "base/pose3.h"

enum { MAX_VIEWS = 32, MAX_SIDE = 1200, LEAST_PLACES = 20 };

static const double margin = 0.75;        // of the board's longer side, on each side of it
static const double pixels_a_place = 1.5; // at the median view's distance
static const double same_colour =
    0.06; // difference, in square roots of light, within which photographs agree
static const double least_contrast = 0.15; // between the board's white and black

typedef struct job {
    const sheen_camera *camera;
    const sheen_plane_view *views;
    sheen_Rt Rt_cam_board[MAX_VIEWS];
    float gain[MAX_VIEWS]; // to square roots of light at one exposure
    size_t n_views;
    sheen_plane_picture *out;
    atomic_bool failed;
} job;

static double apart(const float a[3], const float b[3])
{
    double sum = 0;
    for (int c = 0; c < 3; c++)
        sum += (double)((a[c] - b[c]) * (a[c] - b[c]));
    return sqrt(sum);
}

bool sheen_colours_agree(float out[3], float (*rgb)[3], int n)
{
    int best = -1, most = 0;
    for (int i = 0; i < n; i++) {
        int like = 0;
        for (int k = 0; k < n; k++)
            like += apart(rgb[i], rgb[k]) < same_colour;
        if (like > most) {
            most = like;
            best = i;
        }
    }
    if (most < 3 || 2 * most <= n)
        return false;
    double sum[3] = {0, 0, 0};
    for (int k = 0; k < n; k++)
        for (int c = 0; c < 3 && apart(rgb[best], rgb[k]) < same_colour; c++)
            sum[c] += (double)rgb[k][c];
    for (int c = 0; c < 3; c++)
        out[c] = (float)(sum[c] / most);
    return true;
}

static void fill_rows(void *self, size_t begin, size_t end)
{
    job *j = self;
    const size_t width = (size_t)j->out->rgb.width_px;
    float(*rgb)[MAX_VIEWS][3] = malloc(width * sizeof *rgb);
    double *p_cam = malloc(width * 3 * sizeof *p_cam), *q_px = malloc(width * 2 * sizeof *q_px);
    int *n = malloc(width * sizeof *n);
    for (size_t y = begin; y < end && rgb && p_cam && q_px && n; y++) {
        memset(n, 0, width * sizeof *n);
        for (size_t v = 0; v < j->n_views; v++) {
            for (size_t x = 0; x < width; x++) {
                const double p[3] = {j->out->x0_m + (double)x * j->out->pitch_m,
                                     j->out->y0_m + (double)y * j->out->pitch_m, 0};
                sheen_Rt_point(p_cam + 3 * x, &j->Rt_cam_board[v], p);
            }
            if (sheen_camera_project(j->camera, q_px, NULL, p_cam, width, NULL))
                break;
            for (size_t x = 0; x < width; x++) {
                float *to = rgb[x][n[x]];
                if (!(p_cam[3 * x + 2] > 0) || !(fabs(q_px[2 * x]) < 1e6) || !(fabs(q_px[2 * x + 1]) < 1e6) ||
                    !sheen_image_bilinear(to, j->views[v].rgb, q_px[2 * x], q_px[2 * x + 1]))
                    continue;
                for (int c = 0; c < 3; c++)
                    to[c] = sqrtf(fmaxf(0, to[c])) * j->gain[v];
                n[x]++;
            }
        }
        for (size_t x = 0; x < width; x++) {
            float *out = sheen_image_at(&j->out->rgb, (int)x, (int)y);
            if (!sheen_colours_agree(out, rgb[x], n[x]))
                out[0] = out[1] = out[2] = -1;
        }
    }
    if (!rgb || !p_cam || !q_px || !n)
        j->failed = true;
    free(rgb);
    free(p_cam);
    free(q_px);
    free(n);
}

// Level of a place of the plane in a picture; false: not in it.
static bool look_up(float root[3], const sheen_camera *camera, const sheen_plane_view *v,
                    const sheen_Rt *Rt_cam_board, const double p_board[3])
{
    double p_cam[3], q_px[2];
    sheen_Rt_point(p_cam, Rt_cam_board, p_board);
    if (!(p_cam[2] > 0) || sheen_camera_project(camera, q_px, NULL, p_cam, 1, NULL) ||
        !(fabs(q_px[0]) < 1e6) || !(fabs(q_px[1]) < 1e6) ||
        !sheen_image_bilinear(root, v->rgb, q_px[0], q_px[1]))
        return false;
    for (int c = 0; c < 3; c++)
        root[c] = sqrtf(fmaxf(0, root[c]));
    return true;
}

// Places of the board that the photographs leave unknown, from the picture without the object; its exposure by the places that both know.
static sheen_status fill_from_empty(job *j, const sheen_board *board, const sheen_plane_view *empty,
                                    sheen_err *err)
{
    const int w = j->out->rgb.width_px, h = j->out->rgb.height_px;
    double *ratios = malloc(((size_t)w * (size_t)h + 1) * sizeof *ratios), gain = 1;
    size_t n = 0;
    sheen_Rt Rt_cam_board;
    if (!ratios)
        return sheen_fail_memory(err, 8.0 * w * h, "the board's picture");
    sheen_Rt_from_rt(&Rt_cam_board, empty->rt_cam_board);
    for (int fills = 0; fills < 2; fills++) {
        for (int y = 0; y < h; y++)
            for (int x = 0; x < w; x++) {
                const double p[3] = {j->out->x0_m + x * j->out->pitch_m, j->out->y0_m + y * j->out->pitch_m,
                                     0};
                float *out = sheen_image_at(&j->out->rgb, x, y), root[3];
                if (fabs(p[0]) > 0.5 * board->n_cols * board->square_m ||
                    fabs(p[1]) > 0.5 * board->n_rows * board->square_m || (out[0] < 0) != (fills == 1) ||
                    !look_up(root, j->camera, empty, &Rt_cam_board, p))
                    continue;
                for (int c = 0; c < 3 && fills; c++)
                    out[c] = root[c] * (float)gain;
                if (!fills && root[1] > 0.2f)
                    ratios[n++] = (double)(out[1] / root[1]);
            }
        qsort(ratios, n, sizeof *ratios, sheen_ascending);
        gain = n ? ratios[n / 2] : 1;
    }
    free(ratios);
    return SHEEN_OK;
}

// Pixels a metre at the board's origin, the median of the views.
static double scale_px_per_m(const job *j)
{
    double each[MAX_VIEWS] = {0};
    for (size_t v = 0; v < j->n_views; v++) {
        double q_px[2], dq_dp[6];
        each[v] = 0;
        if (!sheen_camera_project(j->camera, q_px, dq_dp, j->Rt_cam_board[v].t, 1, NULL) &&
            isfinite(dq_dp[0]))
            each[v] = hypot(dq_dp[0], dq_dp[3]);
    }
    qsort(each, j->n_views, sizeof *each, sheen_ascending);
    return each[j->n_views / 2];
}

// Photographs of one board are equally bright in the median: of the places on it that all of them show, each against
// their median there. What hides the board hides it in few of them.
static sheen_status measure_gains(job *j, const sheen_board *board, sheen_err *err)
{
    enum { SIDE = 48 };
    double *ratios = malloc((size_t)SIDE * SIDE * j->n_views * sizeof *ratios);
    size_t n = 0;
    if (!ratios)
        return sheen_fail_memory(err, 8.0 * SIDE * SIDE * (double)j->n_views, "exposures");
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double p[3] = {((i % SIDE + 0.5) / SIDE - 0.5) * board->n_cols * board->square_m,
                             ((i / SIDE + 0.5) / SIDE - 0.5) * board->n_rows * board->square_m, 0};
        double level[MAX_VIEWS], sorted[MAX_VIEWS] = {0};
        size_t seen = 0;
        for (size_t v = 0; v < j->n_views; v++, seen++) {
            double p_cam[3], q_px[2];
            float rgb[3];
            sheen_Rt_point(p_cam, &j->Rt_cam_board[v], p);
            if (!(p_cam[2] > 0) || sheen_camera_project(j->camera, q_px, NULL, p_cam, 1, NULL) ||
                !(fabs(q_px[0]) < 1e6) || !(fabs(q_px[1]) < 1e6) ||
                !sheen_image_bilinear(rgb, j->views[v].rgb, q_px[0], q_px[1]))
                break;
            level[v] = sorted[v] = sqrt(fmax(0, (double)sheen_luminance(rgb)));
        }
        if (seen < j->n_views)
            continue;
        qsort(sorted, seen, sizeof *sorted, sheen_ascending);
        for (size_t v = 0; v < seen; v++)
            ratios[v * SIDE * SIDE + n] = sorted[seen / 2] / fmax(1e-3, level[v]);
        n++;
    }
    for (size_t v = 0; v < j->n_views; v++) {
        double *own = ratios + v * SIDE * SIDE;
        qsort(own, n, sizeof *own, sheen_ascending);
        j->gain[v] = n ? (float)own[n / 2] : 1;
    }
    free(ratios);
    return SHEEN_OK;
}

// What the print must be at a place: 0 black, 1 white, -1 either (a tag, a border, beyond the board).
static int printed(const sheen_board *b, double x_m, double y_m, double clear_m)
{
    const double u = x_m / b->square_m + 0.5 * b->n_cols, v = 0.5 * b->n_rows - y_m / b->square_m;
    if (hypot(x_m, y_m) < b->blank_radius_m - clear_m)
        return 1;
    if (!(u > 0 && v > 0 && u < b->n_cols && v < b->n_rows) || hypot(x_m, y_m) < b->blank_radius_m + clear_m)
        return -1;
    const double from_edge_m = b->square_m *
                               fmin(0.5 - fabs(u - floor(u) - 0.5), 0.5 - fabs(v - floor(v) - 0.5));
    if (from_edge_m < clear_m)
        return -1;
    if (((int)u + (int)v) % 2 == 0)
        return 0;
    return from_edge_m + clear_m < 0.5 * (b->square_m - b->tag_side_m) ? 1 : -1;
}

static double median(double *values, size_t n)
{
    qsort(values, n, sizeof *values, sheen_ascending);
    return n ? values[n / 2] : (double)NAN;
}

// Calls places unknown where the print is not what it must be: there the most show something that stands on them.
static sheen_status check_print(sheen_plane_picture *p, const sheen_board *board, sheen_err *err)
{
    const size_t n = (size_t)p->rgb.width_px * (size_t)p->rgb.height_px;
    double *levels[2] = {malloc(n * sizeof **levels), malloc(n * sizeof **levels)}, mid[2];
    size_t count[2] = {0, 0};
    sheen_status s = levels[0] && levels[1] ? SHEEN_OK
                                            : sheen_fail_memory(err, 16.0 * (double)n, "the board");
    for (int pass = 0; pass < 2 && !s; pass++) {
        for (size_t i = 0; i < n; i++) {
            float *rgb = p->rgb.data + 3 * i;
            const double x_m = p->x0_m + (double)(i % (size_t)p->rgb.width_px) * p->pitch_m,
                         y_m = p->y0_m + (double)(i / (size_t)p->rgb.width_px) * p->pitch_m;
            const int want = rgb[0] < 0 ? -1 : printed(board, x_m, y_m, p->pitch_m);
            const double level = (double)sheen_luminance(rgb);
            if (want >= 0 && pass == 0)
                levels[want][count[want]++] = level;
            else if (want >= 0 && (level > 0.5 * (mid[0] + mid[1])) != want)
                rgb[0] = rgb[1] = rgb[2] = -1;
        }
        if (pass)
            break;
        for (int k = 0; k < 2; k++)
            mid[k] = median(levels[k], count[k]);
        if (count[0] < LEAST_PLACES || count[1] < LEAST_PLACES)
            break; // too small a picture to tell squares from tags
        if (!(mid[1] - mid[0] > least_contrast))
            s = sheen_fail(err, SHEEN_EDATA,
                           "the photographs do not agree on the board that the poses stand for");
    }
    free(levels[0]);
    free(levels[1]);
    return s;
}

sheen_status sheen_plane_picture_make(sheen_plane_picture *out, const sheen_camera *camera,
                                      const sheen_board *board, const sheen_plane_view *views, size_t n_views,
                                      int n_threads, sheen_err *err)
{
    job j = {
        .camera = camera, .views = views, .n_views = n_views < MAX_VIEWS ? n_views : MAX_VIEWS, .out = out};
    *out = (sheen_plane_picture){0};
    if (n_views < 3)
        return sheen_fail(err, SHEEN_EDATA, "three photographs at least tell the board from what hides it");
    for (size_t v = 0; v < j.n_views; v++)
        sheen_Rt_from_rt(&j.Rt_cam_board[v], views[v].rt_cam_board);
    const double width_m = board->n_cols * board->square_m, height_m = board->n_rows * board->square_m;
    const double aside_m = margin * fmax(width_m, height_m);
    const double longest_m = fmax(width_m, height_m) + 2 * aside_m;
    out->pitch_m = fmax(longest_m / MAX_SIDE, pixels_a_place / fmax(1, scale_px_per_m(&j)));
    out->x0_m = -0.5 * width_m - aside_m;
    out->y0_m = -0.5 * height_m - aside_m;
    sheen_status s = sheen_image_init(&out->rgb, (int)((width_m + 2 * aside_m) / out->pitch_m) + 1,
                                      (int)((height_m + 2 * aside_m) / out->pitch_m) + 1, 3, err);
    if (s)
        return s;
    s = measure_gains(&j, board, err);
    if (!s)
        sheen_parallel_for((size_t)out->rgb.height_px, 4, n_threads, fill_rows, &j);
    if (!s)
        s = j.failed ? sheen_fail_memory(err, 1e6, "the board's picture") : check_print(out, board, err);
    for (size_t v = 0; v < n_views && !s; v++)
        if (views[v].empty && (!v || views[v].empty != views[v - 1].empty))
            s = fill_from_empty(&j, board, views[v].empty, err);
    if (s)
        sheen_plane_picture_release(out);
    return s;
}

void sheen_plane_picture_release(sheen_plane_picture *p)
{
    sheen_image_release(&p->rgb);
    *p = (sheen_plane_picture){0};
}
