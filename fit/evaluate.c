// SPDX-License-Identifier: Apache-2.0
// evaluate.c - draws each held-out view by every method and compares it with its photograph.
#include "fit/evaluate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "fit/fill_holes.h"

const char *sheen_evaluation_method_name(int method)
{
    return method ? sheen_baseline_name((sheen_baseline)(method - 1)) : "sheen";
}

typedef struct bench {
    const sheen_model *model;
    const sheen_photos *tests;
    const sheen_image *highlights;
    const sheen_evaluate_options *o;
    sheen_drawing *drawing; // the model's
    int filled;             // the model has colours where no photograph saw the surface
    sheen_texel_views texels;
    sheen_evaluation *out;
} bench;

// Pixels of one view that count, and the picture being scored.
typedef struct view {
    const sheen_photo *photo;
    uint8_t *object, *lit; // [n_px]
    size_t n_px;
} view;

// A model of the same mesh with a baseline's texture and nothing else. It borrows the mesh and owns nothing.
static sheen_model plain_model(const sheen_model *model, const sheen_texture *texture)
{
    sheen_model m = *model;
    m.texture = *texture;
    m.lights.count = 0;
    m.n_lamps = 0;
    m.surroundings.present = 0;
    m.irradiance.present = 0;
    return m;
}

// Whether unseen surface took colours from what lies about it (fill_holes.h); else it is black.
static int is_filled(const sheen_texture *t)
{
    const size_t n = t->n_triangles * sheen_texels_per_triangle(t->texels_per_edge);
    for (size_t i = 0; i < n; i++)
        if (!t->n_views[i] && (t->rgb[3 * i] > 0 || t->rgb[3 * i + 1] > 0 || t->rgb[3 * i + 2] > 0))
            return 1;
    return 0;
}

static sheen_status draw_method(sheen_layers *layers, const bench *b, int method, const sheen_photo *photo,
                                sheen_err *err)
{
    const sheen_draw_options o = {.samples_per_side = 2, .n_threads = b->o->n_threads};
    if (method == 0)
        return sheen_draw(layers, b->drawing, &b->tests->cam, photo->rt_cam_obj, photo->rt_world_obj, &o,
                          err);
    double rt_obj_cam[6]; // its translation is the camera's place
    sheen_rt_invert(rt_obj_cam, photo->rt_cam_obj);
    sheen_texture texture = {0};
    sheen_drawing *drawing = NULL;
    sheen_status s = sheen_baseline_texture(&texture, (sheen_baseline)(method - 1), &b->model->mesh,
                                            &b->texels, rt_obj_cam + 3, b->o->n_threads, err);
    if (!s && b->filled)
        s = sheen_fill_holes(&texture, &b->model->mesh, err);
    const sheen_model plain = plain_model(b->model, &texture);
    if (!s && !(s = sheen_drawing_new(&drawing, &plain, err)))
        s = sheen_draw(layers, drawing, &b->tests->cam, photo->rt_cam_obj, photo->rt_world_obj, &o, err);
    sheen_drawing_free(&drawing);
    sheen_texture_release(&texture);
    return s;
}

// The photograph wherever the object does not cover the whole pixel.
static void keep_background(sheen_image *composite, const view *v)
{
    for (size_t i = 0; i < v->n_px; i++)
        if (!v->object[i])
            memcpy(composite->data + 3 * i, v->photo->image.data + 3 * i, 3 * sizeof(float));
}

static double hole_share(const sheen_layers *layers, const view *v)
{
    double holes = 0, object = 0;
    for (size_t i = 0; i < v->n_px; i++)
        if (v->object[i]) {
            holes += (double)layers->holes.data[i];
            object++;
        }
    return object > 0 ? holes / object : 0;
}

static void select_object(view *v, const sheen_layers *layers)
{
    const sheen_image *mask = &v->photo->mask;
    for (size_t i = 0; i < v->n_px; i++)
        v->object[i] = layers->coverage.data[i] > 0.999f && (!mask->data || mask->data[i] > 0.5f);
}

// Brightest Y of the texture in the 3x3 pixels about (x, y), so that an edge in it that is a pixel off is no highlight.
static float brightest_near(const sheen_image *texture, int x, int y)
{
    float most = 0;
    for (int v = y - 1; v <= y + 1; v++)
        for (int u = x - 1; u <= x + 1; u++)
            if (u >= 0 && v >= 0 && u < texture->width_px && v < texture->height_px)
                most = fmaxf(most, sheen_luminance(sheen_image_at(texture, u, v)));
    return most;
}

