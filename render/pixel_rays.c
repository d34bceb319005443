// SPDX-License-Identifier: Apache-2.0
// pixel_rays.c - directions through many points of an image, fast for any lens.
//
// A pinhole has a formula. Any other model's inverse is an iteration of about a microsecond a point, so it is
// run on a grid of one point in 16 x 16 pixels, and between grid points unit directions are interpolated by
// cubics (four points each way). Each cell is checked at its middle and at the middles of two sides: where
// the interpolation is off by more than a quarter of SHEEN_PIXEL_RAYS_ERROR_PX, all points of that cell go
// through the model. Where those are more than a few cells, a finer grid costs less: 8 x 8, then 4 x 4.
#include "render/pixel_rays.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu_level.h"
#include "base/parallel.h"
#include "base/vec.h"

enum { MAX_STEP = 16, MIN_STEP = 4, MAX_ROW = 64, MAX_NODES = MAX_ROW / MIN_STEP + 6 };

// Weights of the points at -1, 0, 1, 2 for a place 0..1 (Lagrange).
static void cubic_weights(double w[4], double t)
{
    w[0] = -t * (t - 1) * (t - 2) / 6;
    w[1] = (t + 1) * (t - 1) * (t - 2) / 2;
    w[2] = -(t + 1) * t * (t - 2) / 2;
    w[3] = (t + 1) * t * (t - 1) / 6;
}

static sheen_status unproject(const sheen_pixel_rays *r, double *v_obj, const double *q_px, int n,
                              sheen_err *err)
{
    const sheen_status s = sheen_camera_unproject(r->cam, v_obj, q_px, (size_t)n, err);
    for (int i = 0; i < n && !s; i++)
        sheen_Rt_direction(v_obj + 3 * (size_t)i, &r->Rt_obj_cam, v_obj + 3 * (size_t)i);
    return s;
}

typedef struct job {
    sheen_pixel_rays *rays;
    atomic_int failed;
} job;

static void fill_rows(void *self, size_t begin, size_t end)
{
    job *j = self;
    sheen_pixel_rays *r = j->rays;
    double q[MAX_ROW][2];
    for (size_t row = begin; row < end; row++)
        for (int first = 0; first < r->n_columns; first += MAX_ROW) {
            const int n = r->n_columns - first < MAX_ROW ? r->n_columns - first : MAX_ROW;
            for (int i = 0; i < n; i++) {
                q[i][0] = r->x0_px + r->step_px * (double)(first + i);
                q[i][1] = r->y0_px + r->step_px * (double)row;
            }
            if (unproject(r, r->v_obj + 3 * (row * (size_t)r->n_columns + (size_t)first), q[0], n, NULL))
                atomic_store(&j->failed, 1);
        }
}

// Interpolates at (column + tx, row + ty), in cells of the grid; not normalised.
static void interpolate(const sheen_pixel_rays *r, double v[3], int column, int row, double tx, double ty)
{
    double wx[4], wy[4];
    cubic_weights(wx, tx);
    cubic_weights(wy, ty);
    v[0] = v[1] = v[2] = 0;
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++) {
            const size_t node = (size_t)(row - 1 + j) * (size_t)r->n_columns + (size_t)(column - 1 + i);
            for (int k = 0; k < 3; k++)
                v[k] += wy[j] * wx[i] * r->v_obj[3 * node + (size_t)k];
        }
}

static double angle_between(const double a[3], const double b[3])
{
    double across[3];
    sheen_cross(across, a, b);
    return atan2(sheen_norm(across), sheen_dot(a, b));
}

static void check_rows(void *self, size_t begin, size_t end)
{
    static const double at[3][2] = {{0.5, 0.5}, {0.5, 0}, {0, 0.5}};
    job *j = self;
    sheen_pixel_rays *r = j->rays;
    for (size_t row = begin + 1; row < end + 1; row++)
        for (int column = 1; column < r->n_columns - 2; column++) {
            const size_t node = row * (size_t)r->n_columns + (size_t)column;
            const double *v = r->v_obj + 3 * node;
            const double rad_per_px =
                fmin(angle_between(v, v + 3), angle_between(v, v + 3 * (size_t)r->n_columns)) / r->step_px;
            double q[3][2], want[3][3], worst_rad = 0;
            for (int k = 0; k < 3; k++) {
                q[k][0] = r->x0_px + r->step_px * (column + at[k][0]);
                q[k][1] = r->y0_px + r->step_px * ((double)row + at[k][1]);
            }
            if (unproject(r, want[0], q[0], 3, NULL))
                atomic_store(&j->failed, 1);
            for (int k = 0; k < 3; k++) {
                double got[3];
                interpolate(r, got, column, (int)row, at[k][0], at[k][1]);
                const double off_rad = angle_between(got, want[k]);
                worst_rad = off_rad <= worst_rad ? worst_rad : off_rad; // keeps NaN
            }
            r->smooth[node] = worst_rad <= 0.25 * SHEEN_PIXEL_RAYS_ERROR_PX * rad_per_px;
        }
}

