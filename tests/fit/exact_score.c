// SPDX-License-Identifier: Apache-2.0
// exact_score.c - matches lights, and compares layers on the held-out views.
#include "tests/fit/exact_score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fit/metrics.h"
#include "render/draw.h"
#include "tests/support.h"

static const double pi = 3.14159265358979323846;

// A model's light, whatever it is in the model: strength is the peak of its highlight for a camera that faces it.
typedef struct found_light {
    double v_world[3], per_m, rgb[3]; // per_m: 1 / distance
} found_light;

static found_light light_of(const sheen_model *m, size_t i)
{
    if (i >= m->lights.count) {
        // Lamps are stated from an origin of their own: here from the middle of the object
        const sheen_lamp *l = &m->lamps[i - m->lights.count];
        const double per_m = (double)l->inverse_distance_per_m;
        found_light f = {.rgb = {(double)l->rgb[0], (double)l->rgb[1], (double)l->rgb[2]}};
        for (int k = 0; k < 3; k++)
            f.v_world[k] = (double)l->direction_world[k] + per_m * m->lamp_origin_world[k];
        const double length = sheen_normalize(f.v_world);
        f.per_m = per_m / length;
        for (int k = 0; k < 3; k++)
            f.rgb[k] /= length * length;
        return f;
    }
    const double strength = m->k_s * (double)m->lights.weight[i];
    return (found_light){
        .v_world = {(double)m->lights.dx[i], (double)m->lights.dy[i], (double)m->lights.dz[i]},
        .rgb = {strength * m->light_rgb[0], strength * m->light_rgb[1], strength * m->light_rgb[2]}};
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

static void chromaticity(double xy[2], const double rgb[3])
{
    const double X = 0.4124 * rgb[0] + 0.3576 * rgb[1] + 0.1805 * rgb[2], Y = luminance(rgb),
                 Z = 0.0193 * rgb[0] + 0.1192 * rgb[1] + 0.9505 * rgb[2];
    xy[0] = X / (X + Y + Z);
    xy[1] = Y / (X + Y + Z);
}

static int nearest_true(const exact_scene *s, const double v_world[3])
{
    int best = 0;
    for (int i = 1; i < EXACT_LIGHTS; i++)
        if (sheen_dot(s->lights[i].v_world, v_world) > sheen_dot(s->lights[best].v_world, v_world))
            best = i;
    return best;
}

// All the model's lights about true light i as one: their sum, and their mean place.
static found_light gather(const exact_scene *s, const sheen_model *m, int i)
{
    const exact_light *t = &s->lights[i];
    const double cone_rad = fmin(12 * pi / 180, fmax(3 * pi / 180, t->radius_rad + 2 * s->o.sigma_rad));
    found_light sum = {.per_m = 0};
    for (size_t k = 0; k < m->lights.count + m->n_lamps; k++) {
        const found_light f = light_of(m, k);
        if (nearest_true(s, f.v_world) != i || sheen_dot(f.v_world, t->v_world) < cos(cone_rad))
            continue;
        const double Y = luminance(f.rgb);
        sum.per_m += Y * f.per_m;
        for (int c = 0; c < 3; c++) {
            sum.v_world[c] += Y * f.v_world[c];
            sum.rgb[c] += f.rgb[c];
        }
    }
    sum.per_m /= luminance(sum.rgb);
    sheen_normalize(sum.v_world);
    return sum;
}

static void score_lights(exact_score *out, const exact_scene *s, const sheen_model *m)
{
    out->distance_error = s->o.is_near ? 0 : (double)NAN;
    for (int i = 0; i < EXACT_LIGHTS; i++) {
        const exact_light *t = &s->lights[i];
        const found_light f = gather(s, m, i);
        double across[3], got_xy[2], want_xy[2];
        sheen_cross(across, f.v_world, t->v_world);
        const double angle_deg = atan2(sheen_norm(across), sheen_dot(f.v_world, t->v_world)) * 180 / pi;
        const double ratio = luminance(f.rgb) / luminance(t->rgb);
        if (!(ratio > 0.5 && ratio < 2 && angle_deg < 2))
            continue;
        chromaticity(got_xy, f.rgb);
        chromaticity(want_xy, t->rgb);
        out->n_found++;
        out->direction_deg = fmax(out->direction_deg, angle_deg);
        out->strength_error = fmax(out->strength_error, fabs(ratio - 1));
        out->colour_error = fmax(out->colour_error, hypot(got_xy[0] - want_xy[0], got_xy[1] - want_xy[1]));
        if (s->o.is_near)
            out->distance_error = fmax(out->distance_error, fabs(1 / (t->distance_m * f.per_m) - 1));
    }
}

static void sum_of(sheen_image *out, const sheen_image *a, const sheen_image *b)
{
    sheen_err err;
    assert_ok(sheen_image_init(out, a->width_px, a->height_px, 3, &err), err);
    const size_t n = 3 * (size_t)a->width_px * (size_t)a->height_px;
    for (size_t i = 0; i < n; i++)
        out->data[i] = a->data[i] + (b ? b->data[i] : 0);
}

// sRGB decibels of a + b against the view's clean photograph.
static double composite_db(const exact_scene *s, size_t view, const sheen_image *a, const sheen_image *b,
                           const uint8_t *select)
{
    sheen_image sum;
    sum_of(&sum, a, b);
    const double db = sheen_psnr_of(&sum, &s->tests.photos[view].image, select).srgb_db;
    sheen_image_release(&sum);
    return db;
}

static void score_view(exact_score *out, const exact_scene *s, const sheen_drawing *drawing, size_t view)
{
    const sheen_camera *cam = &s->tests.cam;
    const size_t n = (size_t)cam->width_px * (size_t)cam->height_px;
    const double share = 1 / (double)s->tests.count;
    sheen_layers l;
    sheen_image black;
    sheen_err err;
    const double *rt_cam_obj = s->tests.photos[view].rt_cam_obj;
    assert_ok(sheen_draw(&l, drawing, cam, rt_cam_obj, s->tests.photos[view].rt_world_obj, NULL, &err), err);
    assert_ok(sheen_image_init(&black, cam->width_px, cam->height_px, 3, &err), err);
    uint8_t *select = calloc(n, 1);
    assert_non_null(select);
    for (size_t i = 0; i < n; i++)
        select[i] = l.coverage.data[i] > 0.999f && !(l.holes.data[i] > 0);
    const sheen_image *S = &s->specular[view], *D = &s->diffuse[view];
    out->specular_db += share * sheen_psnr_of(&l.specular, S, select).linear_db;
    out->no_specular_db += share * sheen_psnr_of(&black, S, select).linear_db;
    out->composite_db += share * composite_db(s, view, &l.diffuse, &l.specular, select);
    out->true_specular_db += share * composite_db(s, view, &l.diffuse, S, select);
    out->true_diffuse_db += share * composite_db(s, view, D, &l.specular, select);
    free(select);
    sheen_image_release(&black);
    sheen_layers_release(&l);
}

void exact_score_model(exact_score *out, const exact_scene *s, const sheen_model *model)
{
    sheen_model m = *model;
    sheen_drawing *drawing;
    sheen_err err;
    *out = (exact_score){0};
    m.mesh = s->mesh; // lent
    out->sigma_error = s->o.ggx_alpha > 0 ? (double)NAN : m.sigma_rad / s->o.sigma_rad - 1;
    score_lights(out, s, &m);
    assert_ok(sheen_drawing_new(&drawing, &m, &err), err);
    for (size_t i = 0; i < s->tests.count; i++)
        score_view(out, s, drawing, i);
    sheen_drawing_free(&drawing);
}

void exact_score_print_heading(FILE *to)
{
    fprintf(to, "%-22s %-9s %8s %6s %9s %9s %9s %8s %8s %8s %8s %8s\n", "scene", "method", "sigma", "lights",
            "direction", "distance", "strength", "specular", "(none)", "compos.", "true S", "true D");
}

void exact_score_print(FILE *to, const char *scene, const char *method, const exact_score *e)
{
    fprintf(to, "%-22s %-9s %+7.1f%% %4d/%d %8.2f' %8.1f%% %8.1f%% %8.1f %8.1f %8.1f %8.1f %8.1f\n", scene,
            method, 100 * e->sigma_error, e->n_found, EXACT_LIGHTS, 60 * e->direction_deg,
            100 * e->distance_error, 100 * e->strength_error, e->specular_db, e->no_specular_db,
            e->composite_db, e->true_specular_db, e->true_diffuse_db);
    fflush(to);
}
