// SPDX-License-Identifier: Apache-2.0
// board_masks.c - every pixel is asked which is likelier: the plane's own colour there, or one of the object's colours.
//
// 1. A pixel's line of sight meets the plane in a place whose colour B is known. Within B's own steps about that place and
//    the noise the pixel is the plane; what lies far from it is the object.
// 2. What was found so gives a histogram of the object's colours, over all photographs.
// 3. log p(colour | object) - log p(colour | B), held within +-4, averaged over a small box: its sign is the mask; where it is
//    small all about there is no telling, as of a dark object before a black square.
//
// On a turntable the light of a place of the board changes from photograph to photograph. There a colour that could be s B,
// with s anywhere from a shadow's darkness to a little more than 1 and about the same in all channels, is no evidence.
#include "pose/board_masks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/parallel.h"
#include "base/pose3.h"

enum { GRID_PX = 8, BINS = 12, N_BINS = BINS * BINS * BINS };
enum {
    BRIDGED = 64
}; // pieces within this part of the picture's width of one another are one, whatever lies between

static const double speck = 0.03;      // of the largest piece's area
static const float most_evidence = 4;  // of one pixel, in logarithms of odds
static const float least_evidence = 1; // of the surest pixel about one that counts
static const float hardly =
    -2; // of a mask before it is held to 0..1: evidence against the object below this is heeded
static const float on_nearly_all_sides = 0.85f; // share
static const float least_noise = 0.012f;        // of a square root of light, print and resampling included
static const double board_margin =
    1.15;                       // of its half sides: its paper and the plate that it lies on turn, too
static const float far_off = 4; // in parts of the noise: certainly not the plane
static const float relit_least = 0.35f, relit_most = 1.2f; // s, of square roots of light
static const float relit_tint = 0.06f;                     // by which s differs between channels
static const float relit_share = 0.3f;                     // of the plane's places, on a turntable

// One photograph against the plane.
typedef struct view_job {
    const sheen_camera *camera;
    const sheen_plane_picture *plane;
    const sheen_plane_view *view;
    sheen_image *mask;
    const float *directions; // [rows][columns][3] in the camera's frame, every GRID_PX pixels
    int columns;
    sheen_Rt Rt_board_cam;
    double half_board_m[2];
    float gain, noise;        // gain: to the plane's exposure
    const sheen_image *still; // of the camera's size, square roots of light; negative: not known. NULL: none
    bool turned;
    const float *colours; // [N_BINS] log density of the object's colours; NULL: not known yet
} view_job;

static void root_of(float out[3], const float *rgb, float gain)
{
    for (int c = 0; c < 3; c++)
        out[c] = sqrtf(fmaxf(0, rgb[c])) * gain;
}

// Directions of the lines of sight on a coarse grid: lenses are smooth.
static sheen_status make_directions(float **out, int *columns, const sheen_camera *cam, sheen_err *err)
{
    const int w = cam->width_px / GRID_PX + 2, h = cam->height_px / GRID_PX + 2;
    const size_t n = (size_t)w * (size_t)h;
    double *q_px = malloc(2 * n * sizeof *q_px), *v_cam = malloc(3 * n * sizeof *v_cam);
    *out = malloc(3 * n * sizeof **out);
    *columns = w;
    sheen_status s = q_px && v_cam && *out ? SHEEN_OK
                                           : sheen_fail_memory(err, 52.0 * (double)n, "lines of sight");
    for (size_t i = 0; i < n && !s; i++) {
        q_px[2 * i] = GRID_PX * (double)(i % (size_t)w);
        q_px[2 * i + 1] = GRID_PX * (double)(i / (size_t)w);
    }
    if (!s)
        s = sheen_camera_unproject(cam, v_cam, q_px, n, err);
    for (size_t i = 0; i < 3 * n && !s; i++)
        (*out)[i] = (float)v_cam[i];
    free(q_px);
    free(v_cam);
    return s;
}

// Direction of a pixel's line of sight in the camera's frame.
static void line_of_sight(double d_cam[3], const view_job *j, int x, int y)
{
    const int i = x / GRID_PX, k = y / GRID_PX;
    const float *a = j->directions + 3 * (size_t)(k * j->columns + i), *b = a + 3 * (size_t)j->columns;
    const float u = (float)(x % GRID_PX) / GRID_PX, v = (float)(y % GRID_PX) / GRID_PX;
    for (int c = 0; c < 3; c++)
        d_cam[c] = (double)((1 - v) * ((1 - u) * a[c] + u * a[c + 3]) + v * ((1 - u) * b[c] + u * b[c + 3]));
}

