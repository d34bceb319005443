// SPDX-License-Identifier: Apache-2.0
// refined_state.c - texels, gbuffers and residuals of all photographs, kept in step with the model.
#include "fit/refined_state.h"

#include <stdlib.h>
#include <string.h>

#include "fit/diffuse.h"

#include "base/parallel.h"

static void fill_texels(sheen_refined_state *r, size_t i_view)
{
    sheen_texel_view_fill(&r->views[i_view], r->mesh, r->scene, &r->f->gbuffers[i_view], &r->photos->cam,
                          &r->photos->photos[i_view], r->f->model.texture.texels_per_edge, r->o.n_threads);
    sheen_view_choice_apply(&r->choice, &r->views[i_view], r->f->gbuffers[i_view].p_camera_obj);
}

static sheen_status choose_views(sheen_refined_state *r, sheen_err *err)
{
    double(*cameras_obj)[3] = malloc((r->f->n_views + 1) * sizeof *cameras_obj);
    if (!cameras_obj)
        return sheen_fail_memory(err, 24.0 * (double)r->f->n_views, "views");
    for (size_t i = 0; i < r->f->n_views; i++)
        memcpy(cameras_obj[i], r->f->gbuffers[i].p_camera_obj, sizeof *cameras_obj);
    const sheen_status s = sheen_view_choice_make(&r->choice, r->mesh, (const double(*)[3])cameras_obj,
                                                  r->f->n_views, SHEEN_REFINED_MAX_VIEWS, r->o.n_threads,
                                                  err);
    free(cameras_obj);
    return s;
}

// The paper's start has seen all photographs' texels already; where it kept none they are looked up.
static sheen_status take_texels(sheen_refined_state *r, sheen_err *err)
{
    r->views = r->f->views;
    r->f->views = NULL;
    for (size_t i = 0; i < r->f->n_views && r->views; i++)
        sheen_view_choice_apply(&r->choice, &r->views[i], r->f->gbuffers[i].p_camera_obj);
    if (r->views)
        return SHEEN_OK;
    r->views = calloc(r->f->n_views + 1, sizeof *r->views);
    sheen_status s = r->views ? SHEEN_OK : sheen_fail_memory(err, 500.0 * (double)r->f->n_views, "views");
    for (size_t i = 0; i < r->f->n_views && !s; i++)
        if (!(s = sheen_texel_view_init(&r->views[i], r->mesh->n_triangles,
                                        r->f->model.texture.texels_per_edge, err)))
            fill_texels(r, i);
    return s;
}

sheen_status sheen_refined_state_init(sheen_refined_state *r, sheen_err *err)
{
    const size_t n = r->f->n_views;
    sheen_status s = sheen_scene_new(&r->scene, r->mesh, err);
    if (s || (s = choose_views(r, err)) || (s = take_texels(r, err)))
        return s;
    r->lights = calloc(n, sizeof *r->lights);
    r->shading = calloc(n, sizeof *r->shading);
    r->gloss = malloc((r->views[0].n_texels + 1) * sizeof *r->gloss);
    if (!r->gloss || !r->lights || !r->shading)
        return sheen_fail_memory(err, 500.0 * (double)n, "views");
    for (size_t i = 0; i < n && !s; i++)
        s = sheen_view_light_init(&r->lights[i], r->views[i].n_texels, err);
    return s;
}

void sheen_refined_state_release(sheen_refined_state *r)
{
    for (size_t i = 0; i < r->f->n_views; i++) {
        if (r->views)
            sheen_texel_view_release(&r->views[i]);
        if (r->lights)
            sheen_view_light_release(&r->lights[i]);
    }
    free(r->views);
    free(r->lights);
    free(r->shading);
    free(r->gloss);
    sheen_lamp_points_release(&r->points);
    sheen_light_cells_free(&r->cells);
    sheen_view_choice_release(&r->choice);
    sheen_scene_free(&r->scene);
}

sheen_status sheen_refined_reload_view(sheen_refined_state *r, size_t i_view, sheen_err *err)
{
    sheen_gbuffer g;
    const sheen_status s = sheen_gbuffer_make(&g, r->scene, r->mesh, &r->photos->cam,
                                              r->photos->photos[i_view].rt_cam_obj, 1, r->o.n_threads, err);
    if (s)
        return s;
    sheen_gbuffer_release(&r->f->gbuffers[i_view]);
    r->f->gbuffers[i_view] = g;
    fill_texels(r, i_view);
    r->keep_mirrored = 0;
    return SHEEN_OK;
}

static void fill_gloss(void *self, size_t begin, size_t end)
{
    const sheen_refined_state *r = self;
    const sheen_model *m = &r->f->model;
    for (size_t texel = begin; texel < end; texel++)
        r->gloss[texel] = sheen_gloss_at(&m->gloss, m->texture.rgb + 3 * texel);
}

