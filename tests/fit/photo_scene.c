// SPDX-License-Identifier: Apache-2.0
// photo_scene.c - paints a mesh, lights it, and photographs it from a ring.
#include "photo_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/draw.h"
#include "support.h"
#include "support_scene.h"

static const double lights_deg[6][2] = {{20, 50},  {95, 62},  {160, 40},
                                        {230, 55}, {290, 35}, {340, 70}}; // azimuth, elevation

void photo_scene_light(double v_world[3], int i)
{
    const double az = lights_deg[i][0] * 3.14159265358979 / 180,
                 el = lights_deg[i][1] * 3.14159265358979 / 180;
    v_world[0] = cos(el) * cos(az);
    v_world[1] = cos(el) * sin(az);
    v_world[2] = sin(el);
}

// Smooth blobs of colour, so that resampling does not matter.
static void paint(sheen_model *m)
{
    sheen_err err;
    enum { EDGE = 5, N = EDGE * (EDGE + 1) / 2 };
    assert_ok(sheen_texture_init(&m->texture, m->mesh.n_triangles, EDGE, &err), err);
    float p[3 * N];
    for (size_t f = 0; f < m->mesh.n_triangles; f++) {
        sheen_texture_lattice(&m->mesh, f, EDGE, p, NULL);
        for (size_t k = 0; k < N; k++) {
            float *rgb = m->texture.rgb + 3 * (f * N + k);
            for (int c = 0; c < 3; c++)
                rgb[c] = 0.22f + 0.12f * sinf(35 * p[3 * k + (size_t)c] + 2 * (float)c) *
                                     cosf(28 * p[3 * k + (size_t)(c + 1) % 3]);
            m->texture.n_views[f * N + k] = 1;
        }
    }
}

static void light(sheen_model *m, const photo_scene_options *o)
{
    sheen_err err;
    assert_ok(sheen_model_set_lights(m, (size_t)o->n_lights, &err), err);
    m->frequency = 60;
    m->n_hemisphere = 18151;
    m->k_s = 1;
    m->sigma_rad = o->sigma_rad;
    for (int c = 0; c < 3; c++)
        m->light_rgb[c] = 1;
    for (int i = 0; i < o->n_lights; i++) {
        double v[3];
        photo_scene_light(v, i);
        m->node[i] = (uint32_t)i;
        m->radiance[i] = 1;
        m->lights.dx[i] = (float)v[0];
        m->lights.dy[i] = (float)v[1];
        m->lights.dz[i] = (float)v[2];
        m->lights.weight[i] = 0.25f + 0.05f * (float)i;
    }
}

static void photograph(sheen_photo *p, const sheen_drawing *drawing, const sheen_camera *cam,
                       double azimuth_rad, double elevation_rad, double noise, uint64_t seed)
{
    sheen_err err;
    sheen_layers layers;
    test_look(p->rt_cam_obj, 0.5 * cos(elevation_rad) * cos(azimuth_rad),
              0.5 * cos(elevation_rad) * sin(azimuth_rad), 0.5 * sin(elevation_rad));
    const sheen_draw_options o = {.samples_per_side = 2, .n_threads = 1};
    assert_ok(sheen_draw(&layers, drawing, cam, p->rt_cam_obj, NULL, &o, &err), err);
    p->image = layers.composite;
    layers.composite = (sheen_image){0};
    sheen_layers_release(&layers);
    const size_t n = (size_t)cam->width_px * (size_t)cam->height_px * 3;
    for (size_t i = 0; i < n; i++)
        p->image.data[i] += (float)(noise * test_random_normal(&seed));
}

static void photograph_ring(sheen_photos *out, const sheen_drawing *drawing, const photo_scene_options *o,
                            size_t n, double turn_rad, double elevation_rad)
{
    test_camera(&out->cam, o->width_px, o->height_px, 1.9 * o->height_px, 0);
    out->photos = calloc(n + 1, sizeof *out->photos);
    assert_non_null(out->photos);
    out->count = n;
    for (size_t i = 0; i < n; i++) {
        snprintf(out->photos[i].name, sizeof out->photos[i].name, "view%02zu", i);
        photograph(&out->photos[i], drawing, &out->cam, turn_rad + 6.283185307 * (double)i / (double)n,
                   elevation_rad, o->noise, i + 1);
    }
}

void photo_scene_make(photo_scene *out, const photo_scene_options *o)
{
    const float centre[3] = {0, 0, 0};
    sheen_err err;
    sheen_drawing *drawing;
    memset(out, 0, sizeof *out);
    sheen_model_init(&out->truth);
    if (o->bumpy)
        test_figure(&out->truth.mesh, 10, 0.08f, 0.02f);
    else
        test_sphere(&out->truth.mesh, 10, centre, 0.08f);
    paint(&out->truth);
    light(&out->truth, o);
    assert_ok(sheen_drawing_new(&drawing, &out->truth, &err), err);
    photograph_ring(&out->inputs, drawing, o, o->n_inputs, 0, 0.61);
    photograph_ring(&out->tests, drawing, o, o->n_tests, 0.4, 0.75);
    sheen_drawing_free(&drawing);
}

void photo_scene_release(photo_scene *s)
{
    sheen_photos_release(&s->inputs);
    sheen_photos_release(&s->tests);
    sheen_model_release(&s->truth);
}
