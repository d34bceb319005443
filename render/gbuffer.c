// SPDX-License-Identifier: Apache-2.0
// gbuffer.c - what a camera sees of a mesh, kept for the whole picture.
#include "render/gbuffer.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "render/first_hits.h"

enum { BAND_PX = 32 };

typedef struct job {
    const sheen_first_hits *first_hits;
    sheen_hit *hits;
    atomic_int failed;
} job;

static void find_bands(void *self, size_t begin, size_t end)
{
    job *j = self;
    for (size_t band = begin; band < end; band++) {
        const sheen_gbuffer g = sheen_first_hits_band(j->first_hits, band);
        const size_t n = (size_t)g.samples_per_side,
                     row = (size_t)(g.y0_px - j->first_hits->window.y0_px) * n;
        if (sheen_first_hits_find(j->first_hits, j->hits + row * (size_t)g.width_px * n, band, NULL))
            atomic_store(&j->failed, 1);
    }
}

static sheen_status make(sheen_gbuffer *out, const sheen_first_hits_view *v, sheen_err *err)
{
    sheen_first_hits f;
    *out = (sheen_gbuffer){.samples_per_side = v->samples_per_side};
    sheen_status s = sheen_first_hits_init(&f, v, BAND_PX, err);
    if (s)
        return s;
    *out = f.window;
    const size_t n = (size_t)out->samples_per_side * (size_t)out->samples_per_side;
    const size_t count = (size_t)out->width_px * (size_t)out->height_px * n;
    job j = {.first_hits = &f};
    atomic_init(&j.failed, 0);
    if (count) {
        j.hits = out->hits = malloc(count * sizeof *out->hits);
        if (j.hits)
            sheen_parallel_for(f.n_bands, 1, v->n_threads, find_bands, &j);
        if (!j.hits || atomic_load(&j.failed))
            s = sheen_fail_memory(err, 16.0 * (double)count, "a view's samples");
    }
    sheen_first_hits_release(&f);
    if (s)
        sheen_gbuffer_release(out);
    return s;
}

sheen_status sheen_gbuffer_make(sheen_gbuffer *out, const sheen_scene *scene, const sheen_mesh *mesh,
                                const sheen_camera *cam, const double rt_cam_obj[6], int samples_per_side,
                                int n_threads, sheen_err *err)
{
    const sheen_first_hits_view v = {scene, mesh, cam, rt_cam_obj, samples_per_side, n_threads, false};
    return make(out, &v, err);
}

sheen_status sheen_gbuffer_make_ref(sheen_gbuffer *out, const sheen_scene *scene, const sheen_mesh *mesh,
                                    const sheen_camera *cam, const double rt_cam_obj[6], int samples_per_side,
                                    int n_threads, sheen_err *err)
{
    const sheen_first_hits_view v = {scene, mesh, cam, rt_cam_obj, samples_per_side, n_threads, true};
    return make(out, &v, err);
}

void sheen_gbuffer_release(sheen_gbuffer *g)
{
    free(g->hits);
    *g = (sheen_gbuffer){0};
}

void sheen_hit_surface(const sheen_mesh *mesh, const sheen_hit *hit, const double p_camera_obj[3],
                       float p_obj[3], float n_obj[3], float v_obj[3])
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)hit->triangle;
    const float b[3] = {1 - hit->b1 - hit->b2, hit->b1, hit->b2};
    float p[3] = {0, 0, 0}, n[3] = {0, 0, 0};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) {
            p[k] += b[c] * mesh->p_obj[3 * (size_t)corner[c] + (size_t)k];
            n[k] += b[c] * mesh->n_obj[3 * (size_t)corner[c] + (size_t)k];
        }
    if (p_obj)
        memcpy(p_obj, p, sizeof p);
    if (n_obj) {
        sheen_normalizef(n);
        memcpy(n_obj, n, sizeof n);
    }
    if (v_obj) {
        for (int k = 0; k < 3; k++)
            v_obj[k] = (float)(p_camera_obj[k] - (double)p[k]);
        sheen_normalizef(v_obj);
    }
}
