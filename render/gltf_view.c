// SPDX-License-Identifier: Apache-2.0
// gltf_view.c - glTF's material (appendix B of its specification, KHR_materials_specular) under the exported panorama.
//
// light = base (1 - F) E / pi + L F, where E is the panorama's irradiance, L its radiance about the mirror direction, spread
// by the GGX lobe as viewers on the web spread it (the lobe of a view along the normal), and F = F0 A + F90 B the
// reflectance of the lobe as a whole: A and B are integrals of GGX with Smith's shadowing over the angle (Karis 2013, "Real
// shading in Unreal Engine 4"), computed here by importance sampling.
#include "render/gltf_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "render/gbuffer.h"
#include "render/normal_map.h"
#include "render/panorama.h"

static const float pi_f = 3.14159265f;
enum { N_SAMPLES = 128, N_COSINES = 64, ROWS_A_PIECE = 4 };

typedef struct viewing {
    const sheen_gltf *g;
    const sheen_gbuffer *buffer;
    const float *irradiance;      // [vertex][3]
    float lobe[N_SAMPLES][3];     // directions about +z
    float reflectance[N_COSINES]; // F at the middle of each step of the cosine
    sheen_image *out;
} viewing;

// Half vectors that stand for equal shares of GGX's distribution: Hammersley's points.
static void half_vector(float h[3], int i, float alpha)
{
    unsigned bits = 0;
    for (int k = 0; k < 32; k++)
        bits |= (((unsigned)i >> k) & 1u) << (31 - k);
    const float u = ((float)i + 0.5f) / N_SAMPLES, azimuth = 2 * pi_f * (float)bits / 4294967296.0f;
    const float slope = alpha * sqrtf(u / (1 - u)), cosine = 1 / sqrtf(1 + slope * slope);
    h[0] = slope * cosine * cosf(azimuth);
    h[1] = slope * cosine * sinf(azimuth);
    h[2] = cosine;
}

static float smith(float cosine, float alpha)
{
    return 2 * cosine / (cosine + sqrtf(alpha * alpha + (1 - alpha * alpha) * cosine * cosine));
}

static float reflectance_at(float cosine, float alpha, float f0, float f90)
{
    const float v[3] = {sqrtf(1 - cosine * cosine), 0, cosine};
    float sum = 0;
    for (int i = 0; i < N_SAMPLES; i++) {
        float h[3];
        half_vector(h, i, alpha);
        const float vh = sheen_dotf(v, h), lz = 2 * vh * h[2] - cosine;
        if (!(vh > 0 && lz > 0))
            continue;
        const float weight = smith(cosine, alpha) * smith(lz, alpha) * vh / (h[2] * cosine);
        sum += weight * (f0 + (f90 - f0) * powf(1 - vh, 5));
    }
    return sum / N_SAMPLES;
}

static void prepare(viewing *v)
{
    const float alpha = (float)(v->g->roughness * v->g->roughness);
    const float f90 = (float)v->g->specular_factor,
                f0 = fminf(1, (float)(SHEEN_DIELECTRIC_F0 * v->g->specular_colour)) * f90;
    for (int i = 0; i < N_SAMPLES; i++) {
        float h[3];
        half_vector(h, i, alpha);
        for (int k = 0; k < 3; k++)
            v->lobe[i][k] = 2 * h[2] * h[k] - (k == 2 ? 1.0f : 0.0f);
    }
    for (int i = 0; i < N_COSINES; i++)
        v->reflectance[i] = reflectance_at(((float)i + 0.5f) / N_COSINES, alpha, f0, f90);
}

// Between four pixels; the picture's right side meets its left one.
static void add_bilinear(float rgb[3], const sheen_image *img, float x, float y, float weight)
{
    const float left = floorf(x), top = floorf(y);
    for (int dy = 0; dy < 2; dy++)
        for (int dx = 0; dx < 2; dx++) {
            const int w = img->width_px, row = (int)top + dy,
                      at_y = row < 0 ? 0 : (row < img->height_px ? row : img->height_px - 1);
            const float *from = sheen_image_at(img, ((int)left + dx + w) % w, at_y);
            const float share = (dx ? x - left : 1 - x + left) * (dy ? y - top : 1 - y + top);
            for (int c = 0; c < 3; c++)
                rgb[c] += weight * share * from[c];
        }
}

