// SPDX-License-Identifier: Apache-2.0
// bench_draw.c - directions, visibility and whole pictures of a figure of 69,620 triangles at 1920 x 1080: times, times as
// a multiple of what Embree's rays for the same samples take in this run, and what exact sums over the lights come to.
#include "render/draw.h"

#include <stdio.h>
#include <stdlib.h>

#include "render/gbuffer.h"
#include "render/geodesic.h"
#include "render/lobe.h"
#include "render/pixel_rays.h"
#include "tests/bench/bench.h"
#include "tests/support.h"
#include "tests/support_scene.h"

enum { N_LIGHTS = 1162, T = 8, WIDTH = 1920, HEIGHT = 1080 };

typedef struct job {
    sheen_model m;
    sheen_drawing *d;
    sheen_scene *scene;
    sheen_camera cam;
    double rt_cam_obj[6];
    sheen_gbuffer g;
    sheen_layers layers;
    int samples, reference, n_threads;
} job;

static void run_rays(void *self)
{
    const job *j = self;
    float v[64][3], sum = 0;
    sheen_pixel_rays rays;
    const int window_px[4] = {0, 0, j->cam.width_px, j->cam.height_px};
    if (sheen_pixel_rays_init(&rays, &j->cam, j->rt_cam_obj, window_px, 1, NULL))
        return;
    for (int y = 0; y < j->cam.height_px; y += j->reference ? 12 : 1)
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
    if ((j->reference ? sheen_gbuffer_make_ref : sheen_gbuffer_make)(&j->g, j->scene, &j->m.mesh, &j->cam,
                                                                     j->rt_cam_obj, j->samples, 1, NULL))
        abort();
}

static void run_draw(void *self)
{
    job *j = self;
    const sheen_draw_options o = {
        .layers = SHEEN_LAYER_COMPOSITE, .samples_per_side = j->samples, .n_threads = j->n_threads};
    if (sheen_redraw(&j->layers, j->d, &j->cam, j->rt_cam_obj, NULL, &o, NULL))
        abort();
    bench_keep((double)j->layers.composite.data[0]);
}

// How many lights are within the lobe's reach, counted at every 97th sample that sees the figure.
static void print_reach(const job *j)
{
    const float sigma = (float)j->m.sigma_rad,
                far2 = SHEEN_LOBE_REACH_SIGMA * SHEEN_LOBE_REACH_SIGMA * sigma * sigma;
    const size_t n = (size_t)(j->g.width_px * j->g.height_px);
    size_t n_object = 0, n_counted = 0, n_near = 0;
    for (size_t i = 0; i < n; i++) {
        float n_obj[3], v_obj[3];
        if (j->g.hits[i].triangle == SHEEN_NO_HIT || n_object++ % 97)
            continue;
        n_counted++;
        sheen_hit_surface(&j->m.mesh, &j->g.hits[i], j->g.p_camera_obj, NULL, n_obj, v_obj);
        for (size_t k = 0; k < N_LIGHTS; k++) {
            const float l[3] = {j->m.lights.dx[k], j->m.lights.dy[k], j->m.lights.dz[k]};
            n_near += sheen_lobe_alpha2(n_obj, v_obj, l) <= far2;
        }
    }
    const double near = (double)n_near / (double)(n_counted ? n_counted : 1);
    printf("    sigma %.4f: of %d lights %.1f within reach of a sample, %zu samples: %.1f million terms\n",
           j->m.sigma_rad, N_LIGHTS, near, n_object, 1e-6 * near * (double)n_object);
}

static void fill_model(sheen_model *m)
{
    sheen_geodesic g;
    sheen_model_init(m);
    test_figure(&m->mesh, 59, 0.09f, 0.02f);
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
    sheen_geodesic_release(&g);
}

static void bench_pictures(job *j, const char *through, double rays_ns)
{
    static const double sigmas_rad[] = {0.0114, 0.1};
    for (size_t i = 0; i < 2; i++) {
        char name[80];
        j->m.sigma_rad = sigmas_rad[i];
        if (sheen_drawing_new(&j->d, &j->m, NULL))
            abort();
        snprintf(name, sizeof name, "draw: %s, %d x %d samples, sigma %.4f, a picture", through, j->samples,
                 j->samples, sigmas_rad[i]);
        j->n_threads = 1;
        const double ns = bench(name, 1, 10, run_draw, j);
        printf("    %.1f ms, %.1f pictures a second on one core; rays alone %.1f ms: %.2f times\n", 1e-6 * ns,
               1e9 / ns, 1e-6 * rays_ns, ns / rays_ns);
        j->n_threads = 2;
        snprintf(name, sizeof name, "draw: %s, %d x %d samples, sigma %.4f, two threads", through, j->samples,
                 j->samples, sigmas_rad[i]);
        const double elapsed_ns = bench_elapsed(name, 1, 20, run_draw, j);
        printf("    %.1f ms elapsed, %.1f pictures a second on two threads\n", 1e-6 * elapsed_ns,
               1e9 / elapsed_ns);
        if (j->samples == 1)
            print_reach(j);
        sheen_drawing_free(&j->d);
    }
}

// What a picture takes in which nothing is to be seen: its pixels are written.
static void bench_background(job *j)
{
    const double x_m = j->rt_cam_obj[3];
    j->m.sigma_rad = 0.1;
    if (sheen_drawing_new(&j->d, &j->m, NULL))
        abort();
    j->rt_cam_obj[3] = 100;
    j->n_threads = 1;
    j->samples = 1;
    bench("draw: nothing in view, a picture", 1, 10, run_draw, j);
    j->rt_cam_obj[3] = x_m;
    sheen_drawing_free(&j->d);
}

int main(void)
{
    static job j;
    fill_model(&j.m);
    test_look(j.rt_cam_obj, 0.3, 0.2, 0.3);
    test_camera(&j.cam, WIDTH, HEIGHT, 2300, 0);
    bench_background(&j);
    bench("scene: building, a triangle", j.m.mesh.n_triangles, 5, run_build, &j);
    for (int lens = 0; lens < 2; lens++) {
        const char *through = lens ? "lens" : "pinhole";
        char name[80];
        test_camera(&j.cam, WIDTH, HEIGHT, 2300, lens);
        snprintf(name, sizeof name, "rays: %s, a pixel", through);
        j.reference = 0;
        bench(name, WIDTH * HEIGHT, 10, run_rays, &j);
        snprintf(name, sizeof name, "rays: %s, a pixel, reference", through);
        j.reference = 1;
        bench(name, WIDTH * HEIGHT / 12, 3, run_rays, &j);
        for (j.samples = 1; j.samples <= 2; j.samples++) {
            run_gbuffer(&j);
            const size_t n = (size_t)(j.g.width_px * j.g.height_px * j.samples * j.samples);
            double rays_ns = 0;
            for (j.reference = 0; j.reference < (lens ? 1 : 2); j.reference++) {
                snprintf(name, sizeof name, "gbuffer: %s%s, %d x %d samples, a sample", through,
                         j.reference ? ", rays" : "", j.samples, j.samples);
                rays_ns = (double)n * bench(name, n, 10, run_gbuffer, &j);
            }
            bench_pictures(&j, through, rays_ns);
        }
    }
    sheen_layers_release(&j.layers);
    sheen_gbuffer_release(&j.g);
    sheen_scene_free(&j.scene);
    sheen_model_release(&j.m);
    return 0;
}
