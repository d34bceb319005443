// SPDX-License-Identifier: Apache-2.0
// draw_tile.c - texture and specular reflection of a square of samples.
//
// Interpolated normals turn away from the camera near outlines, where eq. (7) has no answer: there a normal
// is bent towards the camera until its cosine is MIN_FACING, so that highlights run on to the outline instead
// of breaking off in black speckles. A triangle seen from behind (the inside of an open mesh) has no specular
// part.
//
// A model of lights alone takes its samples' sum together (lobe_block.h); one with shadows, lamps or
// mirrored surroundings goes by shade.h.
#include "render/draw_tile.h"

#include <math.h>
#include <string.h>

#include "base/cpu_level.h"
#include "base/vec.h"

#define MIN_FACING 0.01f
// Light to which a sample's sum must agree with the single sum: a fiftieth of an 8-bit step.
#define TOLERANCE_LIN 1e-4f

// Places of a square in Morton's order of 16 x 16: x has the even bits of a number, y the odd ones. A smaller square comes first.
typedef struct place {
    uint8_t x, y;
} place;

#define MORTON_X(i) (((i)&1) | ((i) >> 1 & 2) | ((i) >> 2 & 4) | ((i) >> 3 & 8))
#define PLACE(i)                                                                                             \
    {                                                                                                        \
        MORTON_X(i), MORTON_X((i) >> 1)                                                                      \
    }
#define PLACES_4(i) PLACE(i), PLACE((i) + 1), PLACE((i) + 2), PLACE((i) + 3)
#define PLACES_16(i) PLACES_4(i), PLACES_4((i) + 4), PLACES_4((i) + 8), PLACES_4((i) + 12)
#define PLACES_64(i) PLACES_16(i), PLACES_16((i) + 16), PLACES_16((i) + 32), PLACES_16((i) + 48)
static const place places[SHEEN_TILE_SAMPLES] = {PLACES_64(0), PLACES_64(64), PLACES_64(128), PLACES_64(192)};

void sheen_tile_gather(sheen_tile *tile, const sheen_gbuffer *g, int x0, int y0, int side)
{
    const int columns = g->width_px * g->samples_per_side, rows = g->height_px * g->samples_per_side;
    const unsigned width = (unsigned)(columns - x0 < side ? columns - x0 : side),
                   height = (unsigned)(rows - y0 < side ? rows - y0 : side);
    const sheen_hit *first = g->hits + (size_t)y0 * (size_t)columns + (size_t)x0;
    unsigned count = 0, n = 1;
    while (n < (unsigned)(side * side)) // the next square of a power of two
        n *= 4;
    const int whole = width * height == n;
    for (unsigned i = 0; i < n; i++) {
        const place at = places[i];
        if (!whole && (at.x >= width || at.y >= height))
            continue;
        const sheen_hit *hit = first + (size_t)at.y * (size_t)columns + at.x;
        tile->hits[count] = *hit; // overwritten by the next if it is none
        tile->x[count] = at.x;
        tile->y[count] = at.y;
        count += hit->triangle != SHEEN_NO_HIT;
    }
    tile->count = (int)count;
}

// Where the object turned, its texture is an albedo; so is what holes were filled with.
static void light_diffuse(sheen_tile *tile, const sheen_shading *s, const double p_camera_obj[3])
{
    for (int i = 0; i < tile->count; i++) {
        float p_obj[3], n_obj[3], e[3];
        const float *albedo = tile->diffuse[i];
        if (!(albedo[0] + albedo[1] + albedo[2] > 0))
            continue;
        sheen_normal_map_surface(&s->model->mesh, &s->model->normals, &tile->hits[i], p_camera_obj, p_obj,
                                 n_obj, NULL);
        sheen_shade_irradiance(e, s, p_obj, n_obj);
        for (int c = 0; c < 3; c++)
            tile->diffuse[i][c] *= e[c];
    }
}