// Where a line of sight meets the board's plane; false: nowhere.
static bool meet_plane(double q_m[2], const sheen_Rt *Rt_board_cam, const double d_cam[3])
{
    double d[3];
    sheen_Rt_direction(d, Rt_board_cam, d_cam);
    const double s = -Rt_board_cam->t[2] / d[2];
    for (int k = 0; k < 2; k++)
        q_m[k] = Rt_board_cam->t[k] + s * d[k];
    return s > 0 && isfinite(s);
}

static void begin_range(float low[3], float high[3])
{
    for (int c = 0; c < 3; c++) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
    }
}

static bool is_on_board(const view_job *j, const sheen_Rt *Rt_board_cam, const double d_cam[3])
{
    double q_m[2];
    return meet_plane(q_m, Rt_board_cam, d_cam) && fabs(q_m[0]) < board_margin * j->half_board_m[0] &&
           fabs(q_m[1]) < board_margin * j->half_board_m[1];
}

// Range of the colours about a pixel of what stands still, where the board does not lie.
static bool still_colours(float low[3], float high[3], const view_job *j, int x, int y)
{
    double d_cam[3];
    if (!j->still || x < 1 || y < 1 || x > j->camera->width_px - 2 || y > j->camera->height_px - 2)
        return false;
    line_of_sight(d_cam, j, x, y);
    if (is_on_board(j, &j->Rt_board_cam, d_cam))
        return false;
    begin_range(low, high);
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            const float *root = sheen_image_at(j->still, x + dx, y + dy);
            if (root[0] < 0)
                return false;
            for (int c = 0; c < 3; c++) {
                low[c] = fminf(low[c], root[c]);
                high[c] = fmaxf(high[c], root[c]);
            }
        }
    return true;
}

// Range of the plane's colours about the place that a pixel looks at; false where it is not known.
static bool plane_colours(float low[3], float high[3], const view_job *j, int x, int y)
{
    double d_cam[3], q_m[2];
    line_of_sight(d_cam, j, x, y);
    if (!meet_plane(q_m, &j->Rt_board_cam, d_cam))
        return false;
    const double px = (q_m[0] - j->plane->x0_m) / j->plane->pitch_m,
                 py = (q_m[1] - j->plane->y0_m) / j->plane->pitch_m;
    if (!(px >= 1 && py >= 1 && px < j->plane->rgb.width_px - 2 && py < j->plane->rgb.height_px - 2))
        return false;
    begin_range(low, high);
    const int x0 = (int)lround(px), y0 = (int)lround(py);
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            const float *B = sheen_image_at(&j->plane->rgb, x0 + dx, y0 + dy);
            if (B[0] < 0)
                return false;
            for (int c = 0; c < 3; c++) {
                low[c] = fminf(low[c], B[c]);
                high[c] = fmaxf(high[c], B[c]);
            }
        }
    return true;
}

static int bin_of(const float root[3])
{
    int bin = 0;
    for (int c = 0; c < 3; c++)
        bin = bin * BINS + (int)fminf(BINS - 1, root[c] * BINS);
    return bin;
}

// The largest of the channels' distances from the range, in parts of the noise.
static float excess(const view_job *j, const float root[3], const float low[3], const float high[3])
{
    float most = 0;
    for (int c = 0; c < 3; c++)
        most = fmaxf(most, fmaxf(low[c] - root[c], root[c] - high[c]));
    return most / j->noise;
}

// How far the colour is from the plane's in any light, in parts of the noise, and at which share s of its light it is nearest.
static float relit_excess(float *s_out, const view_job *j, const float root[3], const float low[3],
                          const float high[3])
{
    float along = 0, square = 1e-6f, relit_low[3], relit_high[3];
    for (int c = 0; c < 3; c++) {
        const float middle = 0.5f * (low[c] + high[c]);
        along += root[c] * middle;
        square += middle * middle;
    }
    const float s = fminf(relit_most, fmaxf(relit_least, along / square));
    for (int c = 0; c < 3; c++) {
        relit_low[c] = s * (1 - relit_tint) * low[c];
        relit_high[c] = s * (1 + relit_tint) * high[c];
    }
    *s_out = s;
    return excess(j, root, relit_low, relit_high);
}

