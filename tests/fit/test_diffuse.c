// SPDX-License-Identifier: Apache-2.0
// test_diffuse.c - texture, F0 and ambient light from made samples of texels with known truth.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/diffuse.h"
#include "support.h"
#include "support_scene.h"

enum { N_VIEWS = 6, N_TRIANGLES = 400, EDGE = 3, N_TEXELS = N_TRIANGLES * 6 };

typedef struct made {
    sheen_texel_view views[N_VIEWS];
    sheen_view_light lights[N_VIEWS];
    sheen_texture texture, truth;
    sheen_surroundings e;
} made;

// Random mirror directions: half of them meet things of known radiance, half the room.
static void make(made *m, double noise, int spoiled)
{
    sheen_err err;
    uint64_t seed = 4;
    m->e = (sheen_surroundings){.present = 1, .f0 = 0.06};
    m->e.ambient_rgb[0][0] = 0.5;
    m->e.ambient_rgb[0][1] = m->e.ambient_rgb[0][2] = 0.4;
    m->e.ambient_rgb[2][1] = 0.2;
    m->e.ambient_rgb[3][2] = -0.1;
    assert_ok(sheen_texture_init(&m->texture, N_TRIANGLES, EDGE, &err), err);
    assert_ok(sheen_texture_init(&m->truth, N_TRIANGLES, EDGE, &err), err);
    for (size_t t = 0; t < 3 * (size_t)N_TEXELS; t++)
        m->truth.rgb[t] = 0.1f + 0.5f * (float)test_random(&seed);
    for (int v = 0; v < N_VIEWS; v++) {
        assert_ok(sheen_texel_view_init(&m->views[v], N_TRIANGLES, EDGE, &err), err);
        assert_ok(sheen_view_light_init(&m->lights[v], N_TEXELS, &err), err);
        for (size_t t = 0; t < N_TEXELS; t++) {
            float *above = m->lights[v].above_world + 3 * t, room[3] = {0, 0, 0};
            const float p[3] = {0, 0, 0};
            m->views[v].seen[t] = test_random(&seed) < 0.7;
            m->lights[v].cosine[t] = 0.25f + 0.7f * (float)test_random(&seed);
            memset(above, 0, 3 * sizeof *above);
            const int sky = test_random(&seed) < 0.5;
            if (sky) {
                test_direction(above, &seed);
                above[2] = fabsf(above[2]) + 1e-3f;
                sheen_surroundings_radiance(room, &m->e, p, above);
            }
            const float F = sheen_fresnel(m->e.f0, m->lights[v].cosine[t]);
            for (size_t c = 0; c < 3; c++) {
                m->lights[v].lights_rgb[3 * t + c] = test_random(&seed) < 0.05 ? 0.4f : 0;
                m->lights[v].mirrored_rgb[3 * t + c] = sky ? 0 : (float)test_random(&seed);
                m->views[v].rgb[3 * t + c] = m->truth.rgb[3 * t + c] + m->lights[v].lights_rgb[3 * t + c] +
                                             F * (m->lights[v].mirrored_rgb[3 * t + c] + room[c]) +
                                             (float)(noise * test_random_normal(&seed));
            }
            if (spoiled && test_random(&seed) < 0.04) // a highlight that nobody predicted
                for (size_t c = 0; c < 3; c++)
                    m->views[v].rgb[3 * t + c] += 0.5f;
        }
    }
}

static void release(made *m)
{
    for (int v = 0; v < N_VIEWS; v++) {
        sheen_texel_view_release(&m->views[v]);
        sheen_view_light_release(&m->lights[v]);
    }
    sheen_texture_release(&m->texture);
    sheen_texture_release(&m->truth);
}

static double median_error(const made *m)
{
    static double e[N_TEXELS];
    for (size_t t = 0; t < N_TEXELS; t++)
        e[t] = fabs((double)sheen_luminance(m->texture.rgb + 3 * t) -
                    (double)sheen_luminance(m->truth.rgb + 3 * t));
    double least = 0, most = 1; // bisection on how many lie below
    for (int i = 0; i < 40; i++) {
        const double mid = (least + most) / 2;
        size_t below = 0;
        for (size_t t = 0; t < N_TEXELS; t++)
            below += e[t] < mid;
        if (below > N_TEXELS / 2)
            most = mid;
        else
            least = mid;
    }
    return most;
}

static void finds_what_was_put_in(void **state)
{
    (void)state;
    for (int spoiled = 0; spoiled < 2; spoiled++) {
        made m;
        make(&m, 0.003, spoiled);
        const sheen_surroundings truth = m.e;
        m.e = (sheen_surroundings){.present = 1, .f0 = 0.04};
        sheen_surroundings_fit(&m.e, 1, m.views, m.lights, N_VIEWS, 0);
        sheen_diffuse_fit(&m.texture, NULL, &m.e, m.views, m.lights, N_VIEWS, 2);
        print_message("F0 %.4f (0.06), room %.3f %.3f %.3f (0.5 0.4 0.4), texture within %.4f (median)\n",
                      m.e.f0, m.e.ambient_rgb[0][0], m.e.ambient_rgb[0][1], m.e.ambient_rgb[0][2],
                      median_error(&m));
        assert_close(m.e.f0, truth.f0, 0.006);
        for (int c = 0; c < 3; c++)
            assert_close(m.e.ambient_rgb[0][c], truth.ambient_rgb[0][c], 0.06);
        assert_true(median_error(&m) < 0.004);
        release(&m);
    }
}

// Texels say how wrong they are; one that a single photograph sees says that it does not know.
static void deviations_cover_the_errors(void **state)
{
    (void)state;
    made m;
    static float deviation[N_TEXELS];
    size_t n = 0, beyond = 0, one = 0;
    make(&m, 0.01, 1);
    for (size_t t = 0; t < 10; t++)
        for (int v = 0; v < N_VIEWS; v++)
            m.views[v].seen[t] = v == 2;
    sheen_diffuse_fit(&m.texture, deviation, &m.e, m.views, m.lights, N_VIEWS, 2);
    for (size_t t = 0; t < N_TEXELS; t++) {
        const double error = fabs((double)sheen_luminance(m.texture.rgb + 3 * t) -
                                  (double)sheen_luminance(m.truth.rgb + 3 * t));
        one += t < 10 && isnan(deviation[t]);
        if (isnan(deviation[t]))
            continue;
        n++;
        beyond += error > 3 * (double)deviation[t];
    }
    print_message("%zu of %zu texels beyond 3 deviations\n", beyond, n);
    assert_int_equal(one, 10);
    assert_true(n > N_TEXELS / 2 && beyond < n / 30);
    release(&m);
}

static void threads_do_not_change_the_texture(void **state)
{
    (void)state;
    made m;
    make(&m, 0.003, 1);
    sheen_diffuse_fit(&m.texture, NULL, &m.e, m.views, m.lights, N_VIEWS, 1);
    float *first = malloc(3 * N_TEXELS * sizeof *first);
    assert_non_null(first);
    memcpy(first, m.texture.rgb, 3 * N_TEXELS * sizeof *first);
    sheen_diffuse_fit(&m.texture, NULL, &m.e, m.views, m.lights, N_VIEWS, 3);
    assert_memory_equal(first, m.texture.rgb, 3 * N_TEXELS * sizeof *first);
    free(first);
    release(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_what_was_put_in),
        cmocka_unit_test(deviations_cover_the_errors),
        cmocka_unit_test(threads_do_not_change_the_texture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