void sheen_tile_diffuse(sheen_tile *tile, const sheen_shading *s, const double p_camera_obj[3])
{
    float seen[SHEEN_TILE_SAMPLES];
    sheen_texture_samples(tile->diffuse[0], seen, &s->model->texture, tile->hits, (size_t)tile->count);
    for (int i = 0; i < tile->count; i++)
        tile->hole[i] = seen[i] <= 0;
    for (int i = 0; i < tile->count && s->model->gloss.n; i++)
        tile->gloss[i] = sheen_gloss_at(&s->model->gloss, tile->diffuse[i]);
    for (int i = 0; i < tile->count && !s->model->gloss.n; i++)
        tile->gloss[i] = 1;
    if (s->model->irradiance.present)
        light_diffuse(tile, s, p_camera_obj);
}

static bool seen_from_behind(const sheen_mesh *mesh, uint32_t triangle, const float v_obj[3])
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)triangle;
    const float *p = mesh->p_obj + 3 * (size_t)corner[0];
    float a[3], b[3], n[3];
    sheen_subf(a, mesh->p_obj + 3 * (size_t)corner[1], p);
    sheen_subf(b, mesh->p_obj + 3 * (size_t)corner[2], p);
    sheen_crossf(n, a, b);
    return sheen_dotf(n, v_obj) < 0;
}

// The nearest direction to n whose cosine with v is MIN_FACING: its part across v stays, its length is made
// up. False where there is no specular part.
static bool turn_to_camera(float n_obj[3], const float v_obj[3], float facing, const sheen_mesh *mesh,
                           uint32_t triangle)
{
    float across[3];
    if (seen_from_behind(mesh, triangle, v_obj))
        return false;
    for (int k = 0; k < 3; k++)
        across[k] = n_obj[k] - facing * v_obj[k];
    if (!(sheen_normalizef(across) > 0))
        return false;
    const float side = sqrtf(1 - MIN_FACING * MIN_FACING);
    for (int k = 0; k < 3; k++)
        n_obj[k] = side * across[k] + MIN_FACING * v_obj[k];
    return true;
}

// Normals and directions to the camera of all samples, in frame obj.
SHEEN_KERNEL_INLINE void surface_body(sheen_lobe_block *b, float facing[SHEEN_TILE_SAMPLES],
                                      const sheen_tile *tile, const sheen_mesh *mesh, const float camera[3])
{
    const int count = b->count = tile->count;
    for (int i = 0; i < count; i++) {
        const sheen_hit *hit = &tile->hits[i];
        const uint32_t *corner = mesh->triangles + 3 * (size_t)hit->triangle;
        const float b0 = 1 - hit->b1 - hit->b2, b1 = hit->b1, b2 = hit->b2;
        const float *n0 = mesh->n_obj + 3 * (size_t)corner[0], *p0 = mesh->p_obj + 3 * (size_t)corner[0];
        const float *n1 = mesh->n_obj + 3 * (size_t)corner[1], *p1 = mesh->p_obj + 3 * (size_t)corner[1];
        const float *n2 = mesh->n_obj + 3 * (size_t)corner[2], *p2 = mesh->p_obj + 3 * (size_t)corner[2];
        b->nx[i] = b0 * n0[0] + b1 * n1[0] + b2 * n2[0];
        b->ny[i] = b0 * n0[1] + b1 * n1[1] + b2 * n2[1];
        b->nz[i] = b0 * n0[2] + b1 * n1[2] + b2 * n2[2];
        b->vx[i] = camera[0] - (b0 * p0[0] + b1 * p1[0] + b2 * p2[0]);
        b->vy[i] = camera[1] - (b0 * p0[1] + b1 * p1[1] + b2 * p2[1]);
        b->vz[i] = camera[2] - (b0 * p0[2] + b1 * p1[2] + b2 * p2[2]);
    }
#pragma omp simd
    for (int i = 0; i < count; i++) {
        const float n2 = b->nx[i] * b->nx[i] + b->ny[i] * b->ny[i] + b->nz[i] * b->nz[i];
        const float v2 = b->vx[i] * b->vx[i] + b->vy[i] * b->vy[i] + b->vz[i] * b->vz[i];
        const float n_scale = 1 / sqrtf(n2 + 1e-30f), v_scale = 1 / sqrtf(v2 + 1e-30f);
        b->nx[i] *= n_scale;
        b->ny[i] *= n_scale;
        b->nz[i] *= n_scale;
        b->vx[i] *= v_scale;
        b->vy[i] *= v_scale;
        b->vz[i] *= v_scale;
        facing[i] = b->nx[i] * b->vx[i] + b->ny[i] * b->vy[i] + b->nz[i] * b->vz[i];
    }
}