// Logarithm of p(colour | plane): anywhere in the range, with Gaussian noise; and one pixel in a thousand of any colour.
static float log_plane(const view_job *j, const float root[3], const float low[3], const float high[3])
{
    const float z = excess(j, root, low, high);
    float spread = 1;
    for (int c = 0; c < 3; c++)
        spread *= 2.5066f * j->noise + high[c] - low[c];
    return logf(0.999f * expf(-0.5f * z * z) / spread + 0.001f);
}

// The same of the plane in any light: as above across the line of s B, and evenly along it.
static float log_relit_plane(const view_job *j, const float root[3], const float low[3], const float high[3])
{
    float s, spread = 1, square = 0, thickness = 0;
    const float z = relit_excess(&s, j, root, low, high);
    for (int c = 0; c < 3; c++) {
        const float wide = 2.5066f * j->noise + s * ((1 + relit_tint) * high[c] - (1 - relit_tint) * low[c]);
        spread *= wide;
        thickness += wide / 3;
        square += 0.25f * (low[c] + high[c]) * (low[c] + high[c]);
    }
    const float length = (relit_most - relit_least) * sqrtf(square);
    return logf(relit_share * expf(-0.5f * z * z) / (spread * fmaxf(1, length / thickness)) + 0.001f);
}

// For the object where positive, for the plane where negative. NaN: the plane only if its light were another one.
static float weigh(const view_job *j, const float root[3], const float low[3], const float high[3])
{
    const float object = j->colours[bin_of(root)];
    float evidence = object - log_plane(j, root, low, high);
    if (j->turned && evidence > 0) {
        evidence = fminf(evidence, object - log_relit_plane(j, root, low, high));
        if (evidence < 0)
            return NAN;
    }
    return fminf(most_evidence, fmaxf(-most_evidence, evidence));
}

// Rows of the evidence, NaN where the plane is not known. Without the object's colours: +-1 where it is certain, else 0.
static void weigh_rows(void *self, size_t begin, size_t end)
{
    const view_job *j = self;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < j->camera->width_px; x++) {
            float low[3], high[3], root[3], *out = sheen_image_at(j->mask, x, (int)y);
            *out = NAN;
            if (!still_colours(low, high, j, x, (int)y) && !plane_colours(low, high, j, x, (int)y))
                continue;
            root_of(root, sheen_image_at(j->view->rgb, x, (int)y), j->gain);
            if (!j->colours) {
                float s;
                const float z = excess(j, root, low, high);
                const float nearest = j->turned ? fminf(z, relit_excess(&s, j, root, low, high)) : z;
                *out = nearest > far_off ? 1.0f : z < 1 ? -1.0f : 0.0f;
                continue;
            }
            *out = weigh(j, root, low, high);
        }
}

// The photograph's exposure against the plane's picture, and its noise: medians over the pixels that look at the plane.
static sheen_status measure(view_job *j, sheen_err *err)
{
    const size_t most = (size_t)j->camera->width_px * (size_t)j->camera->height_px / (GRID_PX * GRID_PX) + 1;
    double *values = malloc(most * sizeof *values);
    if (!values)
        return sheen_fail_memory(err, 8.0 * (double)most, "a mask");
    for (int pass = 0; pass < 2; pass++) {
        size_t n = 0;
        for (int y = GRID_PX / 2; y < j->camera->height_px; y += GRID_PX)
            for (int x = GRID_PX / 2; x < j->camera->width_px && n < most; x += GRID_PX) {
                float low[3], high[3], root[3];
                if (!plane_colours(low, high, j, x, y))
                    continue;
                root_of(root, sheen_image_at(j->view->rgb, x, y), pass ? j->gain : 1);
                const double middle = 0.5 * (double)(low[1] + high[1]);
                if (pass)
                    values[n++] = (double)(excess(j, root, low, high) * j->noise);
                else if (root[1] > 0.05f && high[1] - low[1] < 0.1f)
                    values[n++] = middle / (double)root[1];
            }
        qsort(values, n, sizeof *values, sheen_ascending);
        if (pass == 0)
            j->gain = n ? (float)values[n / 2] : 1;
        else if (n) // half of the plane's own pixels lie below the median even where the object fills a third
            j->noise = fmaxf(least_noise, 1.4826f * (float)values[n / 2]);
    }
    free(values);
    return SHEEN_OK;
}

