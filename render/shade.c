// SPDX-License-Identifier: Apache-2.0
// shade.c - eq. (7) with cast shadows, and one mirrored ray.
//
// Most points are lit by nothing: the plain sum over the lights in reach is taken first, and only where it matters is
// each of them asked whether the mesh hides it.
#include "render/shade.h"

#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "render/gbuffer.h"

// Points, or lamps, that are worked on together.
enum { AT_A_TIME = 64 };

// Terms below this light are not worth a shadow ray.
static const float negligible_lin = 2e-4f;

// The board's picture is in the board's frame, in which the object stands as it does in the first photograph.
static void place_board(sheen_shading *s, const double rt_world_obj[6])
{
    double rt_obj_world[6], rt_board_world[6] = {0};
    sheen_Rt Rt;
    if (s->model->moving == SHEEN_MOVING_OBJECT) {
        sheen_rt_invert(rt_obj_world, rt_world_obj);
        sheen_rt_compose(rt_board_world, s->model->rt_world_obj, rt_obj_world);
    }
    sheen_Rt_from_rt(&Rt, rt_board_world);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            s->R_board_world[i][k] = (float)Rt.R[i][k];
        s->t_board_world[i] = (float)Rt.t[i];
    }
}

void sheen_shading_init(sheen_shading *s, const sheen_model *model, const sheen_scene *scene,
                        const sheen_light_cells *cells, const sheen_lamp_points *lamps,
                        const double rt_world_obj[6])
{
    sheen_Rt Rt;
    float centre[3], radius_m;
    sheen_Rt_from_rt(&Rt, rt_world_obj);
    *s = (sheen_shading){.model = model, .scene = scene, .cells = cells, .lamps = lamps};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            s->R_world_obj[i][k] = (float)Rt.R[i][k];
        s->t_world_obj[i] = (float)Rt.t[i];
    }
    sheen_mesh_sphere(&model->mesh, centre, &radius_m);
    place_board(s, rt_world_obj);
    s->offset_m = 2e-3f * radius_m;
}

