// SPDX-License-Identifier: Apache-2.0
// test_exact_scene.c - the measuring stick itself: scenes are what they say, and the truth scores as the truth.
#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "support.h"
#include "tests/fit/exact_score.h"

static void make(exact_scene *s, const char *name, double size)
{
    exact_options o;
    assert_true(exact_scene_options(&o, name, 1));
    o.size = size;
    o.n_inputs = 3;
    o.n_tests = 1;
    exact_scene_make(s, &o);
}

// sheen's model with the true lights, and the scene's paint as well as a few texels can hold it.
static void true_model(sheen_model *m, const exact_scene *s)
{
    enum { EDGE = 4, N = EDGE * (EDGE + 1) / 2 };
    sheen_err err;
    sheen_model_init(m);
    assert_ok(sheen_model_set_lights(m, EXACT_LIGHTS, &err), err);
    for (int i = 0; i < EXACT_LIGHTS; i++) {
        m->lights.dx[i] = (float)s->lights[i].v_world[0];
        m->lights.dy[i] = (float)s->lights[i].v_world[1];
        m->lights.dz[i] = (float)s->lights[i].v_world[2];
        m->lights.weight[i] = (float)s->lights[i].rgb[1];
    }
    m->k_s = 1;
    m->sigma_rad = s->o.sigma_rad;
    m->shadows = 1;
    for (int c = 0; c < 3; c++)
        m->light_rgb[c] = 1;
    assert_ok(sheen_texture_init(&m->texture, s->mesh.n_triangles, EDGE, &err), err);
    memset(m->texture.n_views, 1, s->mesh.n_triangles * N);
}

static void truth_scores_as_the_truth(void **state)
{
    (void)state;
    exact_scene s;
    exact_score e;
    sheen_model m;
    make(&s, "far", 0.25);
    true_model(&m, &s);
    exact_score_model(&e, &s, &m);
    exact_score_print_heading(stdout);
    exact_score_print(stdout, "far", "truth", &e);
    assert_int_equal(e.n_found, EXACT_LIGHTS);
    assert_true(e.direction_deg < 1e-3 && e.strength_error < 1e-5 && e.colour_error < 1e-3);
    assert_close(e.sigma_error, 0, 1e-6);
    assert_true(e.specular_db > 55);
    assert_true(e.no_specular_db < 35);
    m.lights.dx[2] = -m.lights.dx[2]; // the stick can tell
    m.lights.dy[2] = -m.lights.dy[2];
    exact_score_model(&e, &s, &m);
    assert_int_equal(e.n_found, EXACT_LIGHTS - 1);
    assert_true(e.specular_db < 45);
    sheen_model_release(&m);
    exact_scene_release(&s);
}

static double rms_normal_error_deg(const exact_scene *a, const exact_scene *b)
{
    double sum = 0;
    for (size_t i = 0; i < a->mesh.n_vertices; i++) {
        float d[3];
        sheen_subf(d, a->mesh.n_obj + 3 * i, b->mesh.n_obj + 3 * i);
        sum += (double)sheen_dotf(d, d);
    }
    return sqrt(sum / (double)a->mesh.n_vertices) * 57.29577951;
}

static void spoils_as_asked(void **state)
{
    (void)state;
    exact_scene clean, s;
    make(&clean, "far", 0.15);
    make(&s, "everything", 0.15);
    for (size_t i = 0; i < s.inputs.count; i++)
        assert_close(exact_pose_error_px(&s, s.inputs.photos[i].rt_cam_obj, s.rt_cam_obj[i]), 0.75, 0.01);
    assert_close(rms_normal_error_deg(&s, &clean), 0.5, 0.02);
    exact_scene_release(&s);
    make(&s, "drift", 0.15);
    double product = 1, most = 0;
    for (size_t i = 0; i < s.inputs.count; i++) {
        product *= s.gain[i][1];
        most = fmax(most, fabs(log2(s.gain[i][1])));
    }
    assert_close(product, 1, 1e-9);
    assert_true(most > 0.1 && most < 1);
    exact_scene_release(&s);
    make(&s, "saturated", 0.15);
    assert_true(s.clipped_share > 0.003 && s.clipped_share > 2 * clean.clipped_share);
    exact_scene_release(&s);
    exact_scene_release(&clean);
}

// A light twice as near to a place is four times as bright there, and GGX has its peak where it should, and Fresnel's rise.
static void lights_follow_their_formulas(void **state)
{
    (void)state;
    static exact_scene s;
    static const int all_but_first[EXACT_LIGHTS] = {0, 1, 1, 1, 1, 1};
    double rgb[3];
    s.o.sigma_rad = 0.05;
    s.lights[0] = (exact_light){{0, 0, 1}, 1, 0, {0.5, 0.4, 0.3}};
    const double up[3] = {0, 0, 1}, middle[3] = {0, 0, 0}, half_way[3] = {0, 0, 0.5};
    exact_specular(rgb, &s, middle, up, up, all_but_first);
    assert_close(rgb[0], 0.5, 1e-12);
    assert_close(rgb[2], 0.3, 1e-12);
    exact_specular(rgb, &s, half_way, up, up, all_but_first);
    assert_close(rgb[0], 2, 1e-12);
    const double n[3] = {sin(0.05), 0, cos(0.05)}; // one sigma off
    exact_specular(rgb, &s, middle, n, up, all_but_first);
    assert_close(rgb[0], 0.5 * exp(-0.5) / cos(0.05), 1e-12);
    s.o.ggx_alpha = 0.1;
    exact_specular(rgb, &s, middle, up, up, all_but_first);
    assert_close(rgb[0], 0.5, 1e-12);
    // At 80 degrees both ways: F rises from 0.04, D is at its peak, G falls a little
    const double a = 80 / 57.29577951, v[3] = {sin(a), 0, cos(a)};
    s.lights[0].v_world[0] = -sin(a);
    s.lights[0].v_world[2] = cos(a);
    exact_specular(rgb, &s, middle, up, v, all_but_first);
    const double F = 0.04 + 0.96 * pow(1 - cos(a), 5), tan2 = tan(a) * tan(a),
                 lambda = (sqrt(1 + 0.01 * tan2) - 1) / 2;
    assert_close(rgb[0], 0.5 * F / 0.04 / (1 + 2 * lambda) / cos(a), 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(truth_scores_as_the_truth),
        cmocka_unit_test(spoils_as_asked),
        cmocka_unit_test(lights_follow_their_formulas),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
