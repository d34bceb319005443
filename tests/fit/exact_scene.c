// SPDX-License-Identifier: Apache-2.0
// exact_scene.c - lays out a scene by its seed, photographs it, and spoils the photographs.
#include "tests/fit/exact_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "render/gbuffer.h"
#include "render/texture.h"
#include "tests/support.h"
#include "tests/support_scene.h"

enum { IRRADIANCE_EDGE = 6 };

static const double pi = 3.14159265358979323846;

const char *const exact_scene_names[] = {
    "far",      "near",    "sphere",     "sigma-.0114", "sigma-.1",  "noise", "discs",    "coloured",
    "ggx",      "k_s-map", "matte",      "metal",       "saturated", "pose",  "pose-1.5", "normals",
    "embossed", "drift",   "everything", "metal-room",  "room",      NULL};

static int is(const char *name, const char *scene)
{
    return !strcmp(name, scene);
}

int exact_scene_options(exact_options *out, const char *name, uint64_t seed)
{
    int known = 0;
    for (int i = 0; exact_scene_names[i]; i++)
        known = known || is(name, exact_scene_names[i]);
    const int all = is(name, "everything");
    *out = (exact_options){.name = name,
                           .seed = seed,
                           .sphere = is(name, "sphere"),
                           .is_near = is(name, "near") || all,
                           .disc_deg = is(name, "discs") ? 3
                                       : all             ? 2
                                                         : 0,
                           .coloured = is(name, "coloured") || all,
                           .k_s_map = is(name, "k_s-map") || all,
                           .matte = is(name, "matte"),
                           .metal = is(name, "metal") || is(name, "metal-room"),
                           .room = is(name, "metal-room") || is(name, "room") ? 0.5 : 0,
                           .sigma_rad = is(name, "sigma-.0114") ? 0.0114
                                        : is(name, "sigma-.1") || is(name, "embossed") || is(name, "metal") ||
                                                is(name, "metal-room")
                                            ? 0.1
                                            : 0.03,
                           .ggx_alpha = is(name, "ggx") || all ? 0.06 : 0,
                           .brightness = is(name, "saturated") ? 2.5 : 1,
                           .noise = is(name, "noise") ? 0.02 : 0.005,
                           .eight_bit = 1,
                           .pose_px = is(name, "pose") || all ? 0.75
                                      : is(name, "pose-1.5")  ? 1.5
                                                              : 0,
                           .relief_deg = is(name, "embossed") ? 6 : 0,
                           .normals_deg = is(name, "normals") ? 1
                                          : all               ? 0.5
                                                              : 0,
                           .drift_ev = is(name, "drift") ? 0.5 : 0,
                           .white_balance = is(name, "drift") ? 0.05 : 0};
    return known;
}

static void lay_out_lights(exact_scene *s, uint64_t *seed)
{
    for (int i = 0; i < EXACT_LIGHTS; i++) {
        exact_light *l = &s->lights[i];
        double nearest = 1;
        do {
            const double el = (25 + 50 * test_random(seed)) * pi / 180, az = 2 * pi * test_random(seed);
            const double v[3] = {cos(el) * cos(az), cos(el) * sin(az), sin(el)};
            memcpy(l->v_world, v, sizeof v);
            nearest = -1;
            for (int k = 0; k < i; k++)
                nearest = fmax(nearest, sheen_dot(v, s->lights[k].v_world));
        } while (nearest > cos(25 * pi / 180));
        const double distance_m = 0.55 + 0.45 * test_random(seed), strength = 0.2 + 0.4 * test_random(seed);
        l->distance_m = s->o.is_near ? distance_m : HUGE_VAL;
        l->radius_rad = s->o.disc_deg * pi / 180;
        double rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = 0.6 + 0.8 * test_random(seed);
        const double Y = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        // A disc's highlight is wider and lower than a point's of the same strength would be
        const double width = s->o.ggx_alpha > 0 ? s->o.ggx_alpha / 1.4 : s->o.sigma_rad;
        const double spread = 1 + 0.125 * l->radius_rad * l->radius_rad / (width * width);
        for (int c = 0; c < 3; c++)
            l->rgb[c] = strength * s->o.brightness * spread * (s->o.coloured ? rgb[c] / Y : 1);
    }
}

