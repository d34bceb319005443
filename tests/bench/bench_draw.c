// SPDX-License-Identifier: Apache-2.0
// bench_draw.c - directions, visibility and whole pictures of a figure at 1280 x 960.
#include "render/draw.h"

#include <stdio.h>
#include <stdlib.h>

#include "render/gbuffer.h"
#include "render/geodesic.h"
#include "render/pixel_rays.h"
#include "tests/bench/bench.h"
#include "tests/support.h"
#include "tests/support_scene.h"

enum { N_LIGHTS = 1162, T = 8 };

typedef struct job {
    sheen_model m;
    sheen_drawing *d;
    sheen_scene *scene;
    sheen_camera cam;
    double rt_cam_obj[6];
    sheen_gbuffer g;
    int samples, reference;
} job;

static void run_rays(void *self)
{
    const job *j = self;
    float v[64][3], sum = 0;
    sheen_pixel_rays rays;
    const int window_px[4] = {0, 0, j->cam.width_px, j->cam.height_px};
    if (sheen_pixel_rays_init(&rays, &j->cam, j->rt_cam_obj, window_px, 1, NULL))
        return;
    for (int y = 0; y < j->cam.height_px; y += j->reference ? 16 : 1)
        for (int x = 0; x < j->cam.width_px; x += 64) {
            if (j->reference)
                sheen_pixel_rays_row_ref(&rays, v[0], x, y, 1, 64);
            else
                sheen_pixel_rays_row(&rays, v[0], x, y, 1, 64);
            sum += v[7][1];
        }
    sheen_pixel_rays_release(&rays);
    bench_keep((double)sum);
}

static void run_build(void *self)
{
    job *j = self;
    sheen_scene_free(&j->scene);
    if (sheen_scene_new(&j->scene, &j->m.mesh, NULL))
        abort();
}

static void run_gbuffer(void *self)
{
    job *j = self;
    sheen_gbuffer_release(&j->g);
    if (sheen_gbuffer_make(&j->g, j->scene, &j->m.mesh, &j->cam, j->rt_cam_obj, j->samples, 1, NULL))
        abort();
}

static void run_draw(void *self)
{
    const job *j = self;
    sheen_layers l;
    const sheen_draw_options o = {.samples_per_side = j->samples, .n_threads = 1};
    if (sheen_draw(&l, j->d, &j->cam, j->rt_cam_obj, NULL, &o, NULL))
        abort();
    bench_keep((double)l.composite.data[0]);
    sheen_layers_release(&l);
}

static void fill_model(sheen_model *m)
{
    sheen_geodesic g;
    sheen_model_init(m);
    test_figure(&m->mesh, 40, 0.09f, 0.02f);
    if (sheen_geodesic_init(&g, 60, NULL) || sheen_model_set_lights(m, N_LIGHTS, NULL) ||
        sheen_texture_init(&m->texture, m->mesh.n_triangles, T, NULL))
        abort();
    for (size_t i = 0; i < N_LIGHTS; i++) {
        const float *d = g.v_world + 3 * (i * (g.n_nodes / N_LIGHTS));
        m->lights.dx[i] = d[0];
        m->lights.dy[i] = d[1];
        m->lights.dz[i] = d[2];
        m->lights.weight[i] = 1e-3f;
    }
    for (size_t i = 0; i < m->mesh.n_triangles * sheen_texels_per_triangle(T); i++)
        m->texture.n_views[i] = 1;
    m->k_s = 1;
    m->sigma_rad = 0.0114;
    sheen_geodesic_release(&g);
}

int main(void)
{
    static job j;
    fill_model(&j.m);
    test_look(j.rt_cam_obj, 0.3, 0.2, 0.3);
    if (sheen_drawing_new(&j.d, &j.m, NULL))
        abort();
    bench("scene: building, a triangle", j.m.mesh.n_triangles, 5, run_build, &j);
    for (int lens = 0; lens < 2; lens++) {
        const char *through = lens ? "lens" : "pinhole";
        char name[80];
        test_camera(&j.cam, 1280, 960, 1500, lens);
        snprintf(name, sizeof name, "rays: %s, a pixel", through);
        j.reference = 0;
        bench(name, 1280 * 960, 10, run_rays, &j);
        snprintf(name, sizeof name, "rays: %s, a pixel, reference", through);
        j.reference = 1;
        bench(name, 1280 * 960 / 16, 3, run_rays, &j);
        for (j.samples = 1; j.samples <= 2; j.samples++) {
            run_gbuffer(&j);
            const size_t n = (size_t)(j.g.width_px * j.g.height_px * j.samples * j.samples);
            snprintf(name, sizeof name, "gbuffer: %s, %d x %d samples, a sample", through, j.samples,
                     j.samples);
            bench(name, n, 10, run_gbuffer, &j);
            snprintf(name, sizeof name, "draw: %s, %d x %d samples, a picture", through, j.samples,
                     j.samples);
            bench(name, 1, 10, run_draw, &j);
        }
    }
    sheen_gbuffer_release(&j.g);
    sheen_scene_free(&j.scene);
    sheen_drawing_free(&j.d);
    sheen_model_release(&j.m);
    return 0;
}
