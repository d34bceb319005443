// SPDX-License-Identifier: Apache-2.0
// surface_picture.c - samples the global texture at the places that a picture's pixels show.
//
// On a mesh that was simplified, each place looks for the original surface along its normal, from outside.
#include "render/surface_picture.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "render/simplify.h"

void sheen_surface_picture_release(sheen_surface_picture *p)
{
    sheen_mesh_release(&p->mesh);
    sheen_charts_release(&p->charts);
    sheen_image_release(&p->rgb);
    sheen_image_release(&p->n_obj);
    free(p->places);
    free(p->known);
    *p = (sheen_surface_picture){.places = NULL};
}

static double area_m2(const sheen_mesh *mesh)
{
    double sum = 0;
    for (size_t i = 0; i < mesh->n_triangles; i++) {
        const uint32_t *corner = mesh->triangles + 3 * i;
        const float *p = mesh->p_obj + 3 * (size_t)corner[0];
        float a[3], b[3], n[3];
        sheen_subf(a, mesh->p_obj + 3 * (size_t)corner[1], p);
        sheen_subf(b, mesh->p_obj + 3 * (size_t)corner[2], p);
        sheen_crossf(n, a, b);
        sum += 0.5 * (double)sqrtf(sheen_dotf(n, n));
    }
    return sum;
}

static void surface_at(float p_obj[3], float n_obj[3], const sheen_mesh *mesh, const sheen_chart_place *at)
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)at->triangle;
    const float b[3] = {1 - at->b1 - at->b2, at->b1, at->b2};
    for (size_t k = 0; k < 3; k++) {
        p_obj[k] = n_obj[k] = 0;
        for (size_t c = 0; c < 3; c++) {
            p_obj[k] += b[c] * mesh->p_obj[3 * (size_t)corner[c] + k];
            n_obj[k] += b[c] * mesh->n_obj[3 * (size_t)corner[c] + k];
        }
    }
    sheen_normalizef(n_obj);
}

// Where the original surface lies at a place of the simpler one.
static sheen_hit original_at(const sheen_mesh *mesh, const sheen_scene *scene, const sheen_chart_place *at,
                             float reach_m)
{
    float p[3], n[3], from[3], inwards[3];
    sheen_hit hit;
    surface_at(p, n, mesh, at);
    for (int k = 0; k < 3; k++) {
        from[k] = p[k] + reach_m * n[k];
        inwards[k] = -n[k];
    }
    sheen_scene_first_hits(scene, &hit, from, 1, inwards, 1);
    if (hit.triangle != SHEEN_NO_HIT && hit.t_m > 2 * reach_m)
        hit.triangle = SHEEN_NO_HIT;
    return hit;
}

static sheen_status sample(sheen_surface_picture *p, const sheen_model *model, sheen_err *err)
{
    static const double nowhere[3] = {0, 0, 0};
    sheen_scene *scene = NULL;
    float centre[3], radius_m, p_obj[3], v_obj[3];
    sheen_mesh_sphere(&model->mesh, centre, &radius_m);
    const float reach_m = fmaxf(4 * (float)p->moved_m, 5e-3f * radius_m);
    const int simpler = p->mesh.n_triangles != model->mesh.n_triangles;
    if (simpler) {
        const sheen_status s = sheen_scene_new(&scene, &model->mesh, err);
        if (s)
            return s;
    }
    const size_t n = (size_t)p->charts.side_px * (size_t)p->charts.side_px;
    for (size_t i = 0; i < n; i++) {
        const sheen_chart_place *at = &p->places[i];
        if (at->triangle == SHEEN_CHART_EMPTY)
            continue;
        const sheen_hit hit = simpler ? original_at(&p->mesh, scene, at, reach_m)
                                      : (sheen_hit){.triangle = at->triangle, .b1 = at->b1, .b2 = at->b2};
        if (p->n_obj.data && hit.triangle != SHEEN_NO_HIT)
            sheen_normal_map_surface(&model->mesh, &model->normals, &hit, nowhere, p_obj,
                                     p->n_obj.data + 3 * i, v_obj);
        p->known[i] = hit.triangle != SHEEN_NO_HIT &&
                      sheen_texture_sample(&model->texture, &hit, p->rgb.data + 3 * i) > 0.5f;
    }
    sheen_scene_free(&scene);
    return SHEEN_OK;
}

sheen_status sheen_surface_picture_make(sheen_surface_picture *out, const sheen_model *model,
                                        size_t max_triangles, int max_side_px, sheen_err *err)
{
    *out = (sheen_surface_picture){.places = NULL};
    const double n_texels = (double)model->texture.n_triangles * pow(model->texture.texels_per_edge - 1, 2) /
                            2; // each counts half a lattice cell
    const double texel_m = sqrt(area_m2(&model->mesh) / n_texels);
    sheen_status s = sheen_mesh_simplify(&out->mesh, &model->mesh, max_triangles, &out->moved_m, err);
    if (!s)
        s = sheen_charts_make(&out->charts, &out->mesh, texel_m, max_side_px, err);
    if (!s)
        s = sheen_image_init(&out->rgb, out->charts.side_px, out->charts.side_px, 3, err);
    if (!s && model->normals.n_triangles)
        s = sheen_image_init(&out->n_obj, out->charts.side_px, out->charts.side_px, 3, err);
    if (!s) {
        const size_t n = (size_t)out->charts.side_px * (size_t)out->charts.side_px;
        out->places = malloc(n * sizeof *out->places);
        out->known = calloc(n, 1);
        if (!out->places || !out->known)
            s = sheen_fail_memory(err, 13.0 * (double)n, "a texture");
    }
    if (!s) {
        sheen_charts_places(out->places, &out->charts);
        s = sample(out, model, err);
    }
    if (s)
        sheen_surface_picture_release(out);
    return s;
}