// By a seed of its own, so that lights and paint are those of the same layout without a room.
static void furnish(exact_scene *s)
{
    uint64_t seed = 5000 + 31 * s->o.seed;
    const double az = 2 * pi * test_random(&seed);
    s->room_side_world[0] = cos(az);
    s->room_side_world[1] = sin(az);
    s->room_side_world[2] = 0;
    for (int c = 0; c < 3; c++)
        s->room_rgb[c] = s->o.room * (0.8 + 0.4 * test_random(&seed));
}

static void paint(exact_scene *s, uint64_t *seed)
{
    static const double levels[3] = {1, 0.5, 0.2};
    for (int i = 0; i < EXACT_COLOURS; i++) {
        for (int c = 0; c < 3; c++) {
            const double colour = 0.06 + 0.6 * test_random(seed);
            s->albedo[i][c] = s->o.metal ? 0 : colour;
            s->tint[i][c] = s->o.metal && s->o.room > 0 ? 0.3 + colour : 1;
        }
        s->k_s[i] = s->o.matte ? 0 : s->o.k_s_map ? levels[i % 3] : 1;
    }
    for (int i = 0; i < EXACT_CELLS; i++) {
        test_direction(s->cell_obj[i], seed);
        for (int k = 0; k < 3; k++)
            s->cell_obj[i][k] *= 0.09f;
        s->cell_colour[i] = (int)(EXACT_COLOURS * test_random(seed));
    }
}

int exact_colour(const exact_scene *s, const float p_obj[3])
{
    float least = HUGE_VALF;
    int nearest = 0;
    for (int i = 0; i < EXACT_CELLS; i++) {
        float d[3];
        sheen_subf(d, p_obj, s->cell_obj[i]);
        const float d2 = sheen_dotf(d, d);
        if (d2 < least) {
            least = d2;
            nearest = i;
        }
    }
    return s->cell_colour[nearest];
}

typedef struct stage {
    const exact_scene *s;
    const sheen_mesh *mesh; // the true one
    sheen_scene *scene;
    sheen_texture irradiance;
    const sheen_gbuffer *g;
    sheen_image *diffuse, *specular;
} stage;

// The slope of a relief of waves, on the true surface.
static void emboss(float n[3], const exact_scene *s, const float p[3])
{
    enum { WAVES = 8 };
    uint64_t seed = 77 + s->o.seed;
    if (!(s->o.relief_deg > 0))
        return;
    float slope[3] = {0, 0, 0};
    const double shortest_m = s->o.relief_m > 0 ? s->o.relief_m : 0.003;
    for (int k = 0; k < WAVES; k++) {
        float wave[3];
        test_direction(wave, &seed);
        const float phase = (float)(2 * pi * test_random(&seed)),
                    length_m = (float)(shortest_m * (1 + test_random(&seed)));
        const float at = cosf((float)(2 * pi) / length_m * sheen_dotf(wave, p) + phase);
        for (int c = 0; c < 3; c++)
            slope[c] += at * wave[c];
    }
    // A wave's slope across the normal is 2/3 of its square, its mean square half of it
    const float scale = (float)(s->o.relief_deg * pi / 180 / sqrt(WAVES / 3.0));
    const float along = sheen_dotf(slope, n);
    for (int c = 0; c < 3; c++)
        n[c] -= scale * (slope[c] - along * n[c]);
    sheen_normalizef(n);
}