// Lays the grid over the pixels, fills and checks it.
static sheen_status make_grid(sheen_pixel_rays *r, const int window_px[4], int step_px, int n_threads,
                              sheen_err *err)
{
    r->step_px = step_px;
    r->x0_px = window_px[0] - 0.5 - step_px;
    r->y0_px = window_px[1] - 0.5 - step_px;
    r->n_columns = (window_px[2] + step_px - 1) / step_px + 4;
    r->n_rows = (window_px[3] + step_px - 1) / step_px + 4;
    const size_t n = (size_t)r->n_columns * (size_t)r->n_rows;
    r->v_obj = malloc(n * 3 * sizeof *r->v_obj);
    r->smooth = calloc(n, sizeof *r->smooth); // none until checked
    if (!r->v_obj || !r->smooth)
        return sheen_fail_memory(err, 25.0 * (double)n, "the directions through an image");
    job j = {.rays = r};
    atomic_init(&j.failed, 0);
    sheen_parallel_for((size_t)r->n_rows, 1, n_threads, fill_rows, &j);
    sheen_parallel_for((size_t)r->n_rows - 3, 1, n_threads, check_rows, &j);
    if (atomic_load(&j.failed))
        return sheen_fail(err, SHEEN_EARG, "the lens model '%s' could not be inverted", r->cam->lensmodel);
    return SHEEN_OK;
}

static bool is_smooth(const sheen_pixel_rays *r)
{
    int n_rough = 0;
    for (int row = 1; row < r->n_rows - 2; row++)
        for (int column = 1; column < r->n_columns - 2; column++)
            n_rough += !r->smooth[row * r->n_columns + column];
    return n_rough <= (r->n_rows - 3) * (r->n_columns - 3) / 50;
}

static void drop_grid(sheen_pixel_rays *r)
{
    free(r->v_obj);
    free(r->smooth);
    r->v_obj = NULL;
    r->smooth = NULL;
}

sheen_status sheen_pixel_rays_init(sheen_pixel_rays *r, const sheen_camera *cam, const double rt_cam_obj[6],
                                   const int window_px[4], int n_threads, sheen_err *err)
{
    *r = (sheen_pixel_rays){.cam = cam, .pinhole = !strcmp(cam->lensmodel, "LENSMODEL_PINHOLE")};
    sheen_Rt Rt_cam_obj;
    sheen_Rt_from_rt(&Rt_cam_obj, rt_cam_obj);
    sheen_Rt_invert(&r->Rt_obj_cam, &Rt_cam_obj);
    if (r->pinhole)
        return SHEEN_OK;
    sheen_status s = make_grid(r, window_px, MAX_STEP, n_threads, err);
    for (int step_px = MAX_STEP / 2; !s && step_px >= MIN_STEP && !is_smooth(r); step_px /= 2) {
        drop_grid(r);
        s = make_grid(r, window_px, step_px, n_threads, err);
    }
    if (s)
        sheen_pixel_rays_release(r);
    return s;
}

void sheen_pixel_rays_release(sheen_pixel_rays *r)
{
    drop_grid(r);
    *r = (sheen_pixel_rays){0};
}

// Coefficients of the cubic through four points at t = -1, 0, 1, 2.
static void cubic_through(double c[4][3], const double p[4][3])
{
    for (int k = 0; k < 3; k++) {
        c[0][k] = p[1][k];
        c[1][k] = -p[0][k] / 3 - p[1][k] / 2 + p[2][k] - p[3][k] / 6;
        c[2][k] = p[0][k] / 2 - p[1][k] + p[2][k] / 2;
        c[3][k] = -p[0][k] / 6 + p[1][k] / 2 - p[2][k] / 2 + p[3][k] / 6;
    }
}

// Unit vectors along the cubic c[0] + t c[1] + t^2 c[2] + t^3 c[3] for t = t0 + i dt.
SHEEN_KERNEL_INLINE void emit_body(float *v_obj, double c[4][3], double t0, double dt, int n)
{
#pragma omp simd
    for (int i = 0; i < n; i++) {
        const double t = t0 + i * dt;
        const float x = (float)(c[0][0] + t * (c[1][0] + t * (c[2][0] + t * c[3][0])));
        const float y = (float)(c[0][1] + t * (c[1][1] + t * (c[2][1] + t * c[3][1])));
        const float z = (float)(c[0][2] + t * (c[1][2] + t * (c[2][2] + t * c[3][2])));
        const float scale = 1.0f / sqrtf(x * x + y * y + z * z);
        float *to = v_obj + 3 * (size_t)i;
        to[0] = x * scale;
        to[1] = y * scale;
        to[2] = z * scale;
    }
}

