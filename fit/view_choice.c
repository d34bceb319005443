// SPDX-License-Identifier: Apache-2.0
// view_choice.c - the n-th least hash of the cameras that a triangle faces.
#include "fit/view_choice.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"

enum { MAX_CHOSEN = 256 };

// SplitMix64's finalizer.
static uint64_t mixed(uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

static uint64_t camera_hash(const double camera_obj[3])
{
    uint64_t h = 0;
    for (int k = 0; k < 3; k++) {
        uint64_t bits;
        memcpy(&bits, &camera_obj[k], sizeof bits);
        h = mixed(h + 0x9E3779B97F4A7C15u + bits);
    }
    return h;
}

static uint32_t pair_hash(uint64_t camera, size_t triangle)
{
    return (uint32_t)(mixed(camera + 0x9E3779B97F4A7C15u * (triangle + 1)) >> 32);
}

typedef struct job {
    uint32_t *highest;
    const sheen_mesh *mesh;
    const double (*cameras_obj)[3];
    const uint64_t *hash; // [n_views]
    size_t n_views, most_views;
} job;

// Could any texel of it be seen from there?
static bool may_face(const sheen_mesh *mesh, size_t triangle, const double camera_obj[3])
{
    for (size_t i = 0; i < 3; i++) {
        const size_t corner = mesh->triangles[3 * triangle + i];
        float v[3];
        for (size_t k = 0; k < 3; k++)
            v[k] = (float)camera_obj[k] - mesh->p_obj[3 * corner + k];
        if (sheen_dotf(v, mesh->n_obj + 3 * corner) > 0)
            return true;
    }
    return false;
}

// Keeps the least hashes in order while looking through all cameras.
static void choose(void *self, size_t begin, size_t end)
{
    const job *j = self;
    assert(j->most_views > 0 && j->most_views <= MAX_CHOSEN);
    for (size_t f = begin; f < end; f++) {
        uint32_t least[MAX_CHOSEN];
        size_t n = 0, n_facing = 0;
        for (size_t v = 0; v < j->n_views; v++) {
            if (!may_face(j->mesh, f, j->cameras_obj[v]))
                continue;
            n_facing++;
            const uint32_t h = pair_hash(j->hash[v], f);
            if (n == j->most_views && h >= least[n - 1])
                continue;
            size_t at = n < j->most_views ? n++ : n - 1;
            for (; at && least[at - 1] > h; at--)
                least[at] = least[at - 1];
            least[at] = h;
        }
        j->highest[f] = n_facing > j->most_views ? least[n - 1] : UINT32_MAX;
    }
}

sheen_status sheen_view_choice_make(sheen_view_choice *out, const sheen_mesh *mesh,
                                    const double (*cameras_obj)[3], size_t n_views, size_t most_views,
                                    int n_threads, sheen_err *err)
{
    *out = (sheen_view_choice){.n_triangles = mesh->n_triangles};
    if (n_views <= most_views)
        return SHEEN_OK;
    out->highest = malloc(mesh->n_triangles * sizeof *out->highest);
    uint64_t *hash = malloc(n_views * sizeof *hash);
    if (!out->highest || !hash) {
        free(hash);
        sheen_view_choice_release(out);
        return sheen_fail_memory(err, 4.0 * (double)mesh->n_triangles, "the choice of photographs");
    }
    for (size_t v = 0; v < n_views; v++)
        hash[v] = camera_hash(cameras_obj[v]);
    job j = {out->highest, mesh,    cameras_obj,
             hash,         n_views, most_views < MAX_CHOSEN ? most_views : MAX_CHOSEN};
    sheen_parallel_for(mesh->n_triangles, 1024, n_threads, choose, &j);
    free(hash);
    return SHEEN_OK;
}

void sheen_view_choice_release(sheen_view_choice *c)
{
    free(c->highest);
    *c = (sheen_view_choice){0};
}

void sheen_view_choice_apply(const sheen_view_choice *c, sheen_texel_view *v, const double camera_obj[3])
{
    if (!c->highest)
        return;
    const uint64_t hash = camera_hash(camera_obj);
    const size_t per_triangle = v->n_texels / c->n_triangles;
    for (size_t f = 0; f < c->n_triangles; f++)
        if (pair_hash(hash, f) > c->highest[f])
            memset(v->seen + f * per_triangle, 0, per_triangle);
}
