// SPDX-License-Identifier: Apache-2.0
// test_lamps.c - lamps found from samples of highlights on a sphere: near and far, points and discs, clipped and spurious.
#include "fit/lamp_list.h"
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"
#include "base/vec.h"

enum { RINGS = 70, VIEWS = 8, MAX_SAMPLES = VIEWS * RINGS * 2 * RINGS };
static const double radius_m = 0.1;

typedef struct stage {
    sheen_lamp lamps[6];
    size_t n;
    sheen_lobe_shape lobe;
    double noise, white;
} stage;

static sheen_lamp lamp_at(double az_deg, double el_deg, double distance_m, double radius_rad,
                          const float rgb[3])
{
    const double az = az_deg * 3.14159265 / 180, el = el_deg * 3.14159265 / 180;
    return (sheen_lamp){
        .direction_world = {(float)(cos(el) * cos(az)), (float)(cos(el) * sin(az)), (float)sin(el)},
        .inverse_distance_per_m = distance_m > 0 ? (float)(1 / distance_m) : 0,
        .radius_rad = (float)radius_rad,
        .rgb = {rgb[0], rgb[1], rgb[2]}};
}

static void add_sample(sheen_lamp_samples *out, const stage *st, const float x_m[3], const float n[3],
                       const float v[3], size_t view, uint64_t *seed)
{
    double response[6];
    sheen_lamp_sample *s = &out->at[out->count];
    *s = (sheen_lamp_sample){.view = (uint32_t)view, .gloss = 1, .weight = 1};
    memcpy(s->x_m, x_m, sizeof s->x_m);
    memcpy(s->p_obj, x_m, sizeof s->p_obj);
    memcpy(s->n_world, n, sizeof s->n_world);
    memcpy(s->v_world, v, sizeof s->v_world);
    sheen_lamp_responses_ref(response, st->lamps, st->n, &st->lobe, s->x_m, n, v);
    for (int c = 0; c < 3; c++) {
        double sum = st->noise * test_random_normal(seed);
        for (size_t l = 0; l < st->n; l++)
            sum += response[l] * (double)st->lamps[l].rgb[c];
        s->clipped |= sum > st->white;
        s->rgb[c] = (float)fmin(sum, st->white);
    }
    s->Y = sheen_luminance(s->rgb);
    s->lit = s->clipped || s->Y > 0.04f;
    // Dark samples are thinned as lamp_samples.c thins them
    if (s->lit || test_random(seed) < 0.15) {
        out->n_lit += s->lit;
        out->count++;
    }
}

static void take_samples(sheen_lamp_samples *out, const stage *st)
{
    uint64_t seed = 5;
    *out = (sheen_lamp_samples){.n_views = VIEWS, .radius_m = (float)radius_m};
    assert_non_null(out->at = malloc(MAX_SAMPLES * sizeof *out->at));
    for (size_t view = 0; view < VIEWS; view++) {
        const double az = 6.283185307 * (double)view / VIEWS, el = 0.61;
        const double camera[3] = {0.5 * cos(el) * cos(az), 0.5 * cos(el) * sin(az), 0.5 * sin(el)};
        for (int i = 0; i < RINGS; i++)
            for (int k = 0; k < 2 * RINGS; k++) {
                const double z = -1 + 2 * (i + 0.5) / RINGS, phi = 6.283185307 * k / (2 * RINGS),
                             r = sqrt(1 - z * z);
                const float n[3] = {(float)(r * cos(phi)), (float)(r * sin(phi)), (float)z};
                float x_m[3], v[3];
                for (int c = 0; c < 3; c++) {
                    x_m[c] = (float)radius_m * n[c];
                    v[c] = (float)(camera[c] - radius_m * (double)n[c]);
                }
                sheen_normalizef(v);
                if (sheen_dotf(n, v) > 0.25f)
                    add_sample(out, st, x_m, n, v, view, &seed);
            }
    }
}

static sheen_lamp_list_options list_options(const stage *st, int n_threads)
{
    return (sheen_lamp_list_options){.threshold_lin = 0.04f,
                                     .max_lamps = 24,
                                     .find = 1,
                                     .last = 1,
                                     .fit = {.free_distance = 1,
                                             .free_radius = 1,
                                             .free_sigma = 1,
                                             .free_tail = st->lobe.tail > 0,
                                             .free_fresnel = st->lobe.fresnel > 0,
                                             .n_threads = n_threads}};
}

static void find(sheen_lamp_list *list, const stage *st, const sheen_lamp_samples *samples, int n_threads)
{
    sheen_err err;
    const sheen_lamp_list_options o = list_options(st, n_threads);
    *list = (sheen_lamp_list){.lobe = {.sigma_rad = 2 * st->lobe.sigma_rad}};
    assert_ok(sheen_lamp_list_fit(list, samples, &o, &err), err);
}

