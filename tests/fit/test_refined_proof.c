// SPDX-License-Identifier: Apache-2.0
// test_refined_proof.c - a model with lamps that its photographs show keeps them; one with lamps that they do not show loses them,
// and is then the model that never had any.
#include "fit/diffuse.h"
#include "fit/method.h"
#include "fit/refined_state.h"
#include "support.h"
#include "tests/fit/exact_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const sheen_paper_options options = {.keep_poses = true,
                                            .keep_exposures = true,
                                            .keep_texels = true,
                                            .texels_per_edge = 4,
                                            .frequency = 20,
                                            .max_samples = 3000,
                                            .stop_after = SHEEN_PAPER_HEMISPHERE};

static void make_scene(exact_scene *s, const char *name)
{
    exact_options o;
    assert_true(exact_scene_options(&o, name, 5));
    o.size = 0.15;
    exact_scene_make(s, &o);
}

// A fit as far as its texture, under these lamps.
static void begin(sheen_refined_state *r, sheen_paper_fit *f, exact_scene *s, const sheen_model *lit)
{
    sheen_err err;
    assert_ok(sheen_paper_fit_make(f, &s->mesh, &s->inputs, &options, &err), err);
    memcpy(f->model.rt_world_obj, s->inputs.photos[0].rt_world_obj, sizeof f->model.rt_world_obj);
    f->model.mesh = s->mesh; // lent
    *r = (sheen_refined_state){.f = f, .mesh = &s->mesh, .photos = &s->inputs, .o = options};
    assert_ok(sheen_refined_state_init(r, &err), err);
    f->texel_deviation = malloc((r->views[0].n_texels + 1) * sizeof(float));
    assert_non_null(f->texel_deviation);
    f->model.sigma_rad = 0.03;
    if (lit) {
        assert_ok(sheen_model_set_lamps(&f->model, lit->lamps, lit->n_lamps, &err), err);
        f->model.k_s = lit->k_s;
        f->model.sigma_rad = lit->sigma_rad;
    }
    assert_ok(sheen_refined_light_views(r, &err), err);
    sheen_diffuse_fit(&f->model.texture, f->texel_deviation, &f->model.surroundings, r->views, r->lights,
                      f->n_views, 0);
}

static void end(sheen_refined_state *r, sheen_paper_fit *f)
{
    sheen_refined_state_release(r);
    f->model.mesh = (sheen_mesh){0};
    sheen_paper_fit_release(f);
}

static double texture_difference(const sheen_texture *a, const sheen_texture *b)
{
    const size_t n = 3 * a->n_triangles * sheen_texels_per_triangle(a->texels_per_edge);
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs((double)a->rgb[i] - (double)b->rgb[i]));
    return most;
}

static void lamps_stay_where_photographs_show_them(void **state)
{
    (void)state;
    exact_scene shiny, matte;
    sheen_paper_fit fitted, f, never;
    sheen_refined_state r, q;
    sheen_err err;
    make_scene(&shiny, "far");
    make_scene(&matte, "matte"); // the same lights over paint that does not shine
    assert_ok(sheen_fit_make(&fitted, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &shiny.mesh, &shiny.inputs,
                             &options, &err),
              err);
    assert_true(fitted.model.n_lamps > 0 && !fitted.lights_refuted);

    begin(&r, &f, &shiny, &fitted.model);
    assert_ok(sheen_refined_prove(&r, &err), err);
    assert_false(f.lights_refuted);
    assert_int_equal(f.model.n_lamps, fitted.model.n_lamps);
    end(&r, &f);

    begin(&q, &never, &matte, NULL);
    begin(&r, &f, &matte, &fitted.model);
    assert_true(texture_difference(&f.model.texture, &never.model.texture) > 0.01);
    assert_ok(sheen_refined_prove(&r, &err), err);
    assert_true(f.lights_refuted);
    assert_int_equal(f.model.n_lamps, 0);
    assert_true(f.model.k_s == 0);
    assert_true(texture_difference(&f.model.texture, &never.model.texture) < 1e-6);
    end(&r, &f);
    end(&q, &never);
    sheen_paper_fit_release(&fitted);
    exact_scene_release(&shiny);
    exact_scene_release(&matte);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lamps_stay_where_photographs_show_them)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
