// SPDX-License-Identifier: Apache-2.0
// test_certainty.c - uncertainties against their definition, and the sentences that they become.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/certainty.h"
#include "support.h"
#include "support_scene.h"

static const double two_lights[2][3] = {{0, 0, 1}, {0.6, 0, 0.8}};
enum { SIDE = 60 };

// Normals in a square about the light's, seen from the light: pixels of a small highlight, and its light plus noise.
static void show(sheen_residual *r, const double light[3], double strength, double sigma_rad, double noise,
                 uint64_t *seed)
{
    r->pixels = realloc(r->pixels, (r->count + SIDE * SIDE) * sizeof *r->pixels);
    assert_non_null(r->pixels);
    for (int i = 0; i < SIDE * SIDE; i++) {
        sheen_residual_pixel *p = &r->pixels[r->count++];
        const double across[3] = {light[2], 0, -light[0]};
        const double a = 0.3 * ((i % SIDE) / (SIDE - 1.0) - 0.5),
                     b = 0.3 * ((double)(i / SIDE) / (SIDE - 1.0) - 0.5);
        *p = (sheen_residual_pixel){.v_world = {(float)light[0], (float)light[1], (float)light[2]}};
        for (int k = 0; k < 3; k++)
            p->n_world[k] = (float)(light[k] + a * across[k] + b * (k == 1));
        sheen_normalizef(p->n_world);
        float dx = (float)light[0], dy = (float)light[1], dz = (float)light[2], w = (float)strength;
        const sheen_lights one = {&dx, &dy, &dz, &w, 1};
        const double Y = sheen_lobe_sum_ref(&one, p->n_world, p->v_world, (float)sigma_rad) +
                         noise * test_random_normal(seed);
        for (int c = 0; c < 3; c++)
            p->rgb[c] = (float)Y;
    }
}

// Two photographs, the second without the second light's highlight.
static void fill(sheen_paper_fit *f, double sigma_rad, double noise)
{
    uint64_t seed = 5;
    sheen_err err;
    memset(f, 0, sizeof *f);
    f->n_views = 2;
    f->residuals = calloc(2, sizeof *f->residuals);
    assert_non_null(f->residuals);
    show(&f->residuals[0], two_lights[0], 0.5, sigma_rad, noise, &seed);
    show(&f->residuals[0], two_lights[1], 0.3, sigma_rad, noise, &seed);
    show(&f->residuals[1], two_lights[0], 0.5, sigma_rad, noise, &seed);
    sheen_model_init(&f->model);
    assert_ok(sheen_model_set_lights(&f->model, 2, &err), err);
    for (int i = 0; i < 2; i++) {
        f->model.lights.dx[i] = (float)two_lights[i][0];
        f->model.lights.dy[i] = (float)two_lights[i][1];
        f->model.lights.dz[i] = (float)two_lights[i][2];
        f->model.lights.weight[i] = i ? 0.3f : 0.5f;
    }
    f->model.k_s = 1;
    f->model.sigma_rad = sigma_rad;
    f->refined.sigma_err = noise;
}

static void empty(sheen_paper_fit *f)
{
    for (size_t i = 0; i < f->n_views; i++)
        sheen_residual_release(&f->residuals[i]);
    free(f->residuals);
    sheen_model_release(&f->model);
}

static void says_what_one_photograph_cannot(void **state)
{
    (void)state;
    sheen_paper_fit f;
    sheen_certainty c;
    sheen_err err;
    fill(&f, 0.04, 0.01);
    assert_ok(sheen_certainty_find(&c, &f, NULL, NULL, SHEEN_MOVING_OBJECT, &err), err);
    assert_int_equal(c.n_lamps, 2);
    assert_int_equal(c.lamps[0].n_views, 2);
    assert_int_equal(c.lamps[1].n_views, 1);
    assert_close(c.lamps[0].strength, 0.5, 1e-6);
    assert_true(c.n_sentences >= 1);
    assert_non_null(strstr(c.sentences[0], "seen in one photograph only: roughness and size of the light"));
    assert_non_null(strstr(c.sentences[0], "azimuth 0, elevation 53 degrees"));
    assert_true(c.lamps[1].strength_share > 1.3 * c.lamps[0].strength_share); // half the pixels, less light
    sheen_certainty_release(&c);
    empty(&f);
}

