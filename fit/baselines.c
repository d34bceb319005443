// SPDX-License-Identifier: Apache-2.0
// baselines.c - minimum, median, mean and blended textures from the same samples.
#include "fit/baselines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"

enum { MAX_VIEWS = 1024 }; // that a texel's colour is taken over; more are not looked at

const char *sheen_baseline_name(sheen_baseline b)
{
    static const char *const names[SHEEN_BASELINE_COUNT] = {"minimum", "median", "mean", "blend of 3"};
    return names[b];
}

sheen_status sheen_texel_views_make(sheen_texel_views *out, const sheen_mesh *mesh, const sheen_scene *scene,
                                    const sheen_photos *photos, int texels_per_edge, int n_threads,
                                    const sheen_progress *progress, sheen_err *err)
{
    *out = (sheen_texel_views){.n_triangles = mesh->n_triangles, .texels_per_edge = texels_per_edge};
    out->n_views = photos->count < MAX_VIEWS ? photos->count : MAX_VIEWS;
    out->views = calloc(out->n_views + 1, sizeof *out->views);
    out->p_camera_obj = calloc(out->n_views + 1, sizeof *out->p_camera_obj);
    sheen_status s = SHEEN_OK;
    if (!out->views || !out->p_camera_obj)
        s = sheen_fail_memory(err, 40.0 * (double)out->n_views, "views");
    for (size_t i = 0; i < out->n_views && !s; i++) {
        sheen_gbuffer g = {0};
        if ((s = sheen_progress_step(progress, "baselines", (int)i, (int)out->n_views, err)) ||
            (s = sheen_texel_view_init(&out->views[i], mesh->n_triangles, texels_per_edge, err)) ||
            (s = sheen_gbuffer_make(&g, scene, mesh, &photos->cam, photos->photos[i].rt_cam_obj, 1, n_threads,
                                    err)))
            break;
        sheen_texel_view_fill(&out->views[i], mesh, scene, &g, &photos->cam, &photos->photos[i],
                              texels_per_edge, n_threads);
        memcpy(out->p_camera_obj[i], g.p_camera_obj, sizeof g.p_camera_obj);
        sheen_gbuffer_release(&g);
    }
    if (s)
        sheen_texel_views_release(out);
    return s;
}

void sheen_texel_views_release(sheen_texel_views *v)
{
    for (size_t i = 0; v->views && i < v->n_views; i++)
        sheen_texel_view_release(&v->views[i]);
    free(v->views);
    free(v->p_camera_obj);
    *v = (sheen_texel_views){0};
}

typedef struct job {
    sheen_texture *out;
    sheen_baseline baseline;
    const sheen_mesh *mesh;
    const sheen_texel_views *v;
    float p_camera_obj[3];
} job;

static float median(float *x, size_t n)
{
    for (size_t i = 1; i < n; i++) { // insertion sort: a handful of views
        const float value = x[i];
        size_t k = i;
        for (; k && x[k - 1] > value; k--)
            x[k] = x[k - 1];
        x[k] = value;
    }
    return n % 2 ? x[n / 2] : 0.5f * (x[n / 2 - 1] + x[n / 2]);
}

static void take_minimum(float out[3], const float *const *rgb, size_t n)
{
    const float *least = rgb[0];
    for (size_t i = 1; i < n; i++)
        if (sheen_luminance(rgb[i]) < sheen_luminance(least))
            least = rgb[i];
    memcpy(out, least, 3 * sizeof *out);
}

static void take_median(float out[3], const float *const *rgb, size_t n)
{
    float x[MAX_VIEWS];
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            x[i] = rgb[i][c];
        out[c] = median(x, n);
    }
}

static void take_mean(float out[3], const float *const *rgb, size_t n)
{
    for (size_t c = 0; c < 3; c++) {
        double sum = 0;
        for (size_t i = 0; i < n; i++)
            sum += (double)rgb[i][c];
        out[c] = (float)(sum / (double)n);
    }
}

