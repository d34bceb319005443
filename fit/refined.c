// SPDX-License-Identifier: Apache-2.0
// refined.c - alternates between surroundings, texture and lights, each given the others.
#include "fit/refined.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/board_picture.h"
#include "fit/diffuse.h"
#include "fit/samples.h"

enum { ROUNDS = 3 };

typedef struct run {
    sheen_paper_fit *f;
    const sheen_mesh *mesh;
    const sheen_photos *photos;
    sheen_paper_options o;
    sheen_scene *scene;
    sheen_texel_view *views;  // [n_views]
    sheen_view_light *lights; // [n_views]
    sheen_light_cells *cells;
    sheen_shading *shading; // [n_views]
    sheen_samples samples;  // during the lights' estimation
} run;

static sheen_status allocate(run *r, sheen_err *err)
{
    const size_t n = r->f->n_views, n_triangles = r->mesh->n_triangles;
    const int edge = r->f->model.texture.texels_per_edge;
    sheen_status s = SHEEN_OK;
    r->views = calloc(n, sizeof *r->views);
    r->lights = calloc(n, sizeof *r->lights);
    r->shading = calloc(n, sizeof *r->shading);
    if (!r->views || !r->lights || !r->shading)
        return sheen_fail_memory(err, 500.0 * (double)n, "views");
    for (size_t i = 0; i < n && !s; i++) {
        if ((s = sheen_texel_view_init(&r->views[i], n_triangles, edge, err)) ||
            (s = sheen_view_light_init(&r->lights[i], r->views[i].n_texels, err)))
            break;
        sheen_texel_view_fill(&r->views[i], r->mesh, r->scene, &r->f->gbuffers[i], &r->photos->cam,
                              &r->photos->photos[i], edge, r->o.n_threads);
    }
    return s;
}

static sheen_status light_views(run *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    sheen_light_cells_free(&r->cells);
    sheen_status s = sheen_light_cells_new(&r->cells, &m->lights, (float)m->sigma_rad, err);
    for (size_t i = 0; i < r->f->n_views && !s; i++) {
        if ((s = sheen_progress_step(&r->o.progress, "highlights and mirror images", (int)i,
                                     (int)r->f->n_views, err)))
            break;
        sheen_shading_init(&r->shading[i], m, r->scene, r->cells, r->photos->photos[i].rt_world_obj);
        sheen_view_light_fill(&r->lights[i], &r->shading[i], &r->views[i], r->f->gbuffers[i].p_camera_obj,
                              r->o.n_threads);
    }
    return s;
}

// Residuals are what the texture does not explain; here, nor what is mirrored.
static void subtract_mirrored(run *r, size_t i_view)
{
    const sheen_gbuffer *g = &r->f->gbuffers[i_view];
    sheen_residual *residual = &r->f->residuals[i_view];
    for (size_t i = 0; i < residual->count; i++) {
        sheen_residual_pixel *p = &residual->pixels[i];
        const size_t at = (size_t)(p->y_px - g->y0_px) * (size_t)g->width_px + (size_t)(p->x_px - g->x0_px);
        float n_obj[3], v_obj[3], mirrored[3];
        sheen_hit_surface(r->mesh, &g->hits[at], g->p_camera_obj, NULL, n_obj, v_obj);
        sheen_shade_mirrored(mirrored, &r->shading[i_view], p->p_obj, n_obj, v_obj);
        const float F = sheen_fresnel(r->f->model.surroundings.f0, sheen_dotf(n_obj, v_obj));
        for (int c = 0; c < 3; c++)
            p->rgb[c] -= F * mirrored[c];
    }
}

