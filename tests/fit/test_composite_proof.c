// SPDX-License-Identifier: Apache-2.0
// test_composite_proof.c - lights that photographs left out bear out, and such as one photograph alone suggested.
#include "fit/composite_proof.h"

#include <math.h>
#include <stdlib.h>

#include "support.h"

enum { N_VIEWS = 6, N_TRIANGLES = 300, EDGE = 4, N_TEXELS = N_TRIANGLES * 10 };

typedef struct made {
    sheen_texel_view views[N_VIEWS];
    sheen_view_light lights[N_VIEWS];
} made;

// Painted texels with noise. true_share: of the predicted lights that is in the photographs; of view `only`'s, where it is not -1, in
// that one's alone.
static void make(made *m, double true_share, int only)
{
    sheen_err err;
    uint64_t seed = 7;
    float paint[N_TEXELS];
    for (size_t t = 0; t < N_TEXELS; t++)
        paint[t] = 0.1f + 0.4f * (float)test_random(&seed);
    for (int v = 0; v < N_VIEWS; v++) {
        assert_ok(sheen_texel_view_init(&m->views[v], N_TRIANGLES, EDGE, &err), err);
        assert_ok(sheen_view_light_init(&m->lights[v], N_TEXELS, &err), err);
        for (size_t t = 0; t < N_TEXELS; t++) {
            const double light = test_random(&seed) < 0.1 ? 0.2 * test_random(&seed) : 0;
            const double shown = only < 0 || only == v ? true_share * light : 0;
            const double noise = 0.005 * test_random_normal(&seed);
            m->views[v].seen[t] = test_random(&seed) < 0.8;
            m->lights[v].cosine[t] = 0.3f + 0.7f * (float)test_random(&seed);
            for (size_t c = 0; c < 3; c++) {
                m->lights[v].lights_rgb[3 * t + c] = (float)light;
                m->views[v].rgb[3 * t + c] = paint[t] + (float)(shown + noise);
            }
        }
    }
}

static sheen_composite_proof prove(const made *m, int n_threads)
{
    const sheen_surroundings none = {0};
    sheen_composite_proof p;
    sheen_err err;
    assert_ok(sheen_composite_prove(&p, &none, m->views, m->lights, N_VIEWS, n_threads, &err), err);
    return p;
}

static void release(made *m)
{
    for (int v = 0; v < N_VIEWS; v++) {
        sheen_texel_view_release(&m->views[v]);
        sheen_view_light_release(&m->lights[v]);
    }
}

static void true_lights_are_borne_out(void **state)
{
    (void)state;
    made m;
    make(&m, 1, -1);
    const sheen_composite_proof p = prove(&m, 1), same = prove(&m, 3);
    assert_true(p.with_lights < 0.1 * p.texture_alone);
    assert_true(p.with_lights == same.with_lights && p.texture_alone == same.texture_alone);
    release(&m);
}

static void lights_that_nothing_shows_are_not(void **state)
{
    (void)state;
    made m;
    make(&m, -0.3, -1);
    const sheen_composite_proof p = prove(&m, 0);
    assert_true(p.with_lights >= p.texture_alone); // no share is negative
    release(&m);
}

// Explained to the last bit, and yet by one photograph's own word: there the others give it hardly a share.
static void a_photograph_is_no_witness_for_itself(void **state)
{
    (void)state;
    made m;
    make(&m, 1, 2);
    const sheen_composite_proof p = prove(&m, 0);
    print_message("with %.3g, alone %.3g\n", p.with_lights, p.texture_alone);
    assert_true(p.with_lights > 0.9 * p.texture_alone);
    release(&m);
}

static void nothing_seen_twice_is_no_proof(void **state)
{
    (void)state;
    made m;
    make(&m, 1, -1);
    for (size_t t = 0; t < N_TEXELS; t++)
        for (int v = 0; v < N_VIEWS; v++)
            m.views[v].seen[t] = v == (int)(t % N_VIEWS);
    const sheen_composite_proof p = prove(&m, 0);
    assert_true(p.with_lights == 0 && p.texture_alone == 0);
    release(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(true_lights_are_borne_out),
                                       cmocka_unit_test(lights_that_nothing_shows_are_not),
                                       cmocka_unit_test(a_photograph_is_no_witness_for_itself),
                                       cmocka_unit_test(nothing_seen_twice_is_no_proof)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