// Angle at p between the direction to the new camera and that to camera `view`.
static double view_angle_rad(const job *j, const float p_obj[3], size_t view)
{
    double a[3], b[3];
    for (int i = 0; i < 3; i++) {
        a[i] = (double)(j->p_camera_obj[i] - p_obj[i]);
        b[i] = j->v->p_camera_obj[view][i] - (double)p_obj[i];
    }
    sheen_normalize(a);
    sheen_normalize(b);
    return acos(fmax(-1, fmin(1, sheen_dot(a, b))));
}

static void take_blend(float out[3], const job *j, const float p_obj[3], const float *const *rgb,
                       const size_t *view, size_t n)
{
    double nearest[4] = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
    size_t which[4] = {0, 0, 0, 0};
    for (size_t i = 0; i < n; i++) {
        const double a = view_angle_rad(j, p_obj, view[i]);
        int k = 4;
        for (; k && a < nearest[k - 1]; k--)
            if (k < 4) {
                nearest[k] = nearest[k - 1];
                which[k] = which[k - 1];
            }
        if (k < 4) {
            nearest[k] = a;
            which[k] = i;
        }
    }
    double sum[3] = {0, 0, 0}, total = 0;
    for (size_t i = 0; i < 3 && i < n; i++) {
        const double fade = n > 3 ? 1 - nearest[i] / fmax(nearest[3], 1e-9) : 1;
        const double w = (fade + 1e-6) / fmax(nearest[i], 1e-4);
        for (size_t c = 0; c < 3; c++)
            sum[c] += w * (double)rgb[which[i]][c];
        total += w;
    }
    for (size_t c = 0; c < 3; c++)
        out[c] = (float)(sum[c] / total);
}

static void fill(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const size_t per_triangle = sheen_texels_per_triangle(j->v->texels_per_edge);
    float p_obj[3 * SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2] = {0};
    const float *rgb[MAX_VIEWS];
    size_t view[MAX_VIEWS];
    for (size_t f = begin; f < end; f++) {
        if (j->baseline == SHEEN_BASELINE_BLEND)
            sheen_texture_lattice(j->mesh, f, j->v->texels_per_edge, p_obj, NULL);
        for (size_t k = 0; k < per_triangle; k++) {
            const size_t texel = f * per_triangle + k;
            size_t n = 0;
            for (size_t i = 0; i < j->v->n_views; i++)
                if (j->v->views[i].seen[texel]) {
                    view[n] = i;
                    rgb[n++] = j->v->views[i].rgb + 3 * texel;
                }
            j->out->n_views[texel] = (uint8_t)(n < 255 ? n : 255);
            float *out = j->out->rgb + 3 * texel;
            if (!n)
                continue;
            if (j->baseline == SHEEN_BASELINE_MINIMUM)
                take_minimum(out, rgb, n);
            else if (j->baseline == SHEEN_BASELINE_MEDIAN)
                take_median(out, rgb, n);
            else if (j->baseline == SHEEN_BASELINE_MEAN)
                take_mean(out, rgb, n);
            else
                take_blend(out, j, p_obj + 3 * k, rgb, view, n);
        }
    }
}

sheen_status sheen_baseline_texture(sheen_texture *out, sheen_baseline b, const sheen_mesh *mesh,
                                    const sheen_texel_views *v, const double p_camera_obj[3], int n_threads,
                                    sheen_err *err)
{
    const sheen_status s = sheen_texture_init(out, v->n_triangles, v->texels_per_edge, err);
    if (s)
        return s;
    job j = {.out = out, .baseline = b, .mesh = mesh, .v = v};
    for (int i = 0; i < 3; i++)
        j.p_camera_obj[i] = (float)p_camera_obj[i];
    sheen_parallel_for(v->n_triangles, 256, n_threads, fill, &j);
    return SHEEN_OK;
}