// What stands still before one camera: from its picture without the object, and where the board lay there from
// the photographs in which it does not lie there any more.
typedef struct still_job {
    const view_job *jobs; // those with the same picture without the object
    size_t n_jobs;
    const sheen_image *empty;
    sheen_Rt Rt_board_empty;
    float gain; // of the empty picture
    sheen_image *out;
} still_job;

enum { STILL_VIEWS = 32 };

static void still_rows(void *self, size_t begin, size_t end)
{
    const still_job *s = self;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < s->out->width_px; x++) {
            float *out = sheen_image_at(s->out, x, (int)y), rgb[STILL_VIEWS][3];
            double d_cam[3];
            int n = 0;
            line_of_sight(d_cam, s->jobs, x, (int)y);
            if (!is_on_board(s->jobs, &s->Rt_board_empty, d_cam)) {
                root_of(out, sheen_image_at(s->empty, x, (int)y), s->gain);
                continue;
            }
            for (size_t v = 0; v < s->n_jobs && n < STILL_VIEWS; v++)
                if (!is_on_board(&s->jobs[v], &s->jobs[v].Rt_board_cam, d_cam))
                    root_of(rgb[n++], sheen_image_at(s->jobs[v].view->rgb, x, (int)y), s->jobs[v].gain);
            if (!sheen_colours_agree(out, rgb, n))
                out[0] = out[1] = out[2] = -1;
        }
}

// The exposure of the picture without the object against the plane's: the median over the board.
static sheen_status measure_empty(still_job *s, sheen_err *err)
{
    view_job as_view = s->jobs[0];
    as_view.view = s->jobs[0].view->empty;
    as_view.Rt_board_cam = s->Rt_board_empty;
    const sheen_status status = measure(&as_view, err);
    s->gain = as_view.gain;
    return status;
}

// jobs[n_jobs], neighbours with one picture without the object, get *out, which they are lent.
static sheen_status make_still(sheen_image *out, view_job *jobs, size_t n_jobs, int n_threads, sheen_err *err)
{
    still_job s = {.jobs = jobs, .n_jobs = n_jobs, .empty = jobs[0].view->empty->rgb, .out = out};
    sheen_Rt Rt_cam_board;
    sheen_Rt_from_rt(&Rt_cam_board, jobs[0].view->empty->rt_cam_board);
    sheen_Rt_invert(&s.Rt_board_empty, &Rt_cam_board);
    sheen_status status = sheen_image_init(out, jobs[0].camera->width_px, jobs[0].camera->height_px, 3, err);
    if (!status)
        status = measure_empty(&s, err);
    if (!status)
        sheen_parallel_for((size_t)out->height_px, 16, n_threads, still_rows, &s);
    for (size_t v = 0; v < n_jobs; v++)
        jobs[v].still = out;
    return status;
}

static sheen_status make_stills(sheen_image *stills, view_job *jobs, size_t n_views, int n_threads,
                                sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    for (size_t v = 0, end; v < n_views && !s; v = end) {
        for (end = v + 1; end < n_views && jobs[end].view->empty == jobs[v].view->empty;)
            end++;
        if (jobs[v].view->empty)
            s = make_still(&stills[v], jobs + v, end - v, n_threads, err);
    }
    return s;
}

// Log density of the colours of all pixels that are certainly the object's; one in ten may have any.
static void learn_colours(float colours[N_BINS], const view_job *jobs, size_t n_views)
{
    size_t *counts = calloc(N_BINS, sizeof *counts), total = 0;
    for (size_t v = 0; v < n_views && counts; v++)
        for (int y = 0; y < jobs[v].camera->height_px; y++)
            for (int x = 0; x < jobs[v].camera->width_px; x++)
                if (*sheen_image_at(jobs[v].mask, x, y) > 0.5f) {
                    float root[3];
                    root_of(root, sheen_image_at(jobs[v].view->rgb, x, y), jobs[v].gain);
                    counts[bin_of(root)]++;
                    total++;
                }
    for (int i = 0; i < N_BINS; i++) {
        const double share = total ? (double)counts[i] / (double)total : 0;
        colours[i] = (float)log(0.9 * share * N_BINS + 0.1);
    }
    free(counts);
}

