// SPDX-License-Identifier: Apache-2.0
// test_lamp_proof.c - what a lamp explains of photographs left out; and which pixels lamps are estimated from.
#include "fit/lamp_proof.h"
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"
#include "base/vec.h"

enum { VIEWS = 6, RINGS = 60, MOST = RINGS * 2 * RINGS * VIEWS };

static const double radius_m = 0.1;
static const sheen_lobe_shape lobe = {.sigma_rad = 0.06f};

static sheen_lamp lamp_at(double az_deg, double el_deg, float radius_rad, float Y)
{
    const double az = az_deg * 3.14159265 / 180, el = el_deg * 3.14159265 / 180;
    return (sheen_lamp){
        .direction_world = {(float)(cos(el) * cos(az)), (float)(cos(el) * sin(az)), (float)sin(el)},
        .radius_rad = radius_rad,
        .rgb = {Y, Y, Y}};
}

static void look(float v[3], const float n[3], int view)
{
    const double az = 1 + 6.283185307 * view / VIEWS, el = view % 2 ? 0.5 : 0.8;
    const double camera[3] = {0.6 * cos(el) * cos(az), 0.6 * cos(el) * sin(az), 0.6 * sin(el)};
    for (int c = 0; c < 3; c++)
        v[c] = (float)(camera[c] - radius_m * (double)n[c]);
    sheen_normalizef(v);
}

// A painted sphere under lamps; each photograph's paint lies a little elsewhere, and has noise.
static void photograph(sheen_lamp_proof *out, const sheen_lamp *lamps, size_t n)
{
    uint64_t seed = 3;
    *out = (sheen_lamp_proof){.samples = {.n_views = VIEWS, .radius_m = (float)radius_m}};
    assert_non_null(out->samples.at = malloc(MOST * sizeof *out->samples.at));
    assert_non_null(out->first = calloc(RINGS * 2 * RINGS + 1, sizeof *out->first));
    for (int i = 0; i < RINGS * 2 * RINGS; i++) {
        const double z = -1 + 2 * (i / (2 * RINGS) + 0.5) / RINGS,
                     phi = 6.283185307 * (i % (2 * RINGS)) / (2 * RINGS);
        const double r = sqrt(1 - z * z);
        const float normal[3] = {(float)(r * cos(phi)), (float)(r * sin(phi)), (float)z};
        const size_t begin = out->samples.count;
        for (int view = 0; view < VIEWS; view++) {
            sheen_lamp_sample *s = &out->samples.at[out->samples.count];
            double response[4];
            *s = (sheen_lamp_sample){.view = (uint32_t)view, .gloss = 1, .weight = 1};
            look(s->v_world, normal, view);
            if (sheen_dotf(s->v_world, normal) < 0.25f)
                continue;
            for (int k = 0; k < 3; k++)
                s->x_m[k] = s->p_obj[k] = (float)radius_m * normal[k];
            memcpy(s->n_world, normal, sizeof normal);
            sheen_lamp_responses_ref(response, lamps, n, &lobe, s->x_m, normal, s->v_world);
            const double paint = 0.2 +
                                 0.15 * (sin(40 * z) * sin(13 * phi + 0.1 * test_random_normal(&seed)) > 0);
            double Y = paint + 0.005 * test_random_normal(&seed);
            for (size_t l = 0; l < n; l++)
                Y += response[l] * (double)sheen_luminance(lamps[l].rgb);
            s->Y = (float)Y;
            out->samples.count++;
        }
        if (out->samples.count > begin + 1)
            out->first[++out->n_texels] = out->samples.count;
        else
            out->samples.count = begin;
    }
}

static void explain(double *explained, const sheen_lamp_proof *p, const sheen_lamp *lamps, size_t n)
{
    const sheen_lamp_fit_options o = {.scale = 0.01};
    sheen_err err;
    assert_ok(sheen_lamp_proof_explained(explained, p, lamps, n, 0, &lobe, &o, &err), err);
}

static void true_lamps_explain_and_others_do_not(void **state)
{
    (void)state;
    // Two that are there, one of them faint; a wide one that brightens everything a little; one where there is none
    const sheen_lamp lamps[] = {lamp_at(20, 50, 0, 0.3f), lamp_at(200, 40, 0, 0.03f),
                                lamp_at(100, 70, 0.4f, 0.3f), lamp_at(120, 40, 0, 0.02f)};
    sheen_lamp_proof p;
    double explained[4];
    photograph(&p, lamps, 2);
    explain(explained, &p, lamps, 4);
    assert_true(explained[0] > 0.6);
    assert_true(explained[1] > 0.4);
    assert_true(explained[2] < 0.1);
    assert_true(explained[3] < 0.1);
    sheen_lamp_proof_release(&p);
}

// What is bright in all photographs alike belongs to the surface.
static void what_all_photographs_share_is_no_lamp(void **state)
{
    (void)state;
    const sheen_lamp wide = lamp_at(100, 80, 0.4f, 0.4f);
    sheen_lamp_proof p;
    double explained;
    photograph(&p, NULL, 0);
    for (size_t i = 0; i < p.samples.count; i++)
        p.samples.at[i].Y += 0.03f;
    explain(&explained, &p, &wide, 1);
    assert_true(explained < 0);
    sheen_lamp_proof_release(&p);
}

// A picture with a bright spot whose foot lies in the noise: all strata stand for as many pixels as there are of them.
static void samples_stand_for_all_pixels(void **state)
{
    (void)state;
    enum { EDGE = 120 };
    uint64_t seed = 9;
    sheen_err err;
    sheen_residual r = {.pixels = calloc(EDGE * EDGE, sizeof *r.pixels)};
    sheen_photo photo = {.rt_world_obj = {0}};
    const sheen_photos photos = {.photos = &photo, .count = 1};
    const sheen_lamp_samples_options o = {.threshold_lin = 0.04f, .max_lit = 100, .max_dark = 200};
    const float centre[3] = {0, 0, 0};
    sheen_lamp_samples samples;
    double lit = 0, sum = 0, beside = 0;
    assert_non_null(r.pixels);
    for (int y = 0; y < EDGE; y++)
        for (int x = 0; x < EDGE; x++) {
            sheen_residual_pixel *p = &r.pixels[r.count++];
            const double d2 = (x - 50) * (x - 50) + (y - 60) * (y - 60);
            const float Y = (float)(0.4 * exp(-d2 / 200) + 0.004 * test_random_normal(&seed));
            *p = (sheen_residual_pixel){.rgb = {Y, Y, Y}, .x_px = 700 + x, .y_px = 30 + y};
            lit += Y > 0.04f;
        }
    assert_ok(sheen_lamp_samples_take(&samples, &r, &photos, centre, 0.1f, &o, &err), err);
    assert_true(samples.n_lit <= 100 && samples.count <= 500);
    for (size_t i = 0; i < samples.count; i++) {
        sum += (double)samples.at[i].weight;
        // Pixels that are dark by themselves, beside the light
        beside += !samples.at[i].lit && samples.at[i].weight < 0.5f * samples.at[0].weight;
    }
    const double pixels_a_sample = ceil(lit / 100);
    assert_close(sum * pixels_a_sample, EDGE * EDGE, 0.02 * EDGE * EDGE);
    assert_true(beside > 100);
    sheen_lamp_samples_release(&samples);
    free(r.pixels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(true_lamps_explain_and_others_do_not),
        cmocka_unit_test(what_all_photographs_share_is_no_lamp),
        cmocka_unit_test(samples_stand_for_all_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
