// SPDX-License-Identifier: Apache-2.0
// paper.c - the paper's steps in their order; each is a file of its own.
#include "fit/paper.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/global_texture.h"
#include "fit/samples.h"
#include "fit/start_sigma.h"

typedef struct run {
    sheen_paper_fit *f;
    const sheen_mesh *mesh;
    const sheen_photos *photos;
    sheen_paper_options o;
    sheen_stopwatch watch;
} run;

static void set_defaults(sheen_paper_options *o)
{
    if (o->frequency <= 0)
        o->frequency = 60;
    if (!(o->threshold_lin > 0))
        o->threshold_lin = 0.04;
    if (!(o->consistency > 0))
        o->consistency = 1;
    if (!o->max_samples)
        o->max_samples = 30000;
}

// What each camera sees, by rays (section 2.1: mesh and cameras are known).
static sheen_status see(run *r, const sheen_scene *scene, sheen_err *err)
{
    for (size_t i = 0; i < r->photos->count; i++) {
        sheen_status s = sheen_progress_step(&r->o.progress, "visibility", (int)i, (int)r->photos->count,
                                             err);
        if (s || (s = sheen_gbuffer_make(&r->f->gbuffers[i], scene, r->mesh, &r->photos->cam,
                                         r->photos->photos[i].rt_cam_obj, 1, r->o.n_threads, err)))
            return s;
    }
    sheen_progress_timed(&r->o.progress, "visibility", &r->watch);
    return SHEEN_OK;
}

// Section 3.2.
static sheen_status make_texture(run *r, const sheen_scene *scene, sheen_err *err)
{
    if (!r->o.texels_per_edge)
        r->o.texels_per_edge = sheen_texels_per_edge_for(r->mesh, r->photos);
    if (r->o.keep_texels && !(r->f->views = calloc(r->f->n_views, sizeof *r->f->views)))
        return sheen_fail_memory(err, 24.0 * (double)r->f->n_views, "views");
    const sheen_global_texture_options o = {r->o.texels_per_edge, r->f->views, r->o.n_threads,
                                            &r->o.progress};
    const sheen_status s = sheen_global_texture_minimum(&r->f->model.texture, r->mesh, scene, r->photos,
                                                        r->f->gbuffers, &o, err);
    sheen_progress_timed(&r->o.progress, "global texture", &r->watch);
    return s;
}

// Section 4.1: residual images, partial hemispheres, mask and combined hemisphere.
static sheen_status make_hemisphere(run *r, sheen_err *err)
{
    sheen_paper_fit *f = r->f;
    sheen_status s = sheen_geodesic_init(&f->geodesic, r->o.frequency, err);
    for (size_t i = 0; i < f->n_views && !s; i++) {
        if ((s = sheen_progress_step(&r->o.progress, "illumination hemisphere", (int)i, (int)f->n_views,
                                     err)))
            break;
        s = sheen_residual_make(&f->residuals[i], r->mesh, &f->model, &f->gbuffers[i], &r->photos->cam,
                                &r->photos->photos[i], r->o.n_threads, err);
        if (!s)
            s = sheen_partial_hemisphere_make(&f->partials[i], &f->geodesic, &f->residuals[i], r->o.n_threads,
                                              err);
    }
    if (s || (s = sheen_hemisphere_combine(&f->combined, f->partials, f->n_views, (float)r->o.threshold_lin,
                                           (float)r->o.consistency, err)))
        return s;
    sheen_progress_timed(&r->o.progress, "illumination hemisphere", &r->watch);
    return SHEEN_OK;
}

// The nodes with a value: their directions and their Y.
static size_t list_nodes(sheen_paper_fit *f, float *node_world, float *radiance0)
{
    const size_t n = f->combined.n_assigned;
    size_t k = 0;
    for (uint32_t i = 0; i < f->geodesic.n_nodes && k < n; i++) {
        const float Y = sheen_luminance(f->combined.rgb + 3 * i);
        if (!(Y > 0))
            continue;
        memcpy(node_world + 3 * k, f->geodesic.v_world + 3 * i, 3 * sizeof *node_world);
        radiance0[k] = Y;
        f->nodes[k++] = i;
    }
    f->combined.n_assigned = k;
    return k;
}

// The nodes that are still lit become the model's lights.
static sheen_status set_lights(sheen_paper_fit *f, sheen_err *err)
{
    sheen_model *m = &f->model;
    sheen_status s = sheen_model_set_lights(m, f->refined.n_nodes_left, err);
    if (s)
        return s;
    m->frequency = f->geodesic.frequency;
    m->n_hemisphere = f->geodesic.n_nodes;
    m->k_s = f->refined.k_s;
    m->sigma_rad = f->refined.sigma_rad;
    sheen_hemisphere_colour(m->light_rgb, &f->combined);
    const double omega_sr = sheen_geodesic_solid_angle_sr(&f->geodesic);
    size_t k = 0;
    for (size_t i = 0; i < f->combined.n_assigned; i++) {
        if (!(f->refined.radiance[i] > 0))
            continue;
        const float *v = f->geodesic.v_world + 3 * f->nodes[i];
        m->node[k] = f->nodes[i];
        m->radiance[k] = (float)f->refined.radiance[i];
        m->lights.dx[k] = v[0];
        m->lights.dy[k] = v[1];
        m->lights.dz[k] = v[2];
        m->lights.weight[k] = (float)(omega_sr * f->refined.radiance[i]);
        k++;
    }
    return SHEEN_OK;
}