// The panorama about r_env (unit), spread by the lobe.
static void mirrored(float rgb[3], const viewing *v, const float r_env[3])
{
    const sheen_image *sky = &v->g->panorama;
    float a[3], b[3], total = 0;
    sheen_tangents(a, b, r_env);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int i = 0; i < N_SAMPLES; i++) {
        const float *l = v->lobe[i];
        float d[3];
        if (!(l[2] > 0))
            continue;
        for (int k = 0; k < 3; k++)
            d[k] = l[0] * a[k] + l[1] * b[k] + l[2] * r_env[k];
        const float x = (atan2f(d[2], d[0]) / (2 * pi_f) + 0.5f) * (float)sky->width_px - 0.5f,
                    y = (0.5f - asinf(fmaxf(-1, fminf(1, d[1]))) / pi_f) * (float)sky->height_px - 0.5f;
        add_bilinear(rgb, sky, x, y, l[2]);
        total += l[2];
    }
    for (int c = 0; c < 3; c++)
        rgb[c] /= fmaxf(total, 1e-9f);
}

// Base colour and irradiance at a hit.
static void surface_at(float base[3], float E[3], const viewing *v, const sheen_hit *hit)
{
    const sheen_surface_picture *p = &v->g->surface;
    const float b[3] = {1 - hit->b1 - hit->b2, hit->b1, hit->b2};
    float x = -0.5f, y = -0.5f;
    for (size_t c = 0; c < 3; c++)
        base[c] = E[c] = 0;
    for (size_t k = 0; k < 3; k++) {
        const size_t corner = 3 * (size_t)hit->triangle + k;
        const float *q = p->charts.q_px + 2 * (size_t)p->charts.triangles[corner],
                    *light = v->irradiance + 3 * (size_t)p->mesh.triangles[corner];
        x += b[k] * q[0];
        y += b[k] * q[1];
        for (size_t c = 0; c < 3; c++)
            E[c] += b[k] * light[c];
    }
    add_bilinear(base, &p->rgb, x, y, 1);
}

static void shade(float rgb[3], const viewing *v, const sheen_hit *hit)
{
    float n_obj[3], v_obj[3], r_obj[3], r_env[3], base[3], E[3], L[3];
    sheen_hit_surface(&v->g->surface.mesh, hit, v->buffer->p_camera_obj, NULL, n_obj, v_obj);
    const float held = fmaxf(0, fminf(1, sheen_dotf(n_obj, v_obj)));
    sheen_mirrorf(r_obj, n_obj, v_obj);
    for (int k = 0; k < 3; k++)
        r_env[k] = (float)(v->g->R_gltf_obj[k][0] * (double)r_obj[0] +
                           v->g->R_gltf_obj[k][1] * (double)r_obj[1] +
                           v->g->R_gltf_obj[k][2] * (double)r_obj[2]);
    sheen_normalizef(r_env);
    const int step = (int)(held * N_COSINES);
    const float F = v->reflectance[step < N_COSINES ? step : N_COSINES - 1];
    surface_at(base, E, v, hit);
    mirrored(L, v, r_env);
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
    float *irradiance = NULL;
    *out = (sheen_image){0};
    viewing *v = malloc(sizeof *v);
    sheen_status s = v ? SHEEN_OK : sheen_fail_memory(err, (double)sizeof *v, "a view");
    if (!s)
        s = sheen_image_init(out, cam->width_px, cam->height_px, 3, err);
    if (!s)
        s = sheen_gltf_irradiance(&irradiance, g, &g->surface.mesh, err);
    if (!s)
        s = sheen_scene_new(&scene, &g->surface.mesh, err);
    if (!s)
        s = sheen_gbuffer_make(&buffer, scene, &g->surface.mesh, cam, rt_cam_obj, 1, n_threads, err);
    if (!s) {
        const size_t n_px = (size_t)out->width_px * (size_t)out->height_px;
        for (size_t i = 0; i < n_px; i++)
            memcpy(out->data + 3 * i, background_rgb, 3 * sizeof(float));
        *v = (viewing){.g = g, .buffer = &buffer, .irradiance = irradiance, .out = out};
        prepare(v);
        sheen_parallel_for((size_t)buffer.height_px, ROWS_A_PIECE, n_threads, rows, v);
    } else
        sheen_image_release(out);
    sheen_gbuffer_release(&buffer);
    sheen_scene_free(&scene);
    free(irradiance);
    free(v);
    return s;
}