// Means over boxes of 2 r + 1, of what is known; NaN where less than half is. And the strongest of |.| instead.
static void box_rows(float *out, const float *in, int w, int h, int r, bool strongest)
{
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            float sum = 0, most = 0;
            int n = 0;
            for (int i = x - r; i <= x + r; i++) {
                const float v = i >= 0 && i < w ? in[(size_t)y * (size_t)w + (size_t)i] : NAN;
                if (isnan(v))
                    continue;
                sum += v;
                most = fmaxf(most, fabsf(v));
                n++;
            }
            out[(size_t)y * (size_t)w + (size_t)x] = 2 * n <= 2 * r + 1 ? NAN
                                                     : strongest        ? most
                                                                        : sum / (float)n;
        }
}

static void transpose(float *out, const float *in, int w, int h)
{
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
            out[(size_t)x * (size_t)h + (size_t)y] = in[(size_t)y * (size_t)w + (size_t)x];
}

static void box(float *data, float *room, int w, int h, int r, bool strongest)
{
    box_rows(room, data, w, h, r, strongest);
    transpose(data, room, w, h);
    box_rows(room, data, h, w, r, strongest);
    transpose(data, room, h, w);
}

// Gives every pixel of a piece of `near` its number from 1 on, and returns that of the one with the most evidence for the
// object; 0: there is none. stack: [w * h].
static int32_t number_pieces(int32_t *number, int32_t *stack, const float *near, const float *evidence, int w,
                             int h)
{
    int32_t n_pieces = 0, largest = 0;
    size_t most = 0;
    memset(number, 0, (size_t)w * (size_t)h * sizeof *number);
    for (int32_t start = 0; start < w * h; start++) {
        if (number[start] || !(near[start] > 0))
            continue;
        size_t n = 0, area = 0;
        number[start] = ++n_pieces;
        stack[n++] = start;
        while (n) {
            const int32_t at = stack[--n], x = at % w, beside[4] = {at - 1, at + 1, at - w, at + w};
            const bool within[4] = {x > 0, x < w - 1, at >= w, at < w * (h - 1)};
            area += evidence[at] > 0;
            for (int k = 0; k < 4; k++)
                if (within[k] && !number[beside[k]] && near[beside[k]] > 0) {
                    number[beside[k]] = n_pieces;
                    stack[n++] = beside[k];
                }
        }
        if (area > most) {
            most = area;
            largest = n_pieces;
        }
    }
    return largest;
}

// counts[k]: pixels that have number k. Room for [n + 1] where all have different ones.
static void count_pixels(int32_t *counts, const int32_t *number, size_t n)
{
    memset(counts, 0, (n + 1) * sizeof *counts);
    for (size_t i = 0; i < n; i++)
        counts[number[i]]++;
}

// What cannot be told, or hardly, and has the object on nearly all sides (as where it stands before the board's edge) is the object.
// room, share: [w * h] each.
static void close_gaps(sheen_image *mask, float *share, float *room, int r)
{
    const int w = mask->width_px, h = mask->height_px;
    const size_t n = (size_t)w * (size_t)h;
    for (size_t i = 0; i < n; i++) {
        const float m = mask->data[i];
        share[i] = m > 0.5f ? 1 : m <= hardly ? 0 : NAN;
    }
    box(share, room, w, h, 3 * r, false);
    for (size_t i = 0; i < n; i++)
        if (!(mask->data[i] > 0.5f) && !(mask->data[i] <= hardly) && share[i] > on_nearly_all_sides)
            mask->data[i] = 1;
}

