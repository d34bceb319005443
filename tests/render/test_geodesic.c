// SPDX-License-Identifier: Apache-2.0
// test_geodesic.c - the illumination hemisphere: how many nodes, how evenly, and the searches against brute
// force.
#include "render/geodesic.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"

static const double pi = 3.14159265358979323846;

static void make(sheen_geodesic *g, int frequency)
{
    sheen_err err = {0};
    assert_ok(sheen_geodesic_init(g, frequency, &err), err);
}

static void has_the_papers_number_of_nodes(void **state)
{
    (void)state;
    sheen_geodesic g;
    make(&g, 60);
    assert_int_equal(g.n_nodes, 18151);
    size_t on_equator = 0;
    for (size_t i = 0; i < g.n_nodes; i++) {
        const float *v = g.v_world + 3 * i;
        assert_close(sheen_dotf(v, v), 1, 3e-7);
        assert_true(v[2] >= 0);
        on_equator += v[2] == 0;
    }
    assert_int_equal(on_equator, 300);
    assert_int_equal(2 * g.n_nodes - on_equator, 36002); // the whole sphere: 10 f^2 + 2
    assert_close(g.v_world[2], 1, 0);                    // +z is a node, and the first
    assert_close(sheen_geodesic_solid_angle_sr(&g), 2 * pi / 18151, 1e-12);
    assert_close(g.spacing_rad, 1.06 * pi / 180, 0.2 * pi / 180); // neighbours are 0.86 to 1.26 degrees apart
    sheen_geodesic_release(&g);
}

static void refuses_other_frequencies(void **state)
{
    (void)state;
    sheen_geodesic g;
    sheen_err err = {0};
    assert_fails(sheen_geodesic_init(&g, 0, &err), err, SHEEN_EARG, "frequency 0");
    assert_fails(sheen_geodesic_init(&g, 401, &err), err, SHEEN_EARG, "1 to 400");
    sheen_geodesic_release(&g);
}

// Nodes are distinct, and together with their mirror images make the sphere of 10 f^2 + 2.
static void nodes_are_distinct(void **state)
{
    (void)state;
    for (int f = 1; f <= 12; f++) {
        sheen_geodesic g;
        make(&g, f);
        size_t on_equator = 0;
        float least_cos = -1;
        for (size_t i = 0; i < g.n_nodes; i++) {
            on_equator += g.v_world[3 * i + 2] == 0;
            for (size_t j = 0; j < i; j++)
                least_cos = fmaxf(least_cos, sheen_dotf(g.v_world + 3 * i, g.v_world + 3 * j));
        }
        assert_true(acosf(least_cos) > 0.7f / (float)f);
        assert_int_equal(2 * g.n_nodes - on_equator, 10 * f * f + 2);
        sheen_geodesic_release(&g);
    }
}

static void order_depends_on_the_frequency_alone(void **state)
{
    (void)state;
    sheen_geodesic a, b;
    make(&a, 17);
    make(&b, 17);
    assert_int_equal(a.n_nodes, b.n_nodes);
    assert_memory_equal(a.v_world, b.v_world, 3 * a.n_nodes * sizeof *a.v_world);
    sheen_geodesic_release(&a);
    sheen_geodesic_release(&b);
}

static float best_cos(const sheen_geodesic *g, const float v[3])
{
    float best = -2;
    for (size_t i = 0; i < g->n_nodes; i++)
        best = fmaxf(best, sheen_dotf(v, g->v_world + 3 * i));
    return best;
}

static void nearest_agrees_with_brute_force(void **state)
{
    (void)state;
    static const int frequencies[] = {1, 2, 3, 4, 7, 20, 60};
    uint64_t seed = 3;
    for (size_t i = 0; i < sizeof frequencies / sizeof *frequencies; i++) {
        sheen_geodesic g;
        make(&g, frequencies[i]);
        for (int rep = 0; rep < 3000; rep++) {
            float v[3];
            test_direction(v, &seed);
            if (rep % 4 == 0) { // close to the horizon, on either side
                v[2] = (float)(0.4 * (double)g.spacing_rad * (2 * test_random(&seed) - 1));
                sheen_normalizef(v);
            } else if (rep % 4 == 1) { // on the search grid's seams
                v[rep % 8 < 4 ? 0 : 1] = 0;
                v[2] = fabsf(v[2]) + 1e-3f;
                sheen_normalizef(v);
            }
            const uint32_t node = sheen_geodesic_nearest(&g, v);
            if (v[2] < -sinf(0.5f * g.spacing_rad)) {
                assert_true(node == UINT32_MAX);
                continue;
            }
            assert_true(node < g.n_nodes);
            assert_close(sheen_dotf(v, g.v_world + 3 * (size_t)node), best_cos(&g, v), 1e-7);
        }
        sheen_geodesic_release(&g);
    }
}

static void each_node_is_nearest_to_itself(void **state)
{
    (void)state;
    sheen_geodesic g;
    make(&g, 33);
    for (size_t i = 0; i < g.n_nodes; i++)
        assert_int_equal(sheen_geodesic_nearest(&g, g.v_world + 3 * i), i);
    sheen_geodesic_release(&g);
}

static void within_agrees_with_brute_force(void **state)
{
    (void)state;
    static const float angles_rad[] = {0.001f, 0.03f, 0.1f, 0.5f, 1.5f, 3.2f};
    uint64_t seed = 5;
    sheen_geodesic g;
    make(&g, 30);
    uint32_t *got = malloc(g.n_nodes * sizeof *got);
    assert_non_null(got);
    for (size_t a = 0; a < sizeof angles_rad / sizeof *angles_rad; a++)
        for (int rep = 0; rep < 300; rep++) {
            float v[3];
            test_direction(v, &seed);
            const size_t n = sheen_geodesic_within(&g, got, g.n_nodes, v, angles_rad[a]);
            size_t want = 0;
            const float cos_angle = cosf(fminf(angles_rad[a], 3.1415926f));
            for (size_t i = 0; i < g.n_nodes; i++)
                if (sheen_dotf(v, g.v_world + 3 * i) >= cos_angle) {
                    assert_true(want < n);
                    assert_int_equal(got[want], i); // ascending
                    want++;
                }
            assert_int_equal(n, want);
            // Too little room: the first ones, and how many there are.
            uint32_t few[3] = {77777, 77777, 77777};
            assert_int_equal(sheen_geodesic_within(&g, few, 2, v, angles_rad[a]), want);
            for (size_t i = 0; i < 3; i++)
                assert_int_equal(few[i], i < 2 && i < want ? got[i] : 77777);
        }
    free(got);
    sheen_geodesic_release(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(has_the_papers_number_of_nodes),
        cmocka_unit_test(refuses_other_frequencies),
        cmocka_unit_test(nodes_are_distinct),
        cmocka_unit_test(order_depends_on_the_frequency_alone),
        cmocka_unit_test(nearest_agrees_with_brute_force),
        cmocka_unit_test(each_node_is_nearest_to_itself),
        cmocka_unit_test(within_agrees_with_brute_force),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
