// SPDX-License-Identifier: Apache-2.0
// test_fill_holes.c - unseen surface takes its neighbours' colour and stays marked as unseen.
#include "fit/fill_holes.h"
#include "support.h"

#include <string.h>

enum { EDGE = 4, TEXELS = EDGE * (EDGE + 1) / 2 };

// A strip of five triangles, and one apart.
static const uint32_t triangles[] = {0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5, 4, 5, 6, 7, 8, 9};
static float p_obj[30], n_obj[30];

static sheen_mesh strip(void)
{
    static uint32_t corners[18];
    memcpy(corners, triangles, sizeof corners);
    return (sheen_mesh){
        .p_obj = p_obj, .n_obj = n_obj, .triangles = corners, .n_vertices = 10, .n_triangles = 6};
}

static void unseen_takes_what_is_beside_it(void **state)
{
    (void)state;
    sheen_err err;
    sheen_texture t;
    const sheen_mesh mesh = strip();
    assert_ok(sheen_texture_init(&t, 6, EDGE, &err), err);
    for (size_t k = 0; k < TEXELS; k++) {
        t.n_views[k] = 3;
        t.rgb[3 * k] = 0.5f;
        t.rgb[3 * k + 2] = 0.25f;
    }
    assert_ok(sheen_fill_holes(&t, &mesh, &err), err);
    for (size_t k = 0; k < 6 * TEXELS; k++) {
        assert_int_equal(t.n_views[k], k < TEXELS ? 3 : 0);
        assert_close(t.rgb[3 * k], 0.5, 1e-6); // the strip's far end, and the piece apart: the mean of all
        assert_close(t.rgb[3 * k + 1], 0, 0);
        assert_close(t.rgb[3 * k + 2], 0.25, 1e-6);
    }
    float rgb[3];
    const sheen_hit hole = {.triangle = 4, .b1 = 0.3f, .b2 = 0.3f};
    assert_close(sheen_texture_sample(&t, &hole, rgb), 0, 0);
    assert_close(rgb[0], 0.5, 1e-6);
    sheen_texture_release(&t);
}

static void nothing_seen_is_left_alone(void **state)
{
    (void)state;
    sheen_err err;
    sheen_texture t;
    const sheen_mesh mesh = strip();
    assert_ok(sheen_texture_init(&t, 6, EDGE, &err), err);
    assert_ok(sheen_fill_holes(&t, &mesh, &err), err);
    for (size_t k = 0; k < 18 * TEXELS; k++)
        assert_close(t.rgb[k], 0, 0);
    sheen_texture_release(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unseen_takes_what_is_beside_it),
        cmocka_unit_test(nothing_seen_is_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