static sheen_status make_residuals(run *r, sheen_err *err)
{
    sheen_paper_fit *f = r->f;
    sheen_status s = SHEEN_OK;
    for (size_t i = 0; i < f->n_views && !s; i++) {
        sheen_residual_release(&f->residuals[i]);
        sheen_partial_hemisphere_release(&f->partials[i]);
        if ((s = sheen_residual_make(&f->residuals[i], r->mesh, &f->model.texture, &f->gbuffers[i],
                                     &r->photos->cam, &r->photos->photos[i], err)))
            break;
        subtract_mirrored(r, i);
        s = sheen_partial_hemisphere_make(&f->partials[i], &f->geodesic, &f->residuals[i], err);
    }
    return s;
}

static int is_hidden(void *self, size_t i_sample, const float l_world[3])
{
    const run *r = self;
    const sheen_shading *sh = &r->shading[r->samples.view[i_sample]];
    return sheen_shade_hidden(sh, r->samples.p_obj + 3 * i_sample, r->samples.n_world + 3 * i_sample,
                              l_world);
}

static sheen_status estimate_lights(run *r, sheen_err *err)
{
    sheen_hemisphere_release(&r->f->combined);
    sheen_status s = sheen_hemisphere_combine(&r->f->combined, r->f->partials, r->f->n_views,
                                              (float)r->f->threshold_lin, 0.7f, err);
    if (s)
        return s;
    if (!r->f->combined.n_assigned)
        return sheen_fail(err, SHEEN_EDATA, "no highlight is left once the surroundings are accounted for");
    r->o.sigma0_rad = 2 * r->f->model.sigma_rad; // from above again: the first fit stops short on either side
    s = sheen_paper_lights(r->f, &r->samples, &r->o, is_hidden, r, err);
    sheen_samples_release(&r->samples);
    return s;
}

static sheen_status improve(run *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    sheen_stopwatch watch = sheen_stopwatch_now();
    sheen_status s = sheen_board_picture_make(&m->surroundings, r->photos, r->mesh, r->scene, r->o.n_threads,
                                              err);
    if (s)
        return s;
    m->surroundings.present = 1;
    m->surroundings.f0 = 0.04;
    m->shadows = 1;
    sheen_progress_timed(&r->o.progress, "picture of the board", &watch);
    for (int round = 0; round < ROUNDS; round++) {
        if ((s = light_views(r, err)))
            return s;
        sheen_surroundings_fit(&m->surroundings, r->views, r->lights, r->f->n_views);
        sheen_diffuse_fit(&m->texture, &m->surroundings, r->views, r->lights, r->f->n_views, r->o.n_threads);
        sheen_progress_timed(&r->o.progress, "texture and surroundings", &watch);
        if (round == ROUNDS - 1)
            break;
        if ((s = make_residuals(r, err)) || (s = estimate_lights(r, err)))
            return s;
        sheen_progress_timed(&r->o.progress, "lights and roughness", &watch);
    }
    return SHEEN_OK;
}

sheen_status sheen_refined_fit(sheen_paper_fit *f, const sheen_mesh *mesh, const sheen_photos *photos,
                               const sheen_paper_options *options, sheen_err *err)
{
    run r = {.f = f, .mesh = mesh, .photos = photos, .o = *options};
    if (f->n_views > SHEEN_REFINED_MAX_VIEWS)
        return sheen_fail(err, SHEEN_EUNSUP,
                          "the refined method takes at most %d photographs, not %zu: use --method paper",
                          SHEEN_REFINED_MAX_VIEWS, f->n_views);
    const sheen_mesh own = f->model.mesh;
    f->model.mesh = *mesh; // lent for the time of the fit
    sheen_status s = sheen_scene_new(&r.scene, mesh, err);
    if (!s && !(s = allocate(&r, err)))
        s = improve(&r, err);
    f->model.mesh = own;
    for (size_t i = 0; i < f->n_views; i++) {
        if (r.views)
            sheen_texel_view_release(&r.views[i]);
        if (r.lights)
            sheen_view_light_release(&r.lights[i]);
    }
    free(r.views);
    free(r.lights);
    free(r.shading);
    sheen_light_cells_free(&r.cells);
    sheen_scene_free(&r.scene);
    if (!s)
        snprintf(f->model.method, sizeof f->model.method, "refined");
    return s;
}
