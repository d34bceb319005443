// SPDX-License-Identifier: Apache-2.0
// gltf_view.c - glTF's material (appendix B of its specification, KHR_materials_specular) under the exported panorama.
//
// light = base (1 - w F) E / pi + w F L: E the panorama's irradiance, w the place's weight, F and L as gltf_reflection.h has them.
#include "render/gltf_view.h"

#include <math.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "render/gbuffer.h"
#include "render/gltf_reflection.h"
#include "render/gltf_surface.h"
#include "render/panorama.h"

static const float pi_f = 3.14159265f;
enum { ROWS_A_PIECE = 4 };

typedef struct viewing {
    const sheen_gltf *g;
    const sheen_gbuffer *buffer;
    sheen_image irradiance;
    sheen_gltf_reflection reflection;
    sheen_image *out;
} viewing;

static void shade(float rgb[3], const viewing *v, const sheen_hit *hit)
{
    const sheen_gltf *g = v->g;
    const sheen_chart_place at = {.triangle = hit->triangle, .b1 = hit->b1, .b2 = hit->b2};
    float p_obj[3], n_obj[3], v_obj[3], r_obj[3], n_env[3], r_env[3], base[3], E[3], L[3],
        weight[3] = {1, 1, 1};
    sheen_gltf_surface_at(p_obj, n_obj, g, &at);
    for (int k = 0; k < 3; k++)
        v_obj[k] = (float)v->buffer->p_camera_obj[k] - p_obj[k];
    sheen_normalizef(v_obj);
    sheen_mirrorf(r_obj, n_obj, v_obj);
    sheen_normalizef(r_obj);
    sheen_gltf_to_env(n_env, g, n_obj);
    sheen_gltf_to_env(r_env, g, r_obj);
    sheen_gltf_picture_at(base, g, &g->surface.rgb, &at);
    if (g->specular.data)
        sheen_gltf_picture_at(weight, g, &g->specular, &at);
    sheen_panorama_at(E, &v->irradiance, n_env);
    sheen_gltf_mirrored(L, &v->reflection, &g->panorama, r_env);
    // What is more than 1 is the reflectance's alone (gltf_specular.h).
    const float f90 = (float)g->specular_factor * fminf(1, weight[0]);
    const float f0 = f90 * fminf(1, (float)(SHEEN_DIELECTRIC_F0 * g->specular_colour) * fmaxf(1, weight[0]));
    const float F = sheen_gltf_reflectance(&v->reflection, fminf(1, sheen_dotf(n_obj, v_obj)), f0, f90);
    for (int c = 0; c < 3; c++)
        rgb[c] = base[c] * (1 - F) * E[c] / pi_f + F * L[c];
}

static void rows(void *self, size_t begin, size_t end)
{
    const viewing *v = self;
    const sheen_gbuffer *b = v->buffer;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < b->width_px; x++) {
            const sheen_hit *hit = &b->hits[y * (size_t)b->width_px + (size_t)x];
            if (hit->triangle != SHEEN_NO_HIT)
                shade(sheen_image_at(v->out, b->x0_px + x, b->y0_px + (int)y), v, hit);
        }
}

sheen_status sheen_gltf_view(sheen_image *out, const sheen_gltf *g, const sheen_camera *cam,
                             const double rt_cam_obj[6], const float background_rgb[3], int n_threads,
                             sheen_err *err)
{
    sheen_scene *scene = NULL;
    sheen_gbuffer buffer = {0};
    *out = (sheen_image){0};
    viewing v = {.g = g, .buffer = &buffer, .out = out};
    sheen_status s = sheen_image_init(out, cam->width_px, cam->height_px, 3, err);
    if (!s)
        s = sheen_gltf_irradiance(&v.irradiance, &g->panorama, err);
    if (!s)
        s = sheen_scene_new(&scene, &g->surface.mesh, err);
    if (!s)
        s = sheen_gbuffer_make(&buffer, scene, &g->surface.mesh, cam, rt_cam_obj, 1, n_threads, err);
    if (!s) {
        const size_t n_px = (size_t)out->width_px * (size_t)out->height_px;
        for (size_t i = 0; i < n_px; i++)
            memcpy(out->data + 3 * i, background_rgb, 3 * sizeof(float));
        sheen_gltf_reflection_init(&v.reflection, g->roughness);
        sheen_parallel_for((size_t)buffer.height_px, ROWS_A_PIECE, n_threads, rows, &v);
    } else
        sheen_image_release(out);
    sheen_gbuffer_release(&buffer);
    sheen_scene_free(&scene);
    sheen_image_release(&v.irradiance);
    return s;
}