static void select_highlights(view *v, const sheen_image *known, const sheen_image *median_texture)
{
    const int width = v->photo->image.width_px;
    for (size_t i = 0; i < v->n_px; i++) {
        const int x = (int)(i % (size_t)width), y = (int)(i / (size_t)width);
        if (known)
            v->lit[i] = v->object[i] && known->data[i] > 0.5f;
        else
            v->lit[i] = v->object[i] && sheen_luminance(v->photo->image.data + 3 * i) >
                                            brightest_near(median_texture, x, y) + 0.15f;
    }
}

// The methods' pictures of one view, each scored on its own.
typedef struct scoring {
    const view *v;
    sheen_layers *layers; // [SHEEN_EVALUATION_METHODS]
    sheen_score *scores;
    sheen_status status[SHEEN_EVALUATION_METHODS];
    sheen_err err[SHEEN_EVALUATION_METHODS];
} scoring;

static sheen_status score(sheen_score *out, const view *v, const sheen_layers *layers, sheen_err *err)
{
    out->object = sheen_psnr_of(&layers->composite, &v->photo->image, v->object);
    out->highlights = sheen_psnr_of(&layers->composite, &v->photo->image, v->lit);
    out->frame = sheen_psnr_of(&layers->composite, &v->photo->image, NULL);
    out->hole_share = hole_share(layers, v);
    return sheen_orb_of(&out->orb, &layers->composite, &v->photo->image, v->object, err);
}

static void score_methods(void *self, size_t begin, size_t end)
{
    scoring *g = self;
    for (size_t m = begin; m < end; m++) {
        keep_background(&g->layers[m].composite, g->v);
        g->status[m] = score(&g->scores[m], g->v, &g->layers[m], &g->err[m]);
    }
}

static sheen_status score_view(const bench *b, size_t i_view, sheen_err *err)
{
    sheen_layers layers[SHEEN_EVALUATION_METHODS] = {0};
    view v = {.photo = &b->tests->photos[i_view]};
    v.n_px = (size_t)v.photo->image.width_px * (size_t)v.photo->image.height_px;
    v.object = calloc(v.n_px, 1);
    v.lit = calloc(v.n_px, 1);
    sheen_status s = SHEEN_OK;
    if (!v.object || !v.lit)
        s = sheen_fail_memory(err, 2.0 * (double)v.n_px, "an evaluation");
    for (int m = 0; m < SHEEN_EVALUATION_METHODS && !s; m++)
        s = draw_method(&layers[m], b, m, v.photo, err);
    if (s)
        goto done;
    const sheen_image *known = b->highlights && b->highlights[i_view].data ? &b->highlights[i_view] : NULL;
    select_object(&v, &layers[0]);
    select_highlights(&v, known, &layers[1 + SHEEN_BASELINE_MEDIAN].composite);
    scoring g = {.v = &v, .layers = layers, .scores = b->out->scores[i_view]};
    sheen_parallel_for(SHEEN_EVALUATION_METHODS, 1, b->o->n_threads, score_methods, &g);
    for (int m = 0; m < SHEEN_EVALUATION_METHODS && !s; m++) {
        if ((s = g.status[m]) && err)
            *err = g.err[m];
        if (!s && b->o->picture)
            b->o->picture(b->o->picture_self, v.photo, m, &layers[m].composite, v.object);
    }
    if (s)
        s = sheen_wrap(err, s, "cannot score view '%s'", v.photo->name);

done:
    for (int m = 0; m < SHEEN_EVALUATION_METHODS; m++)
        sheen_layers_release(&layers[m]);
    free(v.object);
    free(v.lit);
    return s;
}

static sheen_status allocate(sheen_evaluation *out, const sheen_photos *tests, sheen_err *err)
{
    *out = (sheen_evaluation){.n_views = tests->count};
    out->names = calloc(tests->count + 1, sizeof *out->names);
    out->scores = calloc(tests->count + 1, sizeof *out->scores);
    if (!out->names || !out->scores)
        return sheen_fail_memory(err, 4000.0 * (double)tests->count, "an evaluation");
    for (size_t i = 0; i < tests->count; i++)
        memcpy(out->names[i], tests->photos[i].name, sizeof out->names[i]);
    return SHEEN_OK;
}