static const sheen_lamp *nearest(const sheen_lamp_list *list, const sheen_lamp *to)
{
    const sheen_lamp *best = &list->lamps[0];
    for (size_t i = 1; i < list->n; i++)
        if (sheen_dotf(list->lamps[i].direction_world, to->direction_world) >
            sheen_dotf(best->direction_world, to->direction_world))
            best = &list->lamps[i];
    return best;
}

static void check(const sheen_lamp_list *list, const stage *st, double strength_share)
{
    assert_int_equal(list->n, st->n);
    assert_close((double)(list->lobe.sigma_rad / st->lobe.sigma_rad), 1, 0.02);
    for (size_t i = 0; i < st->n; i++) {
        const sheen_lamp *want = &st->lamps[i], *got = nearest(list, want);
        float across[3];
        sheen_crossf(across, got->direction_world, want->direction_world);
        assert_true(sqrtf(sheen_dotf(across, across)) < 0.0018f); // 0.1 degrees
        assert_close((double)got->inverse_distance_per_m, (double)want->inverse_distance_per_m,
                     0.05 * (double)want->inverse_distance_per_m + 0.03);
        // An extent below a third of sigma hardly shows
        assert_close((double)(got->radius_rad * got->radius_rad),
                     (double)(want->radius_rad * want->radius_rad),
                     0.1 * (double)(st->lobe.sigma_rad * st->lobe.sigma_rad));
        for (int c = 0; c < 3; c++)
            assert_close((double)(got->rgb[c] / want->rgb[c]), 1, strength_share);
    }
}

static const float white[3] = {0.5f, 0.5f, 0.5f}, warm[3] = {0.6f, 0.45f, 0.3f},
                   blue[3] = {0.2f, 0.25f, 0.4f};

static stage near_and_far(void)
{
    stage st = {.n = 4, .lobe = {0.03f, 0, 0}, .noise = 0.003, .white = 1e9};
    st.lamps[0] = lamp_at(20, 40, 0.7, 0, white);
    st.lamps[1] = lamp_at(130, 60, 0, 0, warm);
    st.lamps[2] = lamp_at(-80, 35, 0.5, 0.08, white);
    st.lamps[3] = lamp_at(-150, 55, 1.5, 0, blue);
    return st;
}

static void near_far_disc_and_colour(void **state)
{
    (void)state;
    const stage st = near_and_far();
    sheen_lamp_samples samples;
    sheen_lamp_list one, two;
    take_samples(&samples, &st);
    find(&one, &st, &samples, 1);
    check(&one, &st, 0.02);
    find(&two, &st, &samples, 3);
    assert_int_equal(one.n, two.n);
    assert_memory_equal(one.lamps, two.lamps, one.n * sizeof *one.lamps);
    assert_true(one.lobe.sigma_rad == two.lobe.sigma_rad);
    sheen_lamp_samples_release(&samples);
}

// Highlights cut at half of their peak are lower bounds.
static void clipped_highlights(void **state)
{
    (void)state;
    stage st = near_and_far();
    st.white = 0.35;
    sheen_lamp_samples samples;
    sheen_lamp_list list;
    take_samples(&samples, &st);
    find(&list, &st, &samples, 2);
    check(&list, &st, 0.1);
    sheen_lamp_samples_release(&samples);
}

// Most lit samples are bounds, which hold for any lamp that is bright enough: the noise is to be told from the others.
static void highlights_of_which_most_is_clipped(void **state)
{
    (void)state;
    stage st = near_and_far();
    st.white = 0.15;
    sheen_lamp_samples samples;
    sheen_lamp_list list;
    take_samples(&samples, &st);
    size_t n_clipped = 0;
    for (size_t i = 0; i < samples.count; i++)
        n_clipped += samples.at[i].clipped;
    assert_true(2 * n_clipped > samples.n_lit);
    find(&list, &st, &samples, 2);
    check(&list, &st, 0.2);
    assert_true(list.scale < 2 * st.noise);
    sheen_lamp_samples_release(&samples);
}

static void heavy_tails_and_fresnel(void **state)
{
    (void)state;
    stage st = near_and_far();
    st.lobe = (sheen_lobe_shape){0.03f, 1, 24};
    sheen_lamp_samples samples;
    sheen_lamp_list list;
    take_samples(&samples, &st);
    find(&list, &st, &samples, 2);
    check(&list, &st, 0.05);
    assert_close((double)list.lobe.tail, 1, 0.05);
    assert_close((double)list.lobe.fresnel, 24, 3);
    sheen_lamp_samples_release(&samples);
}

// A bright patch in one photograph, where the others see the same direction dark, is no lamp; nor is noise.
static void what_one_view_claims_is_no_lamp(void **state)
{
    (void)state;
    stage st = {.n = 0, .lobe = {0.03f, 0, 0}, .noise = 0.01, .white = 1};
    sheen_lamp_samples samples;
    sheen_lamp_list list;
    take_samples(&samples, &st);
    for (size_t i = 0; i < samples.count; i++) {
        sheen_lamp_sample *s = &samples.at[i];
        if (s->view == 2 && s->n_world[2] > 0.8f) {
            s->rgb[0] = s->rgb[1] = s->rgb[2] = s->Y = 0.3f;
            s->lit = 1;
        }
    }
    find(&list, &st, &samples, 2);
    assert_int_equal(list.n, 0);
    sheen_lamp_samples_release(&samples);
}

