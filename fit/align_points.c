// SPDX-License-Identifier: Apache-2.0
// align_points.c - chooses among the texels by visibility and by how strong the pictures' edges are there.
#include "fit/align_points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "fit/texel_view.h"

enum { CANDIDATES = 200000, OBSERVATIONS = 480000, MOST_POINTS = 40000 };

static const float slant_limit = 0.35f; // points seen at less than this cosine move too much with any error

typedef struct choice {
    const sheen_photos *photos;
    const sheen_mesh *mesh;
    int edge;
    size_t step, n_candidates;
    float *p_obj, *n_obj; // [n_candidates][3]
    uint8_t *seen;        // [n_views][n_candidates]
    float *strength;      // [n_candidates] the strongest edge, linear light a pixel
} choice;

static sheen_status list_candidates(choice *c, sheen_err *err)
{
    const size_t per = sheen_texels_per_triangle(c->edge), n = c->mesh->n_triangles * per;
    c->step = 1 + n / CANDIDATES;
    c->n_candidates = (n + c->step - 1) / c->step;
    c->p_obj = malloc(3 * c->n_candidates * sizeof *c->p_obj);
    c->n_obj = malloc(3 * c->n_candidates * sizeof *c->n_obj);
    c->seen = calloc(c->photos->count * c->n_candidates, 1);
    c->strength = calloc(c->n_candidates, sizeof *c->strength);
    float *p = malloc(6 * per * sizeof *p);
    const int enough = c->p_obj && c->n_obj && c->seen && c->strength && p;
    size_t last = SIZE_MAX;
    for (size_t i = 0; i < c->n_candidates && enough; i++) {
        const size_t texel = i * c->step, triangle = texel / per, k = texel % per;
        if (triangle != last)
            sheen_texture_lattice(c->mesh, triangle, c->edge, p, p + 3 * per);
        last = triangle;
        memcpy(c->p_obj + 3 * i, p + 3 * k, 3 * sizeof *p);
        memcpy(c->n_obj + 3 * i, p + 3 * (per + k), 3 * sizeof *p);
    }
    free(p);
    return enough
               ? SHEEN_OK
               : sheen_fail_memory(err, 40.0 * (double)c->n_candidates, "points to compare photographs on");
}

// How much the luminance changes over two pixels about a place, at most; 0 outside.
static float edge_strength(const sheen_image *image, const double q_px[2])
{
    float least = HUGE_VALF, most = 0;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            float rgb[3];
            if (!sheen_image_bilinear(rgb, image, q_px[0] + dx, q_px[1] + dy))
                return 0;
            const float Y = sheen_luminance(rgb);
            least = fminf(least, Y);
            most = fmaxf(most, Y);
        }
    return most - least;
}

typedef struct look_job {
    choice *c;
    const sheen_texel_view *v;
    const sheen_photo *photo;
    size_t view;
    sheen_Rt Rt_cam_obj;
    float camera_obj[3];
} look_job;

static void look_at(void *self, size_t begin, size_t end)
{
    const look_job *j = self;
    choice *c = j->c;
    for (size_t i = begin; i < end; i++) {
        if (!j->v->seen[i * c->step])
            continue;
        const float *p = c->p_obj + 3 * i;
        float to_camera[3];
        sheen_subf(to_camera, j->camera_obj, p);
        sheen_normalizef(to_camera);
        if (!(sheen_dotf(to_camera, c->n_obj + 3 * i) > slant_limit))
            continue;
        const double p_obj[3] = {(double)p[0], (double)p[1], (double)p[2]};
        double p_cam[3], q_px[2];
        sheen_Rt_point(p_cam, &j->Rt_cam_obj, p_obj);
        if (sheen_camera_project(&c->photos->cam, q_px, NULL, p_cam, 1, NULL))
            continue;
        c->seen[j->view * c->n_candidates + i] = 1;
        c->strength[i] = fmaxf(c->strength[i], edge_strength(&j->photo->image, q_px));
    }
}

static void look_from(choice *c, size_t view, const sheen_texel_view *v, int n_threads)
{
    look_job j = {.c = c, .v = v, .photo = &c->photos->photos[view], .view = view};
    double rt_obj_cam[6];
    sheen_rt_invert(rt_obj_cam, j.photo->rt_cam_obj);
    sheen_Rt_from_rt(&j.Rt_cam_obj, j.photo->rt_cam_obj);
    for (int k = 0; k < 3; k++)
        j.camera_obj[k] = (float)rt_obj_cam[3 + k];
    sheen_parallel_for(c->n_candidates, 2048, n_threads, look_at, &j);
}

