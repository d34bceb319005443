// SPDX-License-Identifier: Apache-2.0
// gltf_specular.c - alternating least squares a place, on a coarser picture than the colours'.
#include "render/gltf_specular.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/vec.h"
#include "render/draw_private.h"
#include "render/gltf_reflection.h"
#include "render/gltf_surface.h"
#include "render/panorama.h"
#include "render/shade.h"

enum {
    MAX_SIDE_PX = 256,
    N_EVEN = 48,
    MAX_VIEWS = N_EVEN + SHEEN_GLTF_MAX_LIGHTS,
    SPREAD_HEIGHT_PX = 256,
    TURNS = 6
};
static const float least_cosine = 0.1f; // of directions: what is seen more obliquely is a rim
static const float highlight_width =
    4;                            // radius of a highlight, in sigma, over the direction that it is seen from
static const float prior = 1e-4f; // pulls weights that nothing tells to 1

typedef struct fitting {
    const sheen_gltf *g;
    const sheen_model *model;
    sheen_shading shading;
    sheen_gltf_reflection lobe;
    const sheen_gltf_light *lights;
    size_t n_lights;
    sheen_image spread, dark; // the panorama as the lobe sees it, with lights and without
    float most_weight;
    sheen_image weight, self; // [side][side][3]: w (three times), x
    uint8_t *known;
    int side_px, step;
} fitting;

// What is seen of one place, from some directions.
typedef struct views {
    size_t n, n_even; // the even ones first
    float p_obj[3 * MAX_VIEWS], n_obj[3 * MAX_VIEWS], v_obj[3 * MAX_VIEWS];
    float mirror_env[3 * MAX_VIEWS]; // where glTF mirrors from
    float share[MAX_VIEWS], q[MAX_VIEWS], F[MAX_VIEWS];
    float seen[3 * MAX_VIEWS]; // D + S
    float L[3 * MAX_VIEWS];
} views;