// One light's strength, if all else were known, has the deviation noise / sqrt(sum I^2); with sigma to be found as well a
// Gaussian highlight loses half of that information (the correlation of height and width in two dimensions).
static void deviations_are_what_least_squares_says(void **state)
{
    (void)state;
    sheen_paper_fit f;
    sheen_certainty c;
    sheen_err err;
    const double sigma_rad = 0.03, noise = 0.004, pitch = 0.3 / (SIDE - 1.0);
    fill(&f, sigma_rad, noise);
    f.n_views = 1; // both lights, once each
    assert_ok(sheen_certainty_find(&c, &f, NULL, NULL, SHEEN_MOVING_OBJECT, &err), err);
    const double sum_I2 = 0.5 * 0.5 * 3.14159265 * sigma_rad * sigma_rad / (pitch * pitch);
    // The Lorentzian counts the noise's own tails less: the mean weight of a standard normal is 0.76
    const double alone = noise / sqrt(0.76 * sum_I2);
    assert_true(c.lamps[0].strength_share > alone && c.lamps[0].strength_share < 1.5 * alone);
    assert_true(c.lamps[0].direction_rad > 0.5 * 2 * sigma_rad * alone &&
                c.lamps[0].direction_rad < 4 * sigma_rad * alone);
    const double before = c.sigma_share;
    sheen_certainty_release(&c);
    f.n_views = 2;
    assert_ok(sheen_certainty_find(&c, &f, NULL, NULL, SHEEN_MOVING_OBJECT, &err), err);
    assert_true(c.sigma_share < before); // more is known from two
    assert_true(c.sigma_share > 0.5 * before);
    sheen_certainty_release(&c);
    empty(&f);
}

// Residuals that err together over a piece of the surface say less than as many that err one by one.
static void errors_in_patches_are_seen(void **state)
{
    (void)state;
    double share[2];
    for (int patches = 0; patches < 2; patches++) {
        sheen_paper_fit f;
        sheen_certainty c;
        sheen_err err;
        uint64_t seed = 8;
        fill(&f, 0.03, 0);
        f.refined.sigma_err = 0.004;
        f.n_views = 1;
        sheen_residual *r = &f.residuals[0];
        for (size_t i = 0; i < r->count; i++) {
            const double one = 0.004 * test_random_normal(&seed);
            const uint64_t x = i % SIDE / 10, y = i / SIDE % SIDE / 10;
            uint64_t patch = 77 + x + 1000 * y;
            for (int k = 0; k < 3; k++) {
                r->pixels[i].rgb[k] += (float)(patches ? 0.004 * test_random_normal(&patch) : one);
                patch = 77 + x + 1000 * y;
            }
            r->pixels[i].p_obj[0] = 0.001f * (float)(i % SIDE);
            r->pixels[i].p_obj[1] = 0.001f * (float)(i / SIDE % SIDE);
        }
        assert_ok(sheen_certainty_find(&c, &f, NULL, NULL, SHEEN_MOVING_OBJECT, &err), err);
        share[patches] = c.lamps[0].strength_share;
        sheen_certainty_release(&c);
        f.n_views = 2;
        empty(&f);
    }
    print_message("strength known to %.2f %% of independent, %.2f %% of patchy residuals\n", 100 * share[0],
                  100 * share[1]);
    assert_true(share[1] > 2 * share[0]);
}

// One camera above a sphere, lights to both sides seen once: the advice is to go round to where both can be seen again.
static void advises_a_viewpoint(void **state)
{
    (void)state;
    const float centre[3] = {0, 0, 0};
    sheen_paper_fit f;
    sheen_certainty c;
    sheen_err err;
    sheen_mesh mesh;
    sheen_photo photos[2] = {{.name = "a"}, {.name = "b"}};
    sheen_photos p = {.photos = photos, .count = 2};
    test_sphere(&mesh, 8, centre, 0.1f);
    fill(&f, 0.04, 0.01);
    for (int i = 0; i < 2; i++)
        test_look(photos[i].rt_cam_obj, 0.1 * i + 0.3, 0.01, 0.3);
    assert_ok(sheen_texture_init(&f.model.texture, mesh.n_triangles, 2, &err), err);
    for (size_t t = 0; t < mesh.n_triangles; t++) // the half towards +x was seen twice
        memset(f.model.texture.n_views + 3 * t, mesh.p_obj[3 * (size_t)mesh.triangles[3 * t]] > 0 ? 2 : 0, 3);
    assert_ok(sheen_certainty_find(&c, &f, &mesh, &p, SHEEN_MOVING_CAMERA, &err), err);
    assert_true(c.advised);
    assert_true(c.advice_azimuth_deg > 90 && c.advice_azimuth_deg < 270); // the half not yet seen
    assert_close(c.unseen_share, 0.5, 0.06);
    assert_non_null(strstr(c.sentences[c.n_sentences - 1], "would help most"));
    sheen_certainty_release(&c);
    sheen_mesh_release(&mesh);
    empty(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(says_what_one_photograph_cannot),
        cmocka_unit_test(deviations_are_what_least_squares_says),
        cmocka_unit_test(errors_in_patches_are_seen),
        cmocka_unit_test(advises_a_viewpoint),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