static sheen_status look(choice *c, const sheen_scene *scene, int n_threads, sheen_err *err)
{
    sheen_texel_view v = {0};
    sheen_status s = sheen_texel_view_init(&v, c->mesh->n_triangles, c->edge, err);
    for (size_t i = 0; i < c->photos->count && !s; i++) {
        sheen_gbuffer g;
        if ((s = sheen_gbuffer_make(&g, scene, c->mesh, &c->photos->cam, c->photos->photos[i].rt_cam_obj, 1,
                                    n_threads, err)))
            break;
        sheen_texel_view_fill(&v, c->mesh, scene, &g, &c->photos->cam, &c->photos->photos[i], c->edge,
                              n_threads);
        sheen_gbuffer_release(&g);
        look_from(c, i, &v, n_threads);
    }
    sheen_texel_view_release(&v);
    return s;
}

static int descending(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x < y) - (x > y);
}

// Marks the chosen candidates in chosen[]; returns how many.
static size_t choose(uint8_t *chosen, const choice *c, float *scratch)
{
    const size_t n_views = c->photos->count;
    size_t n_twice = 0, most = OBSERVATIONS / (n_views ? n_views : 1), n = 0, k = 0;
    most = most > MOST_POINTS ? MOST_POINTS : most;
    for (size_t i = 0; i < c->n_candidates; i++) {
        size_t views = 0;
        for (size_t v = 0; v < n_views; v++)
            views += c->seen[v * c->n_candidates + i];
        chosen[i] = views >= 2;
        if (chosen[i])
            scratch[n_twice++] = c->strength[i];
    }
    if (n_twice <= most)
        return n_twice;
    qsort(scratch, n_twice, sizeof *scratch, descending);
    const float strong = scratch[most / 2];
    const size_t every = 1 + n_twice / (most / 2 + 1);
    for (size_t i = 0; i < c->n_candidates; i++)
        if (chosen[i]) {
            chosen[i] = c->strength[i] > strong || k++ % every == 0;
            n += chosen[i];
        }
    return n;
}

static sheen_status gather(sheen_align_points *out, const choice *c, const uint8_t *chosen,
                           const sheen_view_light *lights, sheen_err *err)
{
    const size_t n = out->n_points, n_views = out->n_views;
    out->p_obj = malloc((3 * n + 1) * sizeof *out->p_obj);
    out->seen = calloc(n_views * n + 1, 1);
    out->predicted = calloc(3 * n_views * n + 1, sizeof *out->predicted);
    if (!out->p_obj || !out->seen || !out->predicted)
        return sheen_fail_memory(err, 25.0 * (double)(n_views * n), "points to compare photographs on");
    size_t k = 0;
    for (size_t i = 0; i < c->n_candidates; i++) {
        if (!chosen[i])
            continue;
        memcpy(out->p_obj + 3 * k, c->p_obj + 3 * i, 3 * sizeof *out->p_obj);
        for (size_t v = 0; v < n_views; v++) {
            const uint8_t seen = c->seen[v * c->n_candidates + i];
            out->seen[v * n + k] = seen;
            if (seen && lights)
                memcpy(out->predicted + 3 * (v * n + k), lights[v].lights_rgb + 3 * i * c->step,
                       3 * sizeof *out->predicted);
        }
        k++;
    }
    return SHEEN_OK;
}

sheen_status sheen_align_points_take(sheen_align_points *out, const sheen_photos *photos,
                                     const sheen_mesh *mesh, const sheen_scene *scene, int texels_per_edge,
                                     const sheen_view_light *lights, int n_threads, sheen_err *err)
{
    choice c = {.photos = photos, .mesh = mesh, .edge = texels_per_edge};
    uint8_t *chosen = NULL;
    float *scratch = NULL;
    *out = (sheen_align_points){.n_views = photos->count};
    sheen_status s;
    if ((s = list_candidates(&c, err)) || (s = look(&c, scene, n_threads, err)))
        goto done;
    chosen = malloc(c.n_candidates + 1);
    scratch = malloc((c.n_candidates + 1) * sizeof *scratch);
    if (!chosen || !scratch) {
        s = sheen_fail_memory(err, 5.0 * (double)c.n_candidates, "points to compare photographs on");
        goto done;
    }
    out->n_points = choose(chosen, &c, scratch);
    s = gather(out, &c, chosen, lights, err);

done:
    free(chosen);
    free(scratch);
    free(c.p_obj);
    free(c.n_obj);
    free(c.seen);
    free(c.strength);
    if (s)
        sheen_align_points_release(out);
    return s;
}

void sheen_align_points_release(sheen_align_points *a)
{
    free(a->p_obj);
    free(a->seen);
    free(a->predicted);
    *a = (sheen_align_points){0};
}