static void to_world(float out[3], const sheen_shading *s, const float v_obj[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = sheen_dotf(s->R_world_obj[i], v_obj);
}

static void to_obj(float out[3], const sheen_shading *s, const float v_world[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = s->R_world_obj[0][i] * v_world[0] + s->R_world_obj[1][i] * v_world[1] +
                 s->R_world_obj[2][i] * v_world[2];
}

// Does the mesh meet a ray that starts a little off the surface?
static bool blocked(const sheen_shading *s, const float p_obj[3], const float n_obj[3], const float v_obj[3])
{
    float from[3];
    for (int i = 0; i < 3; i++)
        from[i] = p_obj[i] + s->offset_m * n_obj[i];
    return sheen_scene_blocked(s->scene, from, v_obj);
}

int sheen_shade_hidden(const sheen_shading *s, const float p_obj[3], const float n_world[3],
                       const float l_world[3])
{
    float n_obj[3], l_obj[3];
    to_obj(n_obj, s, n_world);
    to_obj(l_obj, s, l_world);
    return blocked(s, p_obj, n_obj, l_obj);
}

// The sum over the lights in reach that the mesh does not hide.
static float shadowed_sum(const sheen_shading *s, const float p_obj[3], const float n_obj[3],
                          const float n[3], const float v[3])
{
    sheen_lights near;
    sheen_light_cells_near(&near, s->cells, n, v);
    const float k_s = (float)s->model->k_s, sigma = (float)s->model->sigma_rad;
    const float factor = -0.5f / (sigma * sigma);
    float sum = 0;
    for (size_t i = 0; i < near.count; i++) {
        const float l[3] = {near.dx[i], near.dy[i], near.dz[i]};
        const float a2 = sheen_lobe_alpha2(n, v, l);
        if (!(a2 < 25 * sigma * sigma))
            continue;
        const float term = near.weight[i] * expf(a2 * factor);
        if (!(term * k_s > negligible_lin))
            continue;
        float l_obj[3];
        to_obj(l_obj, s, l);
        if (!blocked(s, p_obj, n_obj, l_obj))
            sum += term;
    }
    return sum * sheen_lobe_inverse_cos(n, v);
}

// A point, in world, from the lamps' origin.
static void from_lamp_origin(float x_m[3], const sheen_shading *s, const float p_obj[3])
{
    to_world(x_m, s, p_obj);
    for (int i = 0; i < 3; i++)
        x_m[i] += s->t_world_obj[i] - (float)s->model->lamp_origin_world[i];
}

// Adds the lamps' light, some at a time.
static void add_lamps(float rgb[3], const sheen_shading *s, const float p_obj[3], const float n_obj[3],
                      const float n[3], const float v[3])
{
    const sheen_model *m = s->model;
    const sheen_lobe_shape lobe = sheen_model_lobe(m);
    float x[3], response[AT_A_TIME];
    from_lamp_origin(x, s, p_obj);
    for (size_t begin = 0; begin < m->n_lamps; begin += AT_A_TIME) {
        const size_t n_now = m->n_lamps - begin < AT_A_TIME ? m->n_lamps - begin : AT_A_TIME;
        sheen_lamp_responses(response, s->lamps, begin, n_now, &lobe, x, n, v);
        for (size_t i = 0; i < n_now; i++) {
            const sheen_lamp *lamp = &m->lamps[begin + i];
            float to_lamp[3], l_obj[3];
            if (!(response[i] * (lamp->rgb[0] + lamp->rgb[1] + lamp->rgb[2]) > negligible_lin))
                continue;
            for (int k = 0; k < 3; k++)
                to_lamp[k] = lamp->direction_world[k] - lamp->inverse_distance_per_m * x[k];
            sheen_normalizef(to_lamp);
            to_obj(l_obj, s, to_lamp);
            if (m->shadows && blocked(s, p_obj, n_obj, l_obj))
                continue;
            for (int c = 0; c < 3; c++)
                rgb[c] += response[i] * lamp->rgb[c];
        }
    }
}

void sheen_shade_lights(float rgb[3], const sheen_shading *s, const float p_obj[3], const float n_obj[3],
                        const float v_obj[3])
{
    float n[3], v[3];
    to_world(n, s, n_obj);
    to_world(v, s, v_obj);
    const float k_s = (float)s->model->k_s;
    float sum = s->model->lights.count ? sheen_light_cells_sum(s->cells, n, v) : 0;
    if (s->model->shadows && sum * k_s > negligible_lin)
        sum = shadowed_sum(s, p_obj, n_obj, n, v);
    for (int c = 0; c < 3; c++)
        rgb[c] = sum * k_s * (float)s->model->light_rgb[c];
    add_lamps(rgb, s, p_obj, n_obj, n, v);
}

// Mean of n vectors and how far from it the farthest lies.
static float middle_of(float mean[3], const float *x, size_t n)
{
    float most2 = 0, sum[3] = {0, 0, 0};
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            sum[c] += x[3 * i + c];
    for (int c = 0; c < 3; c++)
        mean[c] = sum[c] / (float)n;
    for (size_t i = 0; i < n; i++) {
        float d[3];
        sheen_subf(d, x + 3 * i, mean);
        const float d2 = sheen_dotf(d, d);
        most2 = d2 > most2 ? d2 : most2;
    }
    return sqrtf(most2);
}

bool sheen_shade_may_shine(const sheen_shading *s, const float *p_obj, const float *n_obj, const float *v_obj,
                           size_t n)
{
    const sheen_model *m = s->model;
    const sheen_lobe_shape lobe = sheen_model_lobe(m);
    float p[3], normal[3], v[3];
    sheen_lamp_patch patch;
    if (m->lights.count)
        return true;
    if (!n || !m->n_lamps)
        return false;
    patch.x_reach_m = middle_of(p, p_obj, n);
    patch.n_reach = middle_of(normal, n_obj, n);
    patch.v_reach = middle_of(v, v_obj, n);
    from_lamp_origin(patch.x_m, s, p);
    to_world(patch.n_world, s, normal);
    to_world(patch.v_world, s, v);
    for (size_t i = 0; i < m->n_lamps; i++) {
        const sheen_lamp *lamp = &m->lamps[i];
        const float light = lamp->rgb[0] + lamp->rgb[1] + lamp->rgb[2];
        if (sheen_lamp_response_bound(lamp, &lobe, &patch) * light > negligible_lin)
            return true;
    }
    return false;
}

void sheen_shade_irradiance(float rgb[3], const sheen_shading *s, const float p_obj[3], const float n_obj[3])
{
    const sheen_irradiance *e = &s->model->irradiance;
    float n[3], x[3], l[3], l_obj[3];
    rgb[0] = rgb[1] = rgb[2] = 1;
    if (!e->present)
        return;
    to_world(n, s, n_obj);
    sheen_irradiance_ambient(rgb, e, n);
    if (e->n_lamps)
        from_lamp_origin(x, s, p_obj);
    for (int j = 0; j < e->n_lamps; j++) {
        const sheen_irradiance_lamp *lamp = &e->lamps[j];
        const float cosine = sheen_irradiance_lamp_cosine(l, lamp, x, n);
        if (!(cosine > 0))
            continue;
        to_obj(l_obj, s, l);
        if (!blocked(s, p_obj, n_obj, l_obj))
            for (int c = 0; c < 3; c++)
                rgb[c] += cosine * (float)lamp->rgb[c];
    }
}

// The object mirrored in itself, under its light.
static void light_mirrored(float rgb[3], const sheen_shading *s, const sheen_hit *hit,
                           const float from_obj[3])
{
    const double from[3] = {(double)from_obj[0], (double)from_obj[1], (double)from_obj[2]};
    float p_obj[3], n_obj[3], v_obj[3], e[3];
    if (!s->model->irradiance.present)
        return;
    sheen_normal_map_surface(&s->model->mesh, &s->model->normals, hit, from, p_obj, n_obj, v_obj);
    sheen_shade_irradiance(e, s, p_obj, n_obj);
    for (int c = 0; c < 3; c++)
        rgb[c] *= e[c];
}

static void to_board(float out[3], const sheen_shading *s, const float x_world[3], const float t[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = sheen_dotf(s->R_board_world[i], x_world) + t[i];
}

// What a mirror ray from p_obj in direction r_obj brings, given its first hit.
static void split_hit(float rgb[3], float above_world[3], const sheen_shading *s, const float p_obj[3],
                      const float r_obj[3], const sheen_hit *hit)
{
    static const float zero[3] = {0, 0, 0};
    float r_world[3], p_world[3], p_board[3], r_board[3];
    rgb[0] = rgb[1] = rgb[2] = above_world[0] = above_world[1] = above_world[2] = 0;
    if (hit->triangle != SHEEN_NO_HIT) {
        sheen_texture_sample(&s->model->texture, hit, rgb);
        light_mirrored(rgb, s, hit, p_obj);
        return;
    }
    to_world(r_world, s, r_obj);
    if (r_world[2] >= 0) {
        for (int i = 0; i < 3; i++)
            above_world[i] = r_world[i];
        return;
    }
    to_world(p_world, s, p_obj);
    for (int i = 0; i < 3; i++)
        p_world[i] += s->t_world_obj[i];
    if (s->model->moving == SHEEN_MOVING_OBJECT) {
        to_board(p_board, s, p_world, s->t_board_world);
        to_board(r_board, s, r_world, zero);
    }
    const bool turned = s->model->moving == SHEEN_MOVING_OBJECT;
    sheen_surroundings_plane(rgb, &s->model->surroundings, turned ? p_board : p_world,
                             turned ? r_board : r_world, 2 * (float)s->model->sigma_rad);
}

// sheen_shade_split of a few.
static void split_some(float *rgb, float *above_world, const sheen_shading *s, const float *p_obj,
                       const float *n_obj, const float *v_obj, size_t n)
{
    float from[3 * AT_A_TIME], r_obj[3 * AT_A_TIME];
    sheen_hit hits[AT_A_TIME];
    if (!n)
        return;
    for (size_t i = 0; i < n; i++) {
        sheen_mirrorf(r_obj + 3 * i, n_obj + 3 * i, v_obj + 3 * i);
        for (size_t k = 3 * i; k < 3 * i + 3; k++)
            from[k] = p_obj[k] + s->offset_m * n_obj[k];
    }
    sheen_scene_first_hits(s->scene, hits, from, 0, r_obj, n);
    for (size_t i = 0; i < n; i++)
        split_hit(rgb + 3 * i, above_world + 3 * i, s, p_obj + 3 * i, r_obj + 3 * i, &hits[i]);
}

void sheen_shade_split(float *rgb, float *above_world, const sheen_shading *s, const float *p_obj,
                       const float *n_obj, const float *v_obj, size_t n)
{
    for (size_t begin = 0; begin < n; begin += AT_A_TIME) {
        const size_t at = 3 * begin, n_now = n - begin < AT_A_TIME ? n - begin : AT_A_TIME;
        split_some(rgb + at, above_world + at, s, p_obj + at, n_obj + at, v_obj + at, n_now);
    }
}

void sheen_shade_mirrored(float *rgb, const sheen_shading *s, const float *p_obj, const float *n_obj,
                          const float *v_obj, size_t n)
{
    float above_world[3 * AT_A_TIME] = {0};
    memset(rgb, 0, 3 * n * sizeof *rgb);
    for (size_t begin = 0; begin < n && s->model->surroundings.present; begin += AT_A_TIME) {
        const size_t at = 3 * begin, n_now = n - begin < AT_A_TIME ? n - begin : AT_A_TIME;
        split_some(rgb + at, above_world, s, p_obj + at, n_obj + at, v_obj + at, n_now);
        for (size_t i = 0; i < 3 * n_now; i += 3)
            if (above_world[i + 2] > 0)
                sheen_surroundings_radiance(rgb + at + i, &s->model->surroundings, p_obj + at + i,
                                            above_world + i);
    }
}

void sheen_shade(float *rgb, const sheen_shading *s, const float *gloss, const float *p_obj,
                 const float *n_obj, const float *v_obj, size_t n)
{
    sheen_shade_mirrored(rgb, s, p_obj, n_obj, v_obj, n);
    for (size_t i = 0; i < n; i++) {
        const size_t at = 3 * i;
        float lights[3];
        sheen_shade_lights(lights, s, p_obj + at, n_obj + at, v_obj + at);
        const float F = sheen_fresnel(s->model->surroundings.f0, sheen_dotf(n_obj + at, v_obj + at));
        for (size_t c = 0; c < 3; c++)
            rgb[at + c] = gloss[i] * (lights[c] + F * rgb[at + c]);
    }
}