// Bit i: something stands between the point and the middle of light i.
static void find_hidden(int hidden[EXACT_LIGHTS], const stage *st, const float p[3], const float n[3])
{
    for (int i = 0; i < EXACT_LIGHTS; i++) {
        const exact_light *l = &st->s->lights[i];
        const double d = isfinite(l->distance_m) ? l->distance_m : 50;
        const float target[3] = {(float)(d * l->v_world[0]), (float)(d * l->v_world[1]),
                                 (float)(d * l->v_world[2])};
        float from[3];
        uint8_t blocked;
        for (int k = 0; k < 3; k++)
            from[k] = p[k] + 1e-4f * n[k];
        sheen_scene_occluded(st->scene, &blocked, from, 1, target, 1e-5f);
        hidden[i] = blocked;
    }
}

// Light that falls on a point, times 1 / pi: the room's, and the lights' where they are not hidden.
static void irradiate(void *self, size_t begin, size_t end)
{
    stage *st = self;
    enum { N = IRRADIANCE_EDGE * (IRRADIANCE_EDGE + 1) / 2 };
    float p[3 * N], n[3 * N];
    for (size_t f = begin; f < end; f++) {
        sheen_texture_lattice(st->mesh, f, IRRADIANCE_EDGE, p, n);
        for (size_t k = 0; k < N; k++) {
            int hidden[EXACT_LIGHTS];
            float *E = st->irradiance.rgb + 3 * (f * N + k);
            emboss(n + 3 * k, st->s, p + 3 * k);
            find_hidden(hidden, st, p + 3 * k, n + 3 * k);
            E[0] = E[1] = E[2] = 0.3f + 0.1f * n[3 * k + 2];
            for (int i = 0; i < EXACT_LIGHTS; i++) {
                const exact_light *l = &st->s->lights[i];
                const float v[3] = {(float)l->v_world[0], (float)l->v_world[1], (float)l->v_world[2]};
                const float cosine = sheen_dotf(v, n + 3 * k);
                for (int c = 0; c < 3 && cosine > 0 && !hidden[i]; c++)
                    E[c] += 0.35f * cosine * (float)(l->rgb[c] / st->s->o.brightness);
            }
            st->irradiance.n_views[f * N + k] = 1;
        }
    }
}

// Added: the room in the mirror direction, where no other part of the object is before it, by Schlick's term.
static void mirror_room(double specular[3], const stage *st, const float p[3], const float n[3],
                        const float v[3], const double tint[3])
{
    const float cosine = sheen_dotf(n, v);
    float from[3], target[3];
    double above[3], L[3];
    uint8_t blocked;
    if (!(st->s->o.room > 0) || !(cosine > 0))
        return;
    for (int k = 0; k < 3; k++) {
        const float r = 2 * cosine * n[k] - v[k];
        above[k] = (double)r;
        from[k] = p[k] + 1e-4f * n[k];
        target[k] = from[k] + 50 * r;
    }
    sheen_scene_occluded(st->scene, &blocked, from, 1, target, 1e-5f);
    if (blocked)
        return;
    exact_room(L, st->s, above);
    for (int c = 0; c < 3; c++) {
        const double f0 = st->s->o.metal ? tint[c] : 0.04;
        specular[c] += (f0 + (1 - f0) * pow(1 - fmin(1, (double)cosine), 5)) * L[c];
    }
}

static void shade_hit(double diffuse[3], double specular[3], const stage *st, const sheen_hit *hit)
{
    float p[3], n[3], v[3], E[3];
    int hidden[EXACT_LIGHTS];
    sheen_hit_surface(st->mesh, hit, st->g->p_camera_obj, p, n, v);
    emboss(n, st->s, p);
    sheen_texture_sample(&st->irradiance, hit, E);
    const int colour = exact_colour(st->s, p);
    const double pd[3] = {(double)p[0], (double)p[1], (double)p[2]},
                 nd[3] = {(double)n[0], (double)n[1], (double)n[2]},
                 vd[3] = {(double)v[0], (double)v[1], (double)v[2]};
    static const int none[EXACT_LIGHTS] = {0};
    exact_specular(specular, st->s, pd, nd, vd, none);
    if (specular[0] + specular[1] + specular[2] > 1e-5) { // else whatever is hidden does not matter
        find_hidden(hidden, st, p, n);
        exact_specular(specular, st->s, pd, nd, vd, hidden);
    }
    for (int c = 0; c < 3; c++) {
        specular[c] *= st->s->k_s[colour] * st->s->tint[colour][c];
        diffuse[c] = st->s->albedo[colour][c] * (double)E[c];
    }
    mirror_room(specular, st, p, n, v, st->s->tint[colour]);
}