// Frame gltf's directions are the panorama's.
static void to_obj(float out[3], const sheen_gltf *g, const double v_gltf[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (float)(g->R_gltf_obj[0][k] * v_gltf[0] + g->R_gltf_obj[1][k] * v_gltf[1] +
                         g->R_gltf_obj[2][k] * v_gltf[2]);
}

static void add_view(views *s, const fitting *f, const float p[3], const float n[3], const float v[3],
                     float share, const float mirror_env[3])
{
    float from[3], v_env[3];
    sheen_gltf_to_env(v_env, f->g, v);
    if (!(sheen_dotf(n, v) >= least_cosine) || (f->model->surroundings.present && v_env[1] < 0))
        return; // nobody looks from below the table
    for (int k = 0; k < 3; k++)
        from[k] = p[k] + f->shading.offset_m * n[k];
    if (sheen_scene_blocked(f->shading.scene, from, v))
        return;
    memcpy(s->p_obj + 3 * s->n, p, 3 * sizeof *p);
    memcpy(s->n_obj + 3 * s->n, n, 3 * sizeof *n);
    memcpy(s->v_obj + 3 * s->n, v, 3 * sizeof *v);
    memcpy(s->mirror_env + 3 * s->n, mirror_env, 3 * sizeof *mirror_env);
    s->share[s->n++] = share;
}

// Directions that stand for equal parts of what is seen of the place all around: by the cosine, on a sunflower's spiral.
static void add_even(views *s, const fitting *f, const float p[3], const float n[3])
{
    float a[3], b[3];
    sheen_axes_aboutf(a, b, n);
    for (int i = 0; i < N_EVEN; i++) {
        const float sine2 = ((float)i + 0.5f) / N_EVEN, sine = sqrtf(sine2), cosine = sqrtf(1 - sine2),
                    azimuth = 2.39996323f * (float)i;
        float v[3], r[3], r_env[3];
        for (int k = 0; k < 3; k++)
            v[k] = sine * (cosf(azimuth) * a[k] + sinf(azimuth) * b[k]) + cosine * n[k];
        sheen_mirrorf(r, n, v);
        sheen_gltf_to_env(r_env, f->g, r);
        add_view(s, f, p, n, v, 1.0f / N_EVEN, r_env);
    }
}

// A highlight is seen over pi (highlight_width sigma + the light's radius)^2 of the directions, of pi in all by the cosine.
static void add_highlights(views *s, const fitting *f, const float p[3], const float n[3])
{
    const sheen_gltf *g = f->g;
    for (size_t i = 0; i < f->n_lights; i++) {
        const sheen_gltf_light *light = &f->lights[i];
        const float radius = highlight_width * (float)f->model->sigma_rad + (float)light->radius_rad;
        double to[3];
        float l[3], v[3], l_env[3];
        for (int k = 0; k < 3; k++) {
            to[k] = light->direction[k];
            l_env[k] = (float)to[k];
            if (light->near)
                to[k] = light->position[k] -
                        sheen_dot(g->R_gltf_obj[k], (double[3]){(double)p[0], (double)p[1], (double)p[2]}) -
                        g->t_gltf_obj[k];
        }
        to_obj(l, g, to);
        sheen_normalizef(l);
        sheen_mirrorf(v, n, l);
        add_view(s, f, p, n, v, radius * radius, l_env);
    }
}

// What is brighter than white looks like white, in either.
static void hold_to_white(float rgb[3], float factor)
{
    const float y = factor * (rgb[0] + rgb[1] + rgb[2]) / 3;
    for (int c = 0; c < 3 && y > 1; c++)
        rgb[c] /= y;
}

// The model's mirrored light: without its lights from the even directions.
static void mirror(views *s, const fitting *f, float gloss_here)
{
    const size_t lit = s->n_even;
    float gloss[MAX_VIEWS];
    for (size_t i = 0; i < s->n; i++)
        gloss[i] = gloss_here;
    sheen_shade_mirrored(s->seen, &f->shading, s->p_obj, s->n_obj, s->v_obj, lit);
    for (size_t i = 0; i < lit; i++) {
        const float cosine = sheen_dotf(s->n_obj + 3 * i, s->v_obj + 3 * i);
        for (size_t c = 0; c < 3; c++)
            s->seen[3 * i + c] *= gloss_here * sheen_fresnel(f->model->surroundings.f0, cosine);
    }
    sheen_shade(s->seen + 3 * lit, &f->shading, gloss, s->p_obj + 3 * lit, s->n_obj + 3 * lit,
                s->v_obj + 3 * lit, s->n - lit);
}

static void look(views *s, const fitting *f, const float D[3])
{
    const float f90 = (float)f->g->specular_factor,
                f0 = f90 * (float)(SHEEN_DIELECTRIC_F0 * f->g->specular_colour);
    mirror(s, f, f->model->gloss.n ? sheen_gloss_at(&f->model->gloss, D) : 1);
    for (size_t i = 0; i < s->n; i++) {
        const float cosine = sheen_dotf(s->n_obj + 3 * i, s->v_obj + 3 * i);
        float y = 0;
        s->F[i] = sheen_gltf_reflectance(&f->lobe, cosine, f0, f90);
        sheen_panorama_at(s->L + 3 * i, i < s->n_even ? &f->dark : &f->spread, s->mirror_env + 3 * i);
        hold_to_white(s->seen + 3 * i, 1);
        hold_to_white(s->L + 3 * i, s->F[i]);
        for (size_t c = 0; c < 3; c++) {
            s->seen[3 * i + c] += D[c];
            y += fminf(1, s->seen[3 * i + c]) / 3;
        }
        s->q[i] = s->share[i] * powf(y + 0.02f, -1.2f); // sRGB's slope is about light^-0.6
    }
}

// x for a given w, then w for this x.
static float turn(float x[3], float w, float most_weight, const views *s)
{
    float product = prior, square = prior;
    for (size_t c = 0; c < 3; c++) {
        float sum = 0, all = 0;
        for (size_t i = 0; i < s->n; i++) {
            const float own = 1 - w * s->F[i];
            sum += s->q[i] * own * (s->seen[3 * i + c] - w * s->F[i] * s->L[3 * i + c]);
            all += s->q[i] * own * own;
        }
        x[c] = fmaxf(0, sum / all);
        for (size_t i = 0; i < s->n; i++) {
            const float mirrored = s->F[i] * (s->L[3 * i + c] - x[c]);
            product += s->q[i] * mirrored * (s->seen[3 * i + c] - x[c]);
            square += s->q[i] * mirrored * mirrored;
        }
    }
    return fmaxf(0, fminf(most_weight, product / square));
}

static void fit_place(fitting *f, int x_px, int y_px)
{
    const sheen_surface_picture *p = &f->g->surface;
    const int x = x_px * f->step + f->step / 2, y = y_px * f->step + f->step / 2;
    const size_t place = (size_t)y * (size_t)p->charts.side_px + (size_t)x;
    const float *D = sheen_image_at(&p->rgb, x, y);
    float p_obj[3], n_obj[3], *self = sheen_image_at(&f->self, x_px, y_px), w = 1;
    views s = {.n = 0};
    if (p->places[place].triangle == SHEEN_CHART_EMPTY || !p->known[place])
        return;
    sheen_gltf_surface_at(p_obj, n_obj, f->g, &p->places[place]);
    add_even(&s, f, p_obj, n_obj);
    s.n_even = s.n;
    add_highlights(&s, f, p_obj, n_obj);
    if (!s.n)
        return;
    look(&s, f, D);
    for (int i = 0; i < TURNS; i++)
        w = turn(self, w, f->most_weight, &s);
    for (int c = 0; c < 3; c++) {
        sheen_image_at(&f->weight, x_px, y_px)[c] = w;
        self[c] -= D[c]; // changes smoothly where D does not
    }
    f->known[(size_t)y_px * (size_t)f->side_px + (size_t)x_px] = 1;
}

static void fit_rows(void *self, size_t begin, size_t end)
{
    fitting *f = self;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < f->side_px; x++)
            fit_place(f, x, (int)y);
}