static void emit_baseline(float *v_obj, double c[4][3], double t0, double dt, int n)
{
    emit_body(v_obj, c, t0, dt, n);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX2 static void emit_avx2(float *v_obj, double c[4][3], double t0, double dt, int n)
{
    emit_body(v_obj, c, t0, dt, n);
}

SHEEN_TARGET_AVX512 static void emit_avx512(float *v_obj, double c[4][3], double t0, double dt, int n)
{
    emit_body(v_obj, c, t0, dt, n);
}
#endif

static void emit(float *v_obj, double c[4][3], double t0, double dt, int n)
{
#if defined(__x86_64__)
    const int level = sheen_cpu_level();
    if (level >= SHEEN_CPU_AVX512) {
        emit_avx512(v_obj, c, t0, dt, n);
        return;
    }
    if (level == SHEEN_CPU_AVX2) {
        emit_avx2(v_obj, c, t0, dt, n);
        return;
    }
#endif
    emit_baseline(v_obj, c, t0, dt, n);
}

static void row_pinhole(const sheen_pixel_rays *r, float *v_obj, double x_px, double y_px, double dx_px,
                        int n)
{
    const double *fxycxy = r->cam->intrinsics;
    const double first_cam[3] = {(x_px - fxycxy[2]) / fxycxy[0], (y_px - fxycxy[3]) / fxycxy[1], 1};
    const double step_cam[3] = {dx_px / fxycxy[0], 0, 0};
    double c[4][3] = {{0}};
    sheen_Rt_direction(c[0], &r->Rt_obj_cam, first_cam);
    sheen_Rt_direction(c[1], &r->Rt_obj_cam, step_cam);
    emit(v_obj, c, 0, 1, n);
}

void sheen_pixel_rays_row_ref(const sheen_pixel_rays *r, float *v_obj, double x_px, double y_px, double dx_px,
                              int n)
{
    assert(n > 0 && n <= MAX_ROW);
    double q[MAX_ROW][2] = {{0}}, v[MAX_ROW][3];
    for (int i = 0; i < n; i++) {
        q[i][0] = x_px + i * dx_px;
        q[i][1] = y_px;
    }
    const sheen_status s = unproject(r, v[0], q[0], n, NULL);
    for (int i = 0; i < n; i++) {
        if (s) // cannot be: the grid went through the same model
            v[i][0] = v[i][1] = v[i][2] = (double)NAN;
        for (int k = 0; k < 3; k++)
            v_obj[3 * i + k] = (float)v[i][k];
    }
}

void sheen_pixel_rays_row(const sheen_pixel_rays *r, float *v_obj, double x_px, double y_px, double dx_px,
                          int n)
{
    assert(n <= MAX_ROW && dx_px <= 1);
    if (r->pinhole) {
        row_pinhole(r, v_obj, x_px, y_px, dx_px, n);
        return;
    }
    // The grid's rows melt into one at this y; then each point takes four of it.
    const double gx = (x_px - r->x0_px) / r->step_px, gy = (y_px - r->y0_px) / r->step_px;
    const double dg = dx_px / r->step_px;
    const int row = (int)gy, first = (int)gx - 1;
    const int n_nodes = (int)(gx + dg * (n - 1)) + 2 - first + 1;
    assert(row >= 1 && row + 2 < r->n_rows && first >= 0 && n_nodes <= MAX_NODES &&
           first + n_nodes <= r->n_columns);
    double melted[MAX_NODES][3] = {{0}}, w[4];
    cubic_weights(w, gy - row);
    for (int j = 0; j < 4; j++) {
        const double *v = r->v_obj + 3 * ((size_t)(row - 1 + j) * (size_t)r->n_columns + (size_t)first);
        for (int i = 0; i < n_nodes; i++)
            for (int k = 0; k < 3; k++)
                melted[i][k] += w[j] * v[3 * i + k];
    }
    const bool *smooth = r->smooth + (size_t)row * (size_t)r->n_columns;
    for (int i = 0, next; i < n; i = next) { // the points of one cell after another
        const int column = (int)(gx + dg * i);
        for (next = i + 1; next < n && (int)(gx + dg * next) == column;)
            next++;
        if (!smooth[column]) {
            sheen_pixel_rays_row_ref(r, v_obj + 3 * (size_t)i, x_px + i * dx_px, y_px, dx_px, next - i);
            continue;
        }
        double c[4][3];
        cubic_through(c, (const double(*)[3])melted + (column - 1 - first));
        emit(v_obj + 3 * (size_t)i, c, gx + dg * i - column, dg, next - i);
    }
}