static void draw_rows(void *self, size_t begin, size_t end)
{
    const stage *st = self;
    const sheen_gbuffer *g = st->g;
    const int n = g->samples_per_side;
    const size_t stride = (size_t)g->width_px * (size_t)n;
    for (size_t y = begin; y < end; y++)
        for (int x = 0; x < g->width_px; x++)
            for (int k = 0; k < n * n; k++) {
                const sheen_hit *hit = g->hits + (y * (size_t)n + (size_t)(k / n)) * stride +
                                       (size_t)(x * n + k % n);
                double diffuse[3], specular[3];
                if (hit->triangle == SHEEN_NO_HIT)
                    continue;
                shade_hit(diffuse, specular, st, hit);
                for (int c = 0; c < 3; c++) {
                    sheen_image_at(st->diffuse, g->x0_px + x,
                                   g->y0_px + (int)y)[c] += (float)(diffuse[c] / (n * n));
                    sheen_image_at(st->specular, g->x0_px + x,
                                   g->y0_px + (int)y)[c] += (float)(specular[c] / (n * n));
                }
            }
}

// One view's true layers.
static void draw(sheen_image *diffuse, sheen_image *specular, stage *st, const sheen_camera *cam,
                 const double rt_cam_obj[6])
{
    sheen_err err;
    sheen_gbuffer g;
    assert_ok(sheen_image_init(diffuse, cam->width_px, cam->height_px, 3, &err), err);
    assert_ok(sheen_image_init(specular, cam->width_px, cam->height_px, 3, &err), err);
    assert_ok(sheen_gbuffer_make(&g, st->scene, st->mesh, cam, rt_cam_obj, 2, 0, &err), err);
    st->g = &g;
    st->diffuse = diffuse;
    st->specular = specular;
    sheen_parallel_for((size_t)g.height_px, 8, 0, draw_rows, st);
    sheen_gbuffer_release(&g);
}

static void compose(sheen_image *photo, const sheen_image *diffuse, const sheen_image *specular)
{
    sheen_err err;
    assert_ok(sheen_image_init(photo, diffuse->width_px, diffuse->height_px, 3, &err), err);
    const size_t n = (size_t)diffuse->width_px * (size_t)diffuse->height_px * 3;
    for (size_t i = 0; i < n; i++)
        photo->data[i] = diffuse->data[i] + specular->data[i];
}

static void spoil_image(exact_scene *s, sheen_image *photo, const double gain[3], uint64_t *seed,
                        double counts[2])
{
    const size_t n = (size_t)photo->width_px * (size_t)photo->height_px;
    for (size_t i = 0; i < n; i++) {
        float *rgb = photo->data + 3 * i;
        const int on_object = rgb[0] + rgb[1] + rgb[2] > 0;
        int clipped = 0;
        for (int c = 0; c < 3; c++) {
            const double light = (double)rgb[c] * gain[c] + s->o.noise * test_random_normal(seed);
            rgb[c] = (float)light;
            clipped = clipped || light >= 1;
            if (s->o.eight_bit) {
                const float code = sheen_transfer_encode(SHEEN_TRANSFER_SRGB, fminf(1, fmaxf(0, rgb[c])));
                rgb[c] = sheen_transfer_decode(SHEEN_TRANSFER_SRGB, roundf(255 * code) / 255);
            }
        }
        counts[0] += on_object;
        counts[1] += on_object && clipped;
    }
}

