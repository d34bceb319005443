// SPDX-License-Identifier: Apache-2.0
// lit_sphere.c - shades a unit sphere from a ring of distant cameras.
#include "lit_sphere.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { RINGS = 220 };

static double shade(const lit_sphere *scene, const float n[3], const float v[3])
{
    float dx[8], dy[8], dz[8], weight[8];
    for (int l = 0; l < scene->n_lights; l++) {
        dx[l] = (float)scene->light_world[l][0];
        dy[l] = (float)scene->light_world[l][1];
        dz[l] = (float)scene->light_world[l][2];
        weight[l] = (float)scene->strength[l];
    }
    const sheen_lights lights = {dx, dy, dz, weight, (size_t)scene->n_lights};
    return sheen_lobe_sum_ref(&lights, n, v, (float)scene->sigma_rad);
}

static void add(sheen_samples *s, const float n[3], const float v[3], double intensity)
{
    memcpy(s->n_world + 3 * s->count, n, 3 * sizeof *n);
    memcpy(s->v_world + 3 * s->count, v, 3 * sizeof *v);
    s->intensity[s->count++] = (float)intensity;
}

void lit_sphere_samples(sheen_samples *out, const lit_sphere *scene, double threshold, uint64_t seed)
{
    const size_t most = (size_t)scene->n_views * RINGS * 2 * RINGS;
    *out = (sheen_samples){.n_world = malloc(3 * most * sizeof(float)),
                           .v_world = malloc(3 * most * sizeof(float)),
                           .intensity = malloc(most * sizeof(float))};
    assert_non_null(out->n_world);
    assert_non_null(out->v_world);
    assert_non_null(out->intensity);
    for (int view = 0; view < scene->n_views; view++) {
        const double az = 6.283185307 * view / scene->n_views, el = 0.61;
        const float v[3] = {(float)(cos(el) * cos(az)), (float)(cos(el) * sin(az)), (float)sin(el)};
        for (int i = 0; i < RINGS; i++)
            for (int k = 0; k < 2 * RINGS; k++) {
                const double z = -1 + 2 * (i + 0.5) / RINGS, phi = 6.283185307 * k / (2 * RINGS),
                             r = sqrt(1 - z * z);
                const float n[3] = {(float)(r * cos(phi)), (float)(r * sin(phi)), (float)z};
                if (sheen_dotf(n, v) < 0.25f)
                    continue;
                const double I = shade(scene, n, v) + scene->noise * test_random_normal(&seed);
                if (I > threshold)
                    add(out, n, v, I);
            }
    }
}