// Evidence to a mask: smoothed, its largest piece, from 0 to 1. with_gaps: much is not known all
// about; what is not told is left so, and beside the object it is the plane in a shadow sooner than the object.
static sheen_status finish(sheen_image *mask, bool with_gaps, sheen_err *err)
{
    const int w = mask->width_px, h = mask->height_px, r = w / 640 > 1 ? w / 640 : 1;
    const size_t n = (size_t)w * (size_t)h;
    float *sure = malloc(n * sizeof *sure), *room = malloc(n * sizeof *room),
          *near = malloc(n * sizeof *near);
    int32_t *number = malloc(n * sizeof *number), *stack = malloc((n + 1) * sizeof *stack);
    sheen_status s = sure && room && near && number && stack
                         ? SHEEN_OK
                         : sheen_fail_memory(err, 20.0 * (double)n, "a mask");
    if (!s) {
        box(mask->data, room, w, h, r, false);
        memcpy(sure, mask->data, n * sizeof *sure);
        box(sure, room, w, h, 3 * r, true);
        // Specks, such as where a tag's edges are not matched to the pixel, bridge nothing.
        const int32_t largest = number_pieces(number, stack, mask->data, mask->data, w, h);
        count_pixels(stack, number, n);
        for (size_t i = 0; i < n; i++)
            near[i] = number[i] && (double)stack[number[i]] >= speck * (double)stack[largest] ? 1 : 0;
        box(near, room, w, h, w / BRIDGED, true);
        const int32_t object = number_pieces(number, stack, near, mask->data, w, h);
        for (size_t i = 0; i < n; i++) {
            const float e = mask->data[i];
            const bool told = sure[i] > least_evidence && (e <= 0 || (object && number[i] == object));
            mask->data[i] = told && !(isnan(e) && !with_gaps) ? fmaxf(hardly, 0.5f + 2 * e) : NAN;
        }
        if (!with_gaps)
            close_gaps(mask, sure, room, r);
        for (size_t i = 0; i < n; i++)
            mask->data[i] = isnan(mask->data[i]) ? NAN : fminf(1, fmaxf(0, mask->data[i]));
    }
    free(sure);
    free(room);
    free(near);
    free(number);
    free(stack);
    return s;
}

static sheen_status begin_job(view_job *j, const sheen_board *board, sheen_err *err)
{
    sheen_Rt Rt_cam_board;
    j->half_board_m[0] = 0.5 * board->n_cols * board->square_m;
    j->half_board_m[1] = 0.5 * board->n_rows * board->square_m;
    sheen_Rt_from_rt(&Rt_cam_board, j->view->rt_cam_board);
    sheen_Rt_invert(&j->Rt_board_cam, &Rt_cam_board);
    const sheen_status s = sheen_image_init(j->mask, j->camera->width_px, j->camera->height_px, 1, err);
    return s ? s : measure(j, err);
}

// Masks of jobs whose planes and still surroundings are known: first what is certain, then all by the object's colours.
static sheen_status weigh_all(view_job *jobs, size_t n_views, int n_threads, sheen_err *err)
{
    float colours[N_BINS];
    sheen_status s = SHEEN_OK;
    for (size_t v = 0; v < n_views; v++)
        sheen_parallel_for((size_t)jobs[v].camera->height_px, 16, n_threads, weigh_rows, &jobs[v]);
    learn_colours(colours, jobs, n_views);
    for (size_t v = 0; v < n_views && !s; v++) {
        jobs[v].colours = colours;
        sheen_parallel_for((size_t)jobs[v].camera->height_px, 16, n_threads, weigh_rows, &jobs[v]);
        s = finish(jobs[v].mask, !jobs[v].still, err);
    }
    return s;
}

sheen_status sheen_board_masks_make(sheen_image *masks, const sheen_camera *camera, const sheen_board *board,
                                    const sheen_plane_view *views, size_t n_views, bool turned, int n_threads,
                                    sheen_err *err)
{
    sheen_plane_picture plane;
    float *directions = NULL;
    int columns = 0;
    memset(masks, 0, n_views * sizeof *masks);
    view_job *jobs = calloc(n_views + 1, sizeof *jobs);
    sheen_image *stills = calloc(n_views + 1, sizeof *stills);
    if (!jobs || !stills) {
        free(jobs);
        free(stills);
        return sheen_fail_memory(err, (double)n_views * sizeof *jobs, "masks");
    }
    sheen_status s = sheen_plane_picture_make(&plane, camera, board, views, n_views, n_threads, err);
    if (!s)
        s = make_directions(&directions, &columns, camera, err);
    for (size_t v = 0; v < n_views && !s; v++) {
        jobs[v] = (view_job){camera,          &plane,  &views[v], &masks[v],
                             directions,      columns, .gain = 1, .noise = least_noise,
                             .turned = turned};
        s = begin_job(&jobs[v], board, err);
    }
    if (!s)
        s = make_stills(stills, jobs, n_views, n_threads, err);
    if (!s)
        s = weigh_all(jobs, n_views, n_threads, err);
    for (size_t v = 0; v < n_views; v++) {
        sheen_image_release(&stills[v]);
        if (s)
            sheen_image_release(&masks[v]);
    }
    free(directions);
    free(jobs);
    free(stills);
    sheen_plane_picture_release(&plane);
    return s;
}