double exact_pose_error_px(const exact_scene *s, const double rt_a[6], const double rt_b[6])
{
    sheen_Rt A, B;
    double sum = 0;
    sheen_Rt_from_rt(&A, rt_a);
    sheen_Rt_from_rt(&B, rt_b);
    for (size_t i = 0; i < s->mesh.n_vertices; i++) {
        const float *v = s->mesh.p_obj + 3 * i;
        const double p[3] = {(double)v[0], (double)v[1], (double)v[2]};
        double p_cam[6], q[4];
        sheen_Rt_point(p_cam, &A, p);
        sheen_Rt_point(p_cam + 3, &B, p);
        sheen_err err;
        assert_ok(sheen_camera_project(&s->inputs.cam, q, NULL, p_cam, 2, &err), err);
        sum += (q[0] - q[2]) * (q[0] - q[2]) + (q[1] - q[3]) * (q[1] - q[3]);
    }
    return sqrt(sum / (double)s->mesh.n_vertices);
}

// A random small motion, scaled until the pictures of the vertices are off by pose_px in the root mean square.
static void spoil_pose(exact_scene *s, double rt_cam_obj[6], uint64_t *seed)
{
    double motion[6], scale = 1, moved[6];
    if (!(s->o.pose_px > 0))
        return;
    for (int k = 0; k < 6; k++)
        motion[k] = (k < 3 ? 0.004 : 0.0004) * test_random_normal(seed);
    for (int round = 0; round < 6; round++) {
        double step[6];
        for (int k = 0; k < 6; k++)
            step[k] = scale * motion[k];
        sheen_rt_compose(moved, rt_cam_obj, step);
        scale *= s->o.pose_px / exact_pose_error_px(s, moved, rt_cam_obj);
    }
    memcpy(rt_cam_obj, moved, sizeof moved);
}

// A smooth random field of small rotations: waves of 2 to 5 cm.
static void spoil_normals(exact_scene *s, uint64_t *seed)
{
    enum { WAVES = 12 };
    float wave[WAVES][3], phase[WAVES], axis[WAVES][3];
    if (!(s->o.normals_deg > 0))
        return;
    for (int k = 0; k < WAVES; k++) {
        test_direction(wave[k], seed);
        test_direction(axis[k], seed);
        phase[k] = (float)(2 * pi * test_random(seed));
        const float length_m = (float)(0.02 + 0.03 * test_random(seed));
        for (int i = 0; i < 3; i++)
            wave[k][i] *= (float)(2 * pi) / length_m;
    }
    double scale = 0;
    for (int pass = 0; pass < 2; pass++) { // measure, then apply
        double sum = 0;
        for (size_t v = 0; v < s->mesh.n_vertices; v++) {
            float turn[3] = {0, 0, 0}, d[3], *n = s->mesh.n_obj + 3 * v;
            for (int k = 0; k < WAVES; k++)
                for (int i = 0; i < 3; i++)
                    turn[i] += axis[k][i] * sinf(sheen_dotf(wave[k], s->mesh.p_obj + 3 * v) + phase[k]);
            sheen_crossf(d, turn, n);
            sum += (double)sheen_dotf(d, d);
            for (int i = 0; i < 3; i++)
                n[i] += (float)scale * d[i];
            sheen_normalizef(n);
        }
        scale = s->o.normals_deg * pi / 180 / sqrt(sum / (double)s->mesh.n_vertices);
    }
}

static void make_gains(exact_scene *s, uint64_t *seed)
{
    double mean[3] = {0, 0, 0};
    for (size_t i = 0; i < s->inputs.count; i++) {
        const double ev = s->o.drift_ev * (2 * test_random(seed) - 1);
        for (int c = 0; c < 3; c++) {
            const double colour = c == 1 ? 0 : s->o.white_balance * (2 * test_random(seed) - 1);
            s->gain[i][c] = ev * log(2) + log(1 + colour);
            mean[c] += s->gain[i][c] / (double)s->inputs.count;
        }
    }
    for (size_t i = 0; i < s->inputs.count; i++)
        for (int c = 0; c < 3; c++)
            s->gain[i][c] = exp(s->gain[i][c] - mean[c]);
}

