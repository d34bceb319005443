// SPDX-License-Identifier: Apache-2.0
// pictures.c - draws what a fit went through.
#include "fit/pictures.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/vec.h"

enum { DISC_PX = 512 };

static sheen_status write_picture(const sheen_image *img, const char *dir, const char *kind, const char *view,
                                  sheen_err *err)
{
    char name[128], path[SHEEN_PATH_MAX];
    snprintf(name, sizeof name, "%s%s%s.png", kind, *view ? "-" : "", view);
    const sheen_status s = sheen_path_join(path, dir, name, err);
    return s ? s : sheen_png_write_srgb(path, img, err);
}

static sheen_status write_residual(const sheen_residual *r, const sheen_gbuffer *g, const char *view,
                                   const char *dir, sheen_err *err)
{
    sheen_image img = {0};
    if (!g->width_px)
        return SHEEN_OK;
    sheen_status s = sheen_image_init(&img, g->width_px, g->height_px, 3, err);
    if (s)
        return s;
    for (size_t i = 0; i < r->count; i++) {
        const sheen_residual_pixel *p = &r->pixels[i];
        memcpy(sheen_image_at(&img, p->x_px - g->x0_px, p->y_px - g->y0_px), p->rgb, sizeof p->rgb);
    }
    s = write_picture(&img, dir, "residual", view, err);
    sheen_image_release(&img);
    return s;
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// 1 over the 99th percentile of the nodes' positive Y; 1 where there are none.
static float exposure_of(const float *rgb, size_t n_nodes)
{
    float *lit = malloc((n_nodes + 1) * sizeof *lit);
    if (!lit)
        return 1;
    size_t n = 0;
    for (size_t i = 0; i < n_nodes; i++)
        if (sheen_luminance(rgb + 3 * i) > 0)
            lit[n++] = sheen_luminance(rgb + 3 * i);
    float exposure = 1;
    if (n) {
        qsort(lit, n, sizeof *lit, compare_floats);
        exposure = 1 / lit[n * 99 / 100];
    }
    free(lit);
    return exposure;
}

// The hemisphere from above: a pixel inside the disc shows the node nearest to its direction.
static sheen_status write_hemisphere(const float *rgb, const sheen_geodesic *g, const char *kind,
                                     const char *view, const char *dir, sheen_err *err)
{
    sheen_image img = {0};
    sheen_status s = sheen_image_init(&img, DISC_PX, DISC_PX, 3, err);
    if (s)
        return s;
    const float exposure = exposure_of(rgb, g->n_nodes);
    for (int y = 0; y < DISC_PX; y++)
        for (int x = 0; x < DISC_PX; x++) {
            const float r = 0.5f * DISC_PX;
            float v[3] = {((float)x + 0.5f - r) / r, (r - (float)y - 0.5f) / r, 0};
            const float xy = v[0] * v[0] + v[1] * v[1];
            float *out = sheen_image_at(&img, x, y);
            v[2] = sqrtf(fmaxf(0, 1 - xy));
            const uint32_t node = xy < 1 ? sheen_geodesic_nearest(g, v) : UINT32_MAX;
            for (int c = 0; c < 3; c++)
                out[c] = node == UINT32_MAX ? 0.02f : rgb[3 * node + (uint32_t)c] * exposure;
        }
    s = write_picture(&img, dir, kind, view, err);
    sheen_image_release(&img);
    return s;
}

// Adds light to the nodes within `width_rad` of a direction, fading outwards, so that single nodes can be seen.
static void splat(float *rgb, const sheen_geodesic *g, const float direction[3], float width_rad,
                  const float light_rgb[3])
{
    for (size_t node = 0; node < g->n_nodes; node++) {
        float d[3];
        sheen_subf(d, g->v_world + 3 * node, direction);
        const float w = expf(-2 * sheen_dotf(d, d) / (width_rad * width_rad));
        for (size_t c = 0; c < 3 && w > 1e-4f; c++)
            rgb[3 * node + c] += w * light_rgb[c];
    }
}

// Nodes by their radiance, lamps by their light over the area of their disc.
static void splat_lights(float *rgb, const sheen_paper_fit *f)
{
    const sheen_model *m = &f->model;
    const float width_rad = 1.5f * f->geodesic.spacing_rad;
    float light_rgb[3];
    for (size_t i = 0; i < m->lights.count; i++) {
        for (int c = 0; c < 3; c++)
            light_rgb[c] = m->radiance[i] * (float)m->light_rgb[c];
        splat(rgb, &f->geodesic, f->geodesic.v_world + 3 * m->node[i], width_rad, light_rgb);
    }
    for (size_t i = 0; i < m->n_lamps; i++) {
        const float wide_rad = fmaxf(width_rad, m->lamps[i].radius_rad), shrink = width_rad / wide_rad;
        for (int c = 0; c < 3; c++)
            light_rgb[c] = shrink * shrink * m->lamps[i].rgb[c];
        splat(rgb, &f->geodesic, m->lamps[i].direction_world, wide_rad, light_rgb);
    }
}

static sheen_status write_hemispheres(const sheen_paper_fit *f, const sheen_photos *photos, const char *dir,
                                      sheen_err *err)
{
    const size_t n = f->geodesic.n_nodes;
    float *rgb = calloc(3 * n, sizeof *rgb);
    if (!rgb)
        return sheen_fail_memory(err, 12.0 * (double)n, "a picture of the hemisphere");
    sheen_status s = SHEEN_OK;
    for (size_t i = 0; i < f->n_views && !s; i++)
        s = write_hemisphere(f->partials[i].rgb, &f->geodesic, "hemisphere-partial", photos->photos[i].name,
                             dir, err);
    for (size_t i = 0; i < 3 * n; i++)
        rgb[i] = (float)f->combined.n_reached[i / 3];
    if (!s)
        s = write_hemisphere(rgb, &f->geodesic, "hemisphere-mask", "", dir, err);
    if (!s)
        s = write_hemisphere(f->combined.rgb, &f->geodesic, "hemisphere-combined", "", dir, err);
    memset(rgb, 0, 3 * n * sizeof *rgb);
    splat_lights(rgb, f);
    if (!s)
        s = write_hemisphere(rgb, &f->geodesic, "hemisphere-refined", "", dir, err);
    free(rgb);
    return s;
}

static sheen_status write_texture(const sheen_texture *t, const char *kind, const char *dir, sheen_err *err)
{
    sheen_image atlas = {0}, img = {0};
    sheen_status s = sheen_texture_to_atlas(&atlas, t, err);
    if (s || (s = sheen_image_init(&img, atlas.width_px, atlas.height_px, 3, err)))
        goto done;
    const size_t n = (size_t)atlas.width_px * (size_t)atlas.height_px;
    const float magenta[3] = {1, 0, 1};
    for (size_t i = 0; i < n; i++)
        memcpy(img.data + 3 * i, atlas.data[4 * i + 3] > 0 ? atlas.data + 4 * i : magenta, sizeof magenta);
    s = write_picture(&img, dir, kind, "", err);

done:
    sheen_image_release(&atlas);
    sheen_image_release(&img);
    return s;
}

// How sure each texel is, on the atlas, and as the first photograph sees it.
static sheen_status write_deviation(const sheen_paper_fit *f, const char *dir, sheen_err *err)
{
    const sheen_texture *t = &f->model.texture;
    const sheen_gbuffer *g = &f->gbuffers[0];
    const size_t n = t->n_triangles * sheen_texels_per_triangle(t->texels_per_edge);
    sheen_texture grey = *t;
    sheen_image img = {0};
    if (!f->texel_deviation)
        return SHEEN_OK;
    if (!(grey.rgb = malloc((3 * n + 1) * sizeof *grey.rgb)))
        return sheen_fail_memory(err, 12.0 * (double)n, "a picture of the texels' uncertainty");
    for (size_t i = 0; i < 3 * n; i++) {
        const float d = f->texel_deviation[i / 3];
        grey.rgb[i] = isnan(d) ? 1 : fminf(1, SHEEN_DEVIATION_SCALE * d);
    }
    sheen_status s = write_texture(&grey, "texture-deviation", dir, err);
    if (!s && g->width_px)
        s = sheen_image_init(&img, g->width_px, g->height_px, 3, err);
    for (int y = 0; y < img.height_px && !s; y++)
        for (int x = 0; x < img.width_px; x++) {
            const sheen_hit *h = &g->hits[(size_t)y * (size_t)g->width_px + (size_t)x];
            if (h->triangle != SHEEN_NO_HIT)
                sheen_texture_sample(&grey, h, sheen_image_at(&img, x, y));
        }
    if (!s && img.data)
        s = write_picture(&img, dir, "deviation", "", err);
    sheen_image_release(&img);
    free(grey.rgb);
    return s;
}

sheen_status sheen_fit_pictures(const sheen_paper_fit *f, const sheen_photos *photos, const char *dir,
                                sheen_err *err)
{
    sheen_status s = write_texture(&f->model.texture, "texture", dir, err);
    if (!s)
        s = write_deviation(f, dir, err);
    for (size_t i = 0; i < f->n_views && !s; i++)
        s = write_residual(&f->residuals[i], &f->gbuffers[i], photos->photos[i].name, dir, err);
    return s ? s : write_hemispheres(f, photos, dir, err);
}