static void surface_baseline(sheen_lobe_block *b, float facing[SHEEN_TILE_SAMPLES], const sheen_tile *tile,
                             const sheen_mesh *mesh, const float camera[3])
{
    surface_body(b, facing, tile, mesh, camera);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX512 static void surface_avx512(sheen_lobe_block *b, float facing[SHEEN_TILE_SAMPLES],
                                               const sheen_tile *tile, const sheen_mesh *mesh,
                                               const float camera[3])
{
    surface_body(b, facing, tile, mesh, camera);
}

SHEEN_TARGET_AVX2 static void surface_avx2(sheen_lobe_block *b, float facing[SHEEN_TILE_SAMPLES],
                                           const sheen_tile *tile, const sheen_mesh *mesh,
                                           const float camera[3])
{
    surface_body(b, facing, tile, mesh, camera);
}
#endif

static void surface(sheen_lobe_block *b, float facing[SHEEN_TILE_SAMPLES], const sheen_tile *tile,
                    const sheen_mesh *mesh, const double p_camera_obj[3])
{
    const float camera[3] = {(float)p_camera_obj[0], (float)p_camera_obj[1], (float)p_camera_obj[2]};
#if defined(__x86_64__)
    const int level = sheen_cpu_level();
    if (level >= SHEEN_CPU_AVX512) {
        surface_avx512(b, facing, tile, mesh, camera);
        return;
    }
    if (level == SHEEN_CPU_AVX2) {
        surface_avx2(b, facing, tile, mesh, camera);
        return;
    }
#endif
    surface_baseline(b, facing, tile, mesh, camera);
}

// The normal map's part in it.
static void bend(sheen_lobe_block *b, float facing[SHEEN_TILE_SAMPLES], const sheen_tile *tile,
                 const sheen_texture *normals)
{
    for (int i = 0; i < tile->count && normals->n_triangles; i++) {
        float n[3] = {b->nx[i], b->ny[i], b->nz[i]};
        sheen_normal_map_bend(n, normals, &tile->hits[i]);
        b->nx[i] = n[0];
        b->ny[i] = n[1];
        b->nz[i] = n[2];
        facing[i] = b->nx[i] * b->vx[i] + b->ny[i] * b->vy[i] + b->nz[i] * b->vz[i];
    }
}

// Turns normals at outlines. dark[i]: the sample has no specular part.
static void mend_outline(sheen_lobe_block *b, bool dark[SHEEN_TILE_SAMPLES],
                         const float facing[SHEEN_TILE_SAMPLES], const sheen_tile *tile,
                         const sheen_mesh *mesh)
{
    for (int i = 0; i < tile->count; i++) {
        dark[i] = false;
        if (facing[i] >= MIN_FACING)
            continue;
        float n[3] = {b->nx[i], b->ny[i], b->nz[i]};
        const float v[3] = {b->vx[i], b->vy[i], b->vz[i]};
        dark[i] = !turn_to_camera(n, v, facing[i], mesh, tile->hits[i].triangle);
        b->nx[i] = n[0];
        b->ny[i] = n[1];
        b->nz[i] = n[2];
    }
}

// Normals and directions from frame obj to world.
SHEEN_KERNEL_INLINE void turn_body(sheen_lobe_block *b, const float R_world_obj[3][3])
{
    const float r00 = R_world_obj[0][0], r01 = R_world_obj[0][1], r02 = R_world_obj[0][2];
    const float r10 = R_world_obj[1][0], r11 = R_world_obj[1][1], r12 = R_world_obj[1][2];
    const float r20 = R_world_obj[2][0], r21 = R_world_obj[2][1], r22 = R_world_obj[2][2];
#pragma omp simd
    for (int i = 0; i < b->count; i++) {
        const float nx = b->nx[i], ny = b->ny[i], nz = b->nz[i];
        const float vx = b->vx[i], vy = b->vy[i], vz = b->vz[i];
        b->nx[i] = r00 * nx + r01 * ny + r02 * nz;
        b->ny[i] = r10 * nx + r11 * ny + r12 * nz;
        b->nz[i] = r20 * nx + r21 * ny + r22 * nz;
        b->vx[i] = r00 * vx + r01 * vy + r02 * vz;
        b->vy[i] = r10 * vx + r11 * vy + r12 * vz;
        b->vz[i] = r20 * vx + r21 * vy + r22 * vz;
    }
}

static void turn_baseline(sheen_lobe_block *b, const float R_world_obj[3][3])
{
    turn_body(b, R_world_obj);
}

#if defined(__x86_64__)
SHEEN_TARGET_AVX512 static void turn_avx512(sheen_lobe_block *b, const float R_world_obj[3][3])
{
    turn_body(b, R_world_obj);
}

SHEEN_TARGET_AVX2 static void turn_avx2(sheen_lobe_block *b, const float R_world_obj[3][3])
{
    turn_body(b, R_world_obj);
}
#endif

static void turn_to_world(sheen_lobe_block *b, const float R_world_obj[3][3])
{
#if defined(__x86_64__)
    const int level = sheen_cpu_level();
    if (level >= SHEEN_CPU_AVX512) {
        turn_avx512(b, R_world_obj);
        return;
    }
    if (level == SHEEN_CPU_AVX2) {
        turn_avx2(b, R_world_obj);
        return;
    }
#endif
    turn_baseline(b, R_world_obj);
}

// With shadows, and what is mirrored besides the lights.
static void shade_each(sheen_tile *tile, const sheen_lobe_block *b, const bool *dark, const sheen_shading *s,
                       const double p_camera_obj[3])
{
    float p[SHEEN_TILE_SAMPLES][3], n[SHEEN_TILE_SAMPLES][3], v[SHEEN_TILE_SAMPLES][3];
    float rgb[SHEEN_TILE_SAMPLES][3], gloss[SHEEN_TILE_SAMPLES];
    int sample[SHEEN_TILE_SAMPLES];
    size_t count = 0;
    memset(tile->specular, 0, (size_t)tile->count * sizeof tile->specular[0]);
    for (int i = 0; i < tile->count; i++) {
        if (dark[i])
            continue;
        const float n_i[3] = {b->nx[i], b->ny[i], b->nz[i]}, v_i[3] = {b->vx[i], b->vy[i], b->vz[i]};
        sheen_hit_surface(&s->model->mesh, &tile->hits[i], p_camera_obj, p[count], NULL, NULL);
        memcpy(n[count], n_i, sizeof n_i);
        memcpy(v[count], v_i, sizeof v_i);
        gloss[count] = tile->gloss[i];
        sample[count++] = i;
    }
    if (!count)
        return;
    sheen_shade(rgb[0], s, gloss, p[0], n[0], v[0], count);
    for (size_t i = 0; i < count; i++)
        memcpy(tile->specular[sample[i]], rgb[i], sizeof rgb[i]);
}

static void shade_together(sheen_tile *tile, sheen_lobe_block *b, const bool *dark, const sheen_shading *s)
{
    float rgb[3], most = 0;
    for (int c = 0; c < 3; c++) {
        rgb[c] = (float)(s->model->k_s * s->model->light_rgb[c]);
        most = fmaxf(most, rgb[c]);
    }
    turn_to_world(b, s->R_world_obj);
    sheen_lobe_block_sum(b, s->cells, TOLERANCE_LIN / fmaxf(most, 1e-6f));
    for (int i = 0; i < tile->count; i++) {
        const float sum = dark[i] ? 0 : b->sum[i];
        tile->specular[i][0] = rgb[0] * sum;
        tile->specular[i][1] = rgb[1] * sum;
        tile->specular[i][2] = rgb[2] * sum;
    }
}

void sheen_tile_specular(sheen_tile *tile, const sheen_shading *s, const double p_camera_obj[3])
{
    sheen_lobe_block b;
    float facing[SHEEN_TILE_SAMPLES];
    bool dark[SHEEN_TILE_SAMPLES] = {false};
    surface(&b, facing, tile, &s->model->mesh, p_camera_obj);
    bend(&b, facing, tile, &s->model->normals);
    mend_outline(&b, dark, facing, tile, &s->model->mesh);
    if (s->model->shadows || s->model->surroundings.present || s->model->n_lamps || s->model->gloss.n)
        shade_each(tile, &b, dark, s, p_camera_obj);
    else
        shade_together(tile, &b, dark, s);
}