// Photographs from one side of a table under one lamp: the highlight hardly moves on it.
static void take_table_samples(sheen_lamp_samples *out, const stage *st)
{
    static const float up[3] = {0, 0, 1};
    uint64_t seed = 5;
    *out = (sheen_lamp_samples){.n_views = VIEWS, .radius_m = (float)radius_m};
    assert_non_null(out->at = malloc(MAX_SAMPLES * sizeof *out->at));
    for (size_t view = 0; view < VIEWS; view++) {
        const double az = 0.06 * (double)view;
        const float camera_m[3] = {(float)(-0.5 * cos(az)), (float)(-0.5 * sin(az)), 0.4f};
        for (int i = 0; i < RINGS; i++)
            for (int k = 0; k < RINGS; k++) {
                const float x_m[3] = {(float)(radius_m * (2 * (i + 0.5) / RINGS - 1)),
                                      (float)(radius_m * (2 * (k + 0.5) / RINGS - 1)), 0};
                float v[3];
                sheen_subf(v, camera_m, x_m);
                sheen_normalizef(v);
                add_sample(out, st, x_m, up, v, view, &seed);
            }
    }
}

// What asks for a lamp in the object, where none is believed, must not lose it all that it explains.
static void what_no_near_lamp_can_be_comes_from_far(void **state)
{
    (void)state;
    sheen_lamp_samples samples;
    sheen_err err;
    stage st = {.n = 1, .lobe = {0.1f, 0, 0}, .noise = 0.1, .white = 1e9};
    st.lamps[0] = lamp_at(20, 40, 0.133, 0, white); // 1.33 radii from the middle, where 1.43 is the least
    sheen_lamp_list list = {.n = 1, .lamps = {lamp_at(20, 40, 0.2, 0, white)}, .lobe = st.lobe};
    sheen_lamp_list_options o = list_options(&st, 1);
    o.find = 0;
    take_table_samples(&samples, &st);
    assert_ok(sheen_lamp_list_fit(&list, &samples, &o, &err), err);
    assert_int_equal(list.n, 1);
    assert_true(list.cost < 0.75 * list.dark_cost);
    assert_true(list.lamps[0].inverse_distance_per_m * samples.radius_m < 0.7f);
    sheen_lamp_samples_release(&samples);
}

// A pixel in which the normal changes by more than sigma shows a blurred lobe: the lobe itself is found.
static void curved_pixels(void **state)
{
    (void)state;
    enum { SIDE = 8 };
    stage st = {.n = 2, .lobe = {0.03f, 0, 0}, .noise = 0, .white = 1e9};
    st.lamps[0] = lamp_at(20, 40, 0, 0, white);
    st.lamps[1] = lamp_at(-130, 60, 0, 0, warm);
    sheen_lamp_samples samples;
    sheen_lamp_list list;
    take_samples(&samples, &st);
    for (size_t i = 0; i < samples.count; i++) {
        sheen_lamp_sample *s = &samples.at[i];
        const float up[3] = {0, 0, 1};
        double sum = 0;
        sheen_crossf(s->n_step[0], up, s->n_world);
        sheen_crossf(s->n_step[1], s->n_world, s->n_step[0]);
        for (int c = 0; c < 3; c++) {
            s->n_step[0][c] *= 0.04f;
            s->n_step[1][c] *= 0.03f;
        }
        for (int k = 0; k < SIDE * SIDE; k++) {
            const float right = (float)(k % SIDE) / SIDE - 0.4375f,
                        below = (float)(k / SIDE) / SIDE - 0.4375f;
            float n[3];
            double response[6];
            for (int c = 0; c < 3; c++)
                n[c] = s->n_world[c] + right * s->n_step[0][c] + below * s->n_step[1][c];
            sheen_normalizef(n);
            sheen_lamp_responses_ref(response, st.lamps, st.n, &st.lobe, s->x_m, n, s->v_world);
            for (size_t l = 0; l < st.n; l++)
                sum += response[l] * (double)sheen_luminance(st.lamps[l].rgb) / (SIDE * SIDE);
        }
        s->Y = s->rgb[0] = s->rgb[1] = s->rgb[2] = (float)sum;
        s->lit = s->Y > 0.04f;
    }
    find(&list, &st, &samples, 2);
    assert_int_equal(list.n, 2);
    assert_close((double)list.lobe.sigma_rad, 0.03, 0.0009);
    sheen_lamp_samples_release(&samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(near_far_disc_and_colour),
        cmocka_unit_test(clipped_highlights),
        cmocka_unit_test(highlights_of_which_most_is_clipped),
        cmocka_unit_test(heavy_tails_and_fresnel),
        cmocka_unit_test(curved_pixels),
        cmocka_unit_test(what_one_view_claims_is_no_lamp),
        cmocka_unit_test(what_no_near_lamp_can_be_comes_from_far),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
