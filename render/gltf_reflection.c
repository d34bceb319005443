// SPDX-License-Identifier: Apache-2.0
// gltf_reflection.c - GGX by importance sampling, of its reflectance and of a panorama.
#include "render/gltf_reflection.h"

#include <math.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "render/panorama.h"

static const float pi_f = 3.14159265f;
enum { N_SAMPLES = SHEEN_GLTF_LOBE_SAMPLES, N_COSINES = SHEEN_GLTF_COSINES };

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

static void integrals_at(float *A, float *B, float cosine, float alpha)
{
    const float v[3] = {sqrtf(1 - cosine * cosine), 0, cosine};
    *A = *B = 0;
    for (int i = 0; i < N_SAMPLES; i++) {
        float h[3];
        half_vector(h, i, alpha);
        const float vh = sheen_dotf(v, h), lz = 2 * vh * h[2] - cosine;
        if (!(vh > 0 && lz > 0))
            continue;
        const float weight = smith(cosine, alpha) * smith(lz, alpha) * vh / (h[2] * cosine) / N_SAMPLES;
        const float rim = powf(1 - vh, 5);
        *A += weight * (1 - rim);
        *B += weight * rim;
    }
}

void sheen_gltf_reflection_init(sheen_gltf_reflection *r, double roughness)
{
    const float alpha = (float)(roughness * roughness);
    for (int i = 0; i < N_SAMPLES; i++) {
        float h[3];
        half_vector(h, i, alpha);
        for (int k = 0; k < 3; k++)
            r->lobe[i][k] = 2 * h[2] * h[k] - (k == 2 ? 1.0f : 0.0f);
    }
    for (int i = 0; i < N_COSINES; i++)
        integrals_at(&r->A[i], &r->B[i], ((float)i + 0.5f) / N_COSINES, alpha);
}

float sheen_gltf_reflectance(const sheen_gltf_reflection *r, float cosine, float f0, float f90)
{
    const int step = (int)(fmaxf(0, cosine) * N_COSINES), at = step < N_COSINES ? step : N_COSINES - 1;
    return f0 * r->A[at] + f90 * r->B[at];
}

void sheen_gltf_mirrored(float rgb[3], const sheen_gltf_reflection *r, const sheen_image *panorama,
                         const float r_env[3])
{
    float a[3], b[3], total = 0;
    sheen_axes_aboutf(a, b, r_env);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int i = 0; i < N_SAMPLES; i++) {
        const float *l = r->lobe[i];
        float d[3], light[3];
        if (!(l[2] > 0))
            continue;
        for (int k = 0; k < 3; k++)
            d[k] = l[0] * a[k] + l[1] * b[k] + l[2] * r_env[k];
        sheen_panorama_at(light, panorama, d);
        for (int c = 0; c < 3; c++)
            rgb[c] += l[2] * light[c];
        total += l[2];
    }
    for (int c = 0; c < 3; c++)
        rgb[c] /= fmaxf(total, 1e-9f);
}

typedef struct spreading {
    const sheen_gltf_reflection *r;
    const sheen_image *panorama;
    sheen_image *out;
} spreading;

static void spread_rows(void *self, size_t begin, size_t end)
{
    const spreading *s = self;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < s->out->width_px; x++) {
            float v_env[3];
            sheen_panorama_direction(v_env, s->out, x, y);
            sheen_gltf_mirrored(sheen_image_at(s->out, x, y), s->r, s->panorama, v_env);
        }
}

sheen_status sheen_gltf_spread(sheen_image *out, const sheen_gltf_reflection *r, const sheen_image *panorama,
                               int height_px, int n_threads, sheen_err *err)
{
    const sheen_status s = sheen_image_init(out, 2 * height_px, height_px, 3, err);
    if (s)
        return s;
    spreading job = {r, panorama, out};
    sheen_parallel_for((size_t)height_px, 4, n_threads, spread_rows, &job);
    return SHEEN_OK;
}