sheen_status sheen_paper_lights(sheen_paper_fit *f, sheen_samples *samples,
                                const sheen_paper_options *options,
                                int (*hidden)(void *self, size_t i_sample, const float l_world[3]),
                                void *hidden_self, sheen_err *err)
{
    const size_t n = f->combined.n_assigned,
                 max_samples = options->max_samples ? options->max_samples : 30000;
    float *node_world = malloc((3 * n + 1) * sizeof *node_world),
          *radiance0 = malloc((n + 1) * sizeof *radiance0);
    sheen_status s = SHEEN_OK;
    free(f->nodes);
    f->nodes = malloc((n + 1) * sizeof *f->nodes);
    sheen_refine_result_release(&f->refined);
    if (!node_world || !radiance0 || !f->nodes) {
        s = sheen_fail_memory(err, 20.0 * (double)n, "light nodes");
        goto done;
    }
    const size_t n_nodes = list_nodes(f, node_world, radiance0);
    f->sigma0_rad = options->sigma0_rad;
    if (!(f->sigma0_rad > 0))
        f->sigma0_rad = sheen_start_sigma(&f->combined, &f->geodesic);
    if ((s = sheen_samples_take(samples, f->residuals, f->n_views, (float)f->threshold_lin, max_samples,
                                err)))
        goto done;
    f->n_samples = samples->count;
    const sheen_refine_options o = {.sigma0_rad = f->sigma0_rad,
                                    .loss = options->loss,
                                    .hidden = hidden,
                                    .hidden_self = hidden_self,
                                    .n_threads = options->n_threads,
                                    .progress = options->progress};
    s = sheen_refine(&f->refined, samples, node_world, radiance0, n_nodes,
                     sheen_geodesic_solid_angle_sr(&f->geodesic), &o, err);
    if (!s)
        s = set_lights(f, err);

done:
    free(node_world);
    free(radiance0);
    return s;
}

// Section 4.3.
static sheen_status estimate_lights(run *r, sheen_err *err)
{
    sheen_samples samples = {0};
    if (!r->f->combined.n_assigned)
        return sheen_fail(
            err, SHEEN_EDATA,
            "no highlight that the photographs agree on (threshold %g of white): the surface may be "
            "matte, or mesh and poses may not fit the photographs",
            r->o.threshold_lin);
    const sheen_status s = sheen_paper_lights(r->f, &samples, &r->o, NULL, NULL, err);
    sheen_samples_release(&samples);
    sheen_progress_timed(&r->o.progress, "lights and roughness", &r->watch);
    return s;
}

static sheen_status make(run *r, sheen_err *err)
{
    sheen_scene *scene = NULL;
    sheen_status s = sheen_scene_new(&scene, r->mesh, err);
    snprintf(r->f->model.method, sizeof r->f->model.method, "paper");
    if (!s && !(s = see(r, scene, err)) && !(s = make_texture(r, scene, err)))
        s = r->o.stop_after == SHEEN_PAPER_TEXTURE ? sheen_geodesic_init(&r->f->geodesic, r->o.frequency, err)
                                                   : make_hemisphere(r, err);
    sheen_scene_free(&scene);
    return s || r->o.stop_after ? s : estimate_lights(r, err);
}

sheen_status sheen_paper_fit_make(sheen_paper_fit *out, const sheen_mesh *mesh, const sheen_photos *photos,
                                  const sheen_paper_options *options, sheen_err *err)
{
    *out = (sheen_paper_fit){.n_views = photos->count};
    sheen_model_init(&out->model);
    run r = {.f = out, .mesh = mesh, .photos = photos, .o = *options, .watch = sheen_stopwatch_now()};
    set_defaults(&r.o);
    out->threshold_lin = r.o.threshold_lin;
    if (photos->count < 2)
        return sheen_fail(
            err, SHEEN_EDATA,
            "%zu photograph with a pose is too few: highlights are told from texture by how they move, "
            "which takes at least 2 and better 8",
            photos->count);
    out->gbuffers = calloc(out->n_views, sizeof *out->gbuffers);
    out->residuals = calloc(out->n_views, sizeof *out->residuals);
    out->partials = calloc(out->n_views, sizeof *out->partials);
    const sheen_status s = out->gbuffers && out->residuals && out->partials
                               ? make(&r, err)
                               : sheen_fail_memory(err, 200.0 * (double)out->n_views, "views");
    if (s)
        sheen_paper_fit_release(out);
    return s;
}

void sheen_paper_fit_release(sheen_paper_fit *f)
{
    for (size_t i = 0; i < f->n_views; i++) {
        if (f->gbuffers)
            sheen_gbuffer_release(&f->gbuffers[i]);
        if (f->residuals)
            sheen_residual_release(&f->residuals[i]);
        if (f->views)
            sheen_texel_view_release(&f->views[i]);
        if (f->partials)
            sheen_partial_hemisphere_release(&f->partials[i]);
    }
    free(f->gbuffers);
    free(f->residuals);
    free(f->partials);
    free(f->views);
    free(f->nodes);
    free(f->texel_deviation);
    sheen_geodesic_release(&f->geodesic);
    sheen_hemisphere_release(&f->combined);
    sheen_refine_result_release(&f->refined);
    sheen_align_result_release(&f->align);
    sheen_model_release(&f->model);
    *f = (sheen_paper_fit){0};
}