sheen_status sheen_evaluate(sheen_evaluation *out, const sheen_model *model, const sheen_photos *inputs,
                            const sheen_photos *tests, const sheen_image *highlights,
                            const sheen_evaluate_options *options, sheen_err *err)
{
    bench b = {.model = model,
               .tests = tests,
               .highlights = highlights,
               .o = options,
               .filled = is_filled(&model->texture),
               .out = out};
    sheen_scene *scene = NULL;
    sheen_status s;
    if ((s = allocate(out, tests, err)) || (s = sheen_drawing_new(&b.drawing, model, err)) ||
        (s = sheen_scene_new(&scene, &model->mesh, err)) ||
        (s = sheen_texel_views_make(&b.texels, &model->mesh, scene, inputs, model->texture.texels_per_edge,
                                    options->n_threads, &options->progress, err)))
        goto done;
    out->highlights_known = highlights != NULL;
    for (size_t i = 0; i < tests->count && !s; i++) {
        out->highlights_known = out->highlights_known && highlights[i].data;
        if (!(s = sheen_progress_step(&options->progress, "scoring views", (int)i, (int)tests->count, err)))
            s = score_view(&b, i, err);
    }

done:
    sheen_texel_views_release(&b.texels);
    sheen_scene_free(&scene);
    sheen_drawing_free(&b.drawing);
    if (s)
        sheen_evaluation_release(out);
    return s;
}

void sheen_evaluation_release(sheen_evaluation *e)
{
    free(e->names);
    free(e->scores);
    *e = (sheen_evaluation){0};
}

sheen_status sheen_evaluation_append(sheen_evaluation *into, sheen_evaluation *more, sheen_err *err)
{
    const size_t n = into->n_views + more->n_views;
    void *names = realloc(into->names, (n + 1) * sizeof *into->names);
    if (names)
        into->names = names;
    void *scores = realloc(into->scores, (n + 1) * sizeof *into->scores);
    if (scores)
        into->scores = scores;
    if (!names || !scores)
        return sheen_fail_memory(err, 4000.0 * (double)n, "an evaluation");
    memcpy(into->names + into->n_views, more->names, more->n_views * sizeof *into->names);
    memcpy(into->scores + into->n_views, more->scores, more->n_views * sizeof *into->scores);
    into->highlights_known = more->highlights_known && (into->highlights_known || !into->n_views);
    into->n_views = n;
    sheen_evaluation_release(more);
    return SHEEN_OK;
}

typedef struct mean {
    double sum, n;
} mean;

static void take(mean *m, double x)
{
    if (isfinite(x)) {
        m->sum += x;
        m->n++;
    }
}

static double value(const mean *m)
{
    return m->n > 0 ? m->sum / m->n : (double)NAN;
}

static void take_psnr(mean *linear, mean *srgb, size_t *n_pixels, const sheen_psnr *p)
{
    take(linear, p->linear_db);
    take(srgb, p->srgb_db);
    *n_pixels += p->n_pixels;
}

sheen_score sheen_evaluation_mean(const sheen_evaluation *e, int method)
{
    mean m[10] = {0};
    sheen_score out = {0};
    for (size_t i = 0; i < e->n_views; i++) {
        const sheen_score *s = &e->scores[i][method];
        take_psnr(&m[0], &m[1], &out.object.n_pixels, &s->object);
        take_psnr(&m[2], &m[3], &out.highlights.n_pixels, &s->highlights);
        take_psnr(&m[4], &m[5], &out.frame.n_pixels, &s->frame);
        take(&m[6], s->orb.hdr_db);
        take(&m[7], s->orb.ldr_db);
        take(&m[8], s->orb.ssim);
        take(&m[9], s->hole_share);
    }
    out.object.linear_db = value(&m[0]);
    out.object.srgb_db = value(&m[1]);
    out.highlights.linear_db = value(&m[2]);
    out.highlights.srgb_db = value(&m[3]);
    out.frame.linear_db = value(&m[4]);
    out.frame.srgb_db = value(&m[5]);
    out.orb = (sheen_orb){value(&m[6]), value(&m[7]), value(&m[8])};
    out.hole_share = value(&m[9]);
    return out;
}