static void stand(sheen_photo *p, size_t i, double az, double el)
{
    snprintf(p->name, sizeof p->name, "view%02zu", i);
    test_look(p->rt_cam_obj, 0.55 * cos(el) * cos(az), 0.55 * cos(el) * sin(az), 0.55 * sin(el));
}

static void pose_ring(sheen_photos *photos, size_t n, double turn_rad, double elevation_rad)
{
    photos->photos = calloc(n, sizeof *photos->photos);
    assert_non_null(photos->photos);
    photos->count = n;
    for (size_t i = 0; i < n; i++)
        // Every other view a little higher, so that the cameras are not on one circle
        stand(&photos->photos[i], i, turn_rad + 2 * pi * (double)i / (double)n,
              elevation_rad + (i % 2 ? 0.09 : -0.09));
}

// World is the object's frame where the turn is 0: the first input's.
static void pose_turns(sheen_photos *photos, size_t n, double turn_rad, double elevation_rad,
                       size_t n_heights)
{
    const double step_rad = 20 * pi / 180;
    double rt_cam_world[6];
    photos->photos = calloc(n, sizeof *photos->photos);
    assert_non_null(photos->photos);
    photos->count = n;
    for (size_t i = 0; i < n; i++) {
        sheen_photo *p = &photos->photos[i];
        const size_t per_height = (n + n_heights - 1) / n_heights, height = i / per_height;
        const double el = elevation_rad + step_rad * (double)height,
                     turn = turn_rad + 2 * pi * (double)(i % per_height) / (double)per_height;
        stand(p, i, 0, el);
        memcpy(rt_cam_world, p->rt_cam_obj, sizeof rt_cam_world);
        stand(p, i, turn, el);
        p->rt_world_obj[2] = -turn; // about the object's z
        if (!i)
            sheen_rt_invert(photos->rt_world_cam, rt_cam_world);
    }
}

// The stage as it is while the object stands as in a photograph: in the object's frame the lights turn the other way.
static void turn_lights(stage *st, exact_scene *turned, const sheen_photo *p)
{
    const double turn = -p->rt_world_obj[2];
    for (int i = 0; i < EXACT_LIGHTS; i++) {
        const double *v = st->s->lights[i].v_world;
        double *to = turned->lights[i].v_world;
        to[0] = cos(turn) * v[0] - sin(turn) * v[1];
        to[1] = sin(turn) * v[0] + cos(turn) * v[1];
    }
    st->s = turned;
    sheen_parallel_for(st->mesh->n_triangles, 64, 0, irradiate, st);
}

static void draw_photo(sheen_image *diffuse, sheen_image *specular, stage *st, const sheen_photo *p)
{
    stage now = *st;
    exact_scene turned = *st->s;
    if (st->s->o.n_heights)
        turn_lights(&now, &turned, p);
    draw(diffuse, specular, &now, &st->s->inputs.cam, p->rt_cam_obj);
}

static void photograph(exact_scene *s, stage *st, uint64_t *seed)
{
    double counts[2] = {0, 0};
    for (size_t i = 0; i < s->inputs.count; i++) {
        sheen_photo *p = &s->inputs.photos[i];
        sheen_image diffuse, specular;
        memcpy(s->rt_cam_obj[i], p->rt_cam_obj, sizeof p->rt_cam_obj);
        draw_photo(&diffuse, &specular, st, p);
        compose(&p->image, &diffuse, &specular);
        spoil_image(s, &p->image, s->gain[i], seed, counts);
        spoil_pose(s, p->rt_cam_obj, seed);
        sheen_image_release(&diffuse);
        sheen_image_release(&specular);
    }
    s->clipped_share = counts[1] / counts[0];
    for (size_t i = 0; i < s->tests.count; i++) {
        draw_photo(&s->diffuse[i], &s->specular[i], st, &s->tests.photos[i]);
        compose(&s->tests.photos[i].image, &s->diffuse[i], &s->specular[i]);
    }
}