sheen_status sheen_refined_light_views(sheen_refined_state *r, sheen_err *err)
{
    sheen_model *m = &r->f->model;
    sheen_light_cells_free(&r->cells);
    sheen_lamp_points_release(&r->points);
    sheen_status s = sheen_light_cells_new(&r->cells, &m->lights, (float)m->sigma_rad, err);
    if (!s)
        s = sheen_lamp_points_init(&r->points, m->lamps, m->n_lamps, (float)m->sigma_rad, err);
    if (m->gloss.n)
        sheen_parallel_for(r->views[0].n_texels, 4096, r->o.n_threads, fill_gloss, r);
    for (size_t i = 0; i < r->f->n_views && !s; i++) {
        r->lights[i].gloss = m->gloss.n ? r->gloss : NULL;
        if ((s = sheen_progress_step(&r->o.progress, "highlights and mirror images", (int)i,
                                     (int)r->f->n_views, err)))
            break;
        sheen_shading_init(&r->shading[i], m, r->scene, r->cells, &r->points,
                           r->photos->photos[i].rt_world_obj);
        sheen_view_light_fill(&r->lights[i], &r->shading[i], &r->views[i], r->f->gbuffers[i].p_camera_obj,
                              !r->keep_mirrored, r->o.n_threads);
    }
    r->keep_mirrored = 1;
    return s;
}

typedef struct mirrored_job {
    const sheen_refined_state *r;
    size_t i_view;
} mirrored_job;

static void subtract_at(const sheen_refined_state *r, size_t i_view, sheen_residual_pixel *p)
{
    const sheen_gbuffer *g = &r->f->gbuffers[i_view];
    const size_t at = (size_t)(p->y_px - g->y0_px) * (size_t)g->width_px + (size_t)(p->x_px - g->x0_px);
    float n_obj[3], v_obj[3], mirrored[3];
    sheen_normal_map_surface(r->mesh, &r->f->model.normals, &g->hits[at], g->p_camera_obj, NULL, n_obj,
                             v_obj);
    sheen_shade_mirrored(mirrored, &r->shading[i_view], p->p_obj, n_obj, v_obj, 1);
    float root[3];
    for (int c = 0; c < 3; c++)
        root[c] = (float)p->texture_root[c] / 255;
    const float F = sheen_gloss_at_root(&r->f->model.gloss, root) *
                    sheen_fresnel(r->f->model.surroundings.f0, sheen_dotf(n_obj, v_obj));
    for (int c = 0; c < 3; c++)
        p->rgb[c] -= F * mirrored[c];
    if (r->f->model.irradiance.present) { // the texture is an albedo
        float albedo[3], light[3];
        sheen_texture_sample(&r->f->model.texture, &g->hits[at], albedo);
        sheen_shade_irradiance(light, &r->shading[i_view], p->p_obj, n_obj);
        for (int c = 0; c < 3; c++)
            p->rgb[c] -= albedo[c] * (light[c] - 1);
    }
}

// Residuals are what the texture does not explain; here, nor what is mirrored.
static void subtract_mirrored(void *self, size_t begin, size_t end)
{
    const mirrored_job *j = self;
    for (size_t i = begin; i < end; i++)
        subtract_at(j->r, j->i_view, &j->r->f->residuals[j->i_view].pixels[i]);
}

sheen_status sheen_refined_residuals(sheen_refined_state *r, sheen_err *err)
{
    sheen_paper_fit *f = r->f;
    // Of lamps only the first steps look at them, and the pictures of the last
    const int with_hemispheres = r->round == 0 || r->round == SHEEN_REFINED_ROUNDS - 1 ||
                                 !sheen_extension_in(r->o.without, SHEEN_EXTENSION_LAMPS);
    sheen_status s = SHEEN_OK;
    for (size_t i = 0; i < f->n_views && !s; i++) {
        sheen_residual_release(&f->residuals[i]);
        if (with_hemispheres)
            sheen_partial_hemisphere_release(&f->partials[i]);
        if ((s = sheen_residual_make(&f->residuals[i], r->mesh, &f->model, &f->gbuffers[i], &r->photos->cam,
                                     &r->photos->photos[i], r->o.n_threads, err)))
            break;
        mirrored_job j = {r, i};
        sheen_parallel_for(f->residuals[i].count, 2048, r->o.n_threads, subtract_mirrored, &j);
        if (with_hemispheres)
            s = sheen_partial_hemisphere_make(&f->partials[i], &f->geodesic, &f->residuals[i], r->o.n_threads,
                                              err);
    }
    return s;
}
