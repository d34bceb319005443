// SPDX-License-Identifier: Apache-2.0
// test_hemisphere.c - mirror shots, the consistency check, and the start of sigma.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "fit/hemisphere.h"
#include "fit/start_sigma.h"
#include "support.h"

static sheen_geodesic hemisphere_nodes(int frequency)
{
    sheen_geodesic g;
    sheen_err err;
    assert_ok(sheen_geodesic_init(&g, frequency, &err), err);
    return g;
}

// A pixel whose mirror direction is `mirror`: v straight up, n half-way between.
static sheen_residual_pixel pixel(const float mirror[3], float r, float g, float b)
{
    sheen_residual_pixel p = {.rgb = {r, g, b}, .v_world = {0, 0, 1}};
    for (int i = 0; i < 3; i++)
        p.n_world[i] = mirror[i] + p.v_world[i];
    sheen_normalizef(p.n_world);
    return p;
}

static void shots_land_in_the_mirror_direction(void **state)
{
    (void)state;
    sheen_geodesic g = hemisphere_nodes(10);
    sheen_err err;
    sheen_partial_hemisphere p;
    const uint32_t node = 77;
    const float *at = g.v_world + 3 * node, below[3] = {0.6f, 0, -0.8f};
    sheen_residual_pixel pixels[3] = {pixel(at, 1, 0, 0.5f), pixel(at, 0, 1, 0.5f), pixel(below, 9, 9, 9)};
    const sheen_residual r = {pixels, 3};
    assert_ok(sheen_partial_hemisphere_make(&p, &g, &r, 2, &err), err);
    for (uint32_t i = 0; i < g.n_nodes; i++)
        assert_int_equal(p.n_hits[i], i == node ? 2 : 0); // below the horizon: no node
    assert_close(p.rgb[3 * node], 0.5, 1e-6);             // the mean of the two
    assert_close(p.rgb[3 * node + 1], 0.5, 1e-6);
    assert_close(p.rgb[3 * node + 2], 0.5, 1e-6);
    sheen_partial_hemisphere_release(&p);
    sheen_geodesic_release(&g);
}

enum { N_NODES = 5, N_VIEWS = 3 };

// Node by node: lit in all views that reach it; lit in one of two; reached by none; lit by the only one; dark in all.
static void fill_views(sheen_partial_hemisphere views[N_VIEWS], float rgb[N_VIEWS][3 * N_NODES],
                       uint32_t hits[N_VIEWS][N_NODES])
{
    static const float Y[N_VIEWS][N_NODES] = {
        {0.6f, 0.5f, 0, 0, 0.01f}, {0.2f, 0, 0, 0.3f, 0.02f}, {0, 0, 0, 0, 0}};
    static const uint32_t reached[N_VIEWS][N_NODES] = {{4, 1, 0, 0, 1}, {1, 2, 0, 7, 1}, {0, 0, 0, 0, 0}};
    for (int v = 0; v < N_VIEWS; v++) {
        for (int i = 0; i < 3 * N_NODES; i++)
            rgb[v][i] = Y[v][i / 3];
        memcpy(hits[v], reached[v], sizeof reached[v]);
        views[v] = (sheen_partial_hemisphere){rgb[v], hits[v], N_NODES};
    }
}

static void only_consistent_nodes_pass(void **state)
{
    (void)state;
    sheen_partial_hemisphere views[N_VIEWS];
    float rgb[N_VIEWS][3 * N_NODES];
    uint32_t hits[N_VIEWS][N_NODES];
    sheen_hemisphere h;
    sheen_err err;
    fill_views(views, rgb, hits);
    assert_ok(sheen_hemisphere_combine(&h, views, N_VIEWS, 0.04f, 1, &err), err);
    static const int n_reached[N_NODES] = {2, 2, 0, 1, 2}, n_lit[N_NODES] = {2, 1, 0, 1, 0};
    static const double value[N_NODES] = {0.4, 0, 0, 0.3, 0};
    for (int i = 0; i < N_NODES; i++) {
        assert_int_equal(h.n_reached[i], n_reached[i]);
        assert_int_equal(h.n_lit[i], n_lit[i]);
        assert_close(h.rgb[3 * i], value[i], 1e-6);
    }
    assert_int_equal(h.n_assigned, 2);
    sheen_hemisphere_release(&h);
    // Half of the views will do: node 1 passes too, with the mean over the views that reach it
    assert_ok(sheen_hemisphere_combine(&h, views, N_VIEWS, 0.04f, 0.5f, &err), err);
    assert_int_equal(h.n_assigned, 3);
    assert_close(h.rgb[3], 0.25, 1e-6);
    sheen_hemisphere_release(&h);
}

static void colour_is_the_mean_with_luminance_1(void **state)
{
    (void)state;
    float rgb[6] = {0.4f, 0.3f, 0.2f, 0.8f, 0.6f, 0.4f};
    const sheen_hemisphere h = {.rgb = rgb, .n_nodes = 2}, dark = {0};
    double c[3];
    sheen_hemisphere_colour(c, &h);
    assert_close(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2], 1, 1e-6);
    assert_close(c[0] / c[2], 2, 1e-6);
    sheen_hemisphere_colour(c, &dark);
    assert_close(c[1], 1, 0);
}

// The spot of a point light under sigma: exp(-alpha^2 / 2 sigma^2), alpha half the angle from the light. Half of the nodes
// are not reached at all, as between mirror shots.
static void sigma_starts_above_the_truth(void **state)
{
    (void)state;
    sheen_geodesic g = hemisphere_nodes(60);
    for (double sigma = 0.02; sigma < 0.16; sigma *= 2) {
        float *rgb = calloc(3 * g.n_nodes, sizeof *rgb);
        uint8_t *reached = calloc(g.n_nodes, 1);
        for (uint32_t i = 0; i < g.n_nodes; i++) {
            const float cosine = sheen_dotf(g.v_world + 3 * i, g.v_world + 3 * 4000);
            const double alpha = 0.5 * acos(fmin(1, (double)cosine));
            reached[i] = i % 2 == 0;
            for (uint32_t c = 0; c < 3; c++)
                rgb[3 * i + c] = reached[i] ? (float)exp(-alpha * alpha / (2 * sigma * sigma)) : 0;
        }
        const sheen_hemisphere h = {.rgb = rgb, .n_reached = reached, .n_nodes = g.n_nodes, .n_assigned = 1};
        const double start = sheen_start_sigma(&h, &g);
        print_message("sigma %.3f starts at %.3f\n", sigma, start);
        assert_true(start > 1.4 * sigma && start < 3 * sigma);
        free(rgb);
        free(reached);
    }
    sheen_geodesic_release(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shots_land_in_the_mirror_direction),
        cmocka_unit_test(only_consistent_nodes_pass),
        cmocka_unit_test(colour_is_the_mean_with_luminance_1),
        cmocka_unit_test(sigma_starts_above_the_truth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