static void copy_mesh(sheen_mesh *out, const sheen_mesh *mesh)
{
    *out = *mesh;
    const size_t v = 3 * mesh->n_vertices * sizeof(float), t = 3 * mesh->n_triangles * sizeof(uint32_t);
    out->p_obj = malloc(v);
    out->n_obj = malloc(v);
    out->triangles = malloc(t);
    assert_true(out->p_obj && out->n_obj && out->triangles);
    memcpy(out->p_obj, mesh->p_obj, v);
    memcpy(out->n_obj, mesh->n_obj, v);
    memcpy(out->triangles, mesh->triangles, t);
}

static void allocate(exact_scene *s)
{
    const double size = s->o.size > 0 ? s->o.size : 1;
    const int width = (int)(1280 * size), height = (int)(960 * size);
    test_camera(&s->inputs.cam, width, height, 1700 * size, 0);
    s->tests.cam = s->inputs.cam;
    const size_t n_inputs = s->o.n_inputs ? s->o.n_inputs : 8, n_tests = s->o.n_tests ? s->o.n_tests : 4;
    if (s->o.n_heights) {
        const double el = (s->o.elevation_deg > 0 ? s->o.elevation_deg : 35) * pi / 180;
        pose_turns(&s->inputs, n_inputs, 0, el, s->o.n_heights);
        pose_turns(&s->tests, n_tests, 0.37, el, 1);
    } else {
        pose_ring(&s->inputs, n_inputs, 0.1, 0.61);
        pose_ring(&s->tests, n_tests, 0.5, 0.66);
    }
    s->rt_cam_obj = calloc(s->inputs.count, sizeof *s->rt_cam_obj);
    s->gain = calloc(s->inputs.count, sizeof *s->gain);
    s->diffuse = calloc(s->tests.count, sizeof *s->diffuse);
    s->specular = calloc(s->tests.count, sizeof *s->specular);
    assert_true(s->rt_cam_obj && s->gain && s->diffuse && s->specular);
}

void exact_scene_make(exact_scene *out, const exact_options *o)
{
    const float centre[3] = {0, 0, 0};
    uint64_t seed = 1000 + 17 * o->seed;
    sheen_err err;
    sheen_mesh mesh;
    memset(out, 0, sizeof *out);
    out->o = *o;
    if (!(out->o.brightness > 0))
        out->o.brightness = 1;
    if (o->sphere)
        test_sphere(&mesh, 12, centre, 0.09f);
    else
        test_figure(&mesh, 30, 0.078f, 0.024f);
    lay_out_lights(out, &seed);
    paint(out, &seed);
    furnish(out);
    allocate(out);
    make_gains(out, &seed);
    copy_mesh(&out->mesh, &mesh);
    stage st = {.s = out, .mesh = &mesh};
    assert_ok(sheen_scene_new(&st.scene, &mesh, &err), err);
    assert_ok(sheen_texture_init(&st.irradiance, mesh.n_triangles, IRRADIANCE_EDGE, &err), err);
    sheen_parallel_for(mesh.n_triangles, 64, 0, irradiate, &st);
    photograph(out, &st, &seed);
    spoil_normals(out, &seed);
    sheen_texture_release(&st.irradiance);
    sheen_scene_free(&st.scene);
    sheen_mesh_release(&mesh);
}

static void release_images(sheen_image *images, size_t n)
{
    for (size_t i = 0; i < n; i++)
        sheen_image_release(&images[i]);
    free(images);
}

void exact_scene_release(exact_scene *s)
{
    release_images(s->diffuse, s->tests.count);
    release_images(s->specular, s->tests.count);
    sheen_photos_release(&s->inputs);
    sheen_photos_release(&s->tests);
    sheen_mesh_release(&s->mesh);
    free(s->rt_cam_obj);
    free(s->gain);
}