static void change_light(sheen_gltf *g, const sheen_image *change)
{
    sheen_surface_picture *p = &g->surface;
    const size_t n = (size_t)p->charts.side_px * (size_t)p->charts.side_px;
    for (size_t i = 0; i < n; i++) {
        float by[3];
        if (!p->known[i])
            continue;
        sheen_gltf_picture_at(by, g, change, &p->places[i]);
        for (size_t c = 0; c < 3; c++)
            p->rgb.data[3 * i + c] = (float)(1 - g->f0) * fmaxf(0, p->rgb.data[3 * i + c] + by[c]);
    }
}

static sheen_status prepare(fitting *f, const sheen_drawing *d, const double rt_world_obj[6],
                            const sheen_image *dark, int n_threads, sheen_err *err)
{
    const sheen_gltf *g = f->g;
    f->step = g->surface.charts.side_px > MAX_SIDE_PX ? g->surface.charts.side_px / MAX_SIDE_PX : 1;
    f->side_px = g->surface.charts.side_px / f->step;
    sheen_shading_init(&f->shading, f->model, d->scene, d->cells, &d->lamps, rt_world_obj);
    sheen_gltf_reflection_init(&f->lobe, g->roughness);
    sheen_status s = sheen_gltf_spread(&f->spread, &f->lobe, &g->panorama, SPREAD_HEIGHT_PX, n_threads, err);
    if (!s)
        s = sheen_gltf_spread(&f->dark, &f->lobe, dark, SPREAD_HEIGHT_PX, n_threads, err);
    if (!s)
        s = sheen_image_init(&f->weight, f->side_px, f->side_px, 3, err);
    if (!s)
        s = sheen_image_init(&f->self, f->side_px, f->side_px, 3, err);
    const size_t n = (size_t)f->side_px * (size_t)f->side_px;
    if (!s && !(f->known = calloc(n, 1)))
        s = sheen_fail_memory(err, (double)n, "a picture of weights");
    return s;
}

sheen_status sheen_gltf_fit_specular(sheen_gltf *g, const sheen_model *model, const double rt_world_obj[6],
                                     const sheen_image *dark, const sheen_gltf_light *lights, size_t n_lights,
                                     int n_threads, sheen_err *err)
{
    fitting f = {.g = g,
                 .model = model,
                 .lights = lights,
                 .n_lights = n_lights,
                 .most_weight = g->specular_factor < 1 ? 1 : SHEEN_GLTF_MOST_WEIGHT};
    sheen_drawing *d = NULL;
    sheen_status s = sheen_drawing_new(&d, model, err);
    if (!s)
        s = prepare(&f, d, rt_world_obj, dark, n_threads, err);
    if (!s) {
        sheen_parallel_for((size_t)f.side_px, 4, n_threads, fit_rows, &f);
        s = sheen_image_fill(&f.weight, f.known, err);
    }
    if (!s)
        s = sheen_image_fill(&f.self, f.known, err);
    if (!s) {
        change_light(g, &f.self);
        g->specular = f.weight;
        f.weight = (sheen_image){.data = NULL};
        const size_t n = 3 * (size_t)f.side_px * (size_t)f.side_px;
        for (size_t i = 0; i < n; i++)
            g->specular.data[i] = fmaxf(0, fminf(f.most_weight, g->specular.data[i]));
    }
    sheen_image_release(&f.spread);
    sheen_image_release(&f.dark);
    sheen_image_release(&f.weight);
    sheen_image_release(&f.self);
    free(f.known);
    sheen_drawing_free(&d);
    return s;
}
