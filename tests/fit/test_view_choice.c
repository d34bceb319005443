// SPDX-License-Identifier: Apache-2.0
// test_view_choice.c - never more photographs a triangle than asked, all of them where they are few, in any order the same.
#include <stdlib.h>
#include <string.h>

#include "fit/view_choice.h"
#include "support.h"
#include "support_scene.h"

enum { N_VIEWS = 50, MOST = 7 };

static void make_cameras(double (*cameras)[3], sheen_mesh *mesh)
{
    const float centre[3] = {0, 0, 0};
    uint64_t seed = 3;
    test_sphere(mesh, 6, centre, 0.1f);
    for (int v = 0; v < N_VIEWS; v++) {
        float d[3];
        test_direction(d, &seed);
        for (int k = 0; k < 3; k++)
            cameras[v][k] = 0.5 * (double)d[k];
    }
}

// As if every camera saw every texel of every triangle.
static void see_all(sheen_texel_view *v, const sheen_mesh *mesh)
{
    sheen_err err;
    assert_ok(sheen_texel_view_init(v, mesh->n_triangles, 2, &err), err);
    memset(v->seen, 1, v->n_texels);
}

static void few_remain_and_the_same_in_any_order(void **state)
{
    (void)state;
    double cameras[N_VIEWS][3], backwards[N_VIEWS][3];
    sheen_mesh mesh;
    sheen_view_choice a, b;
    sheen_err err;
    make_cameras(cameras, &mesh);
    for (int v = 0; v < N_VIEWS; v++)
        memcpy(backwards[v], cameras[N_VIEWS - 1 - v], sizeof backwards[v]);
    assert_ok(sheen_view_choice_make(&a, &mesh, (const double(*)[3])cameras, N_VIEWS, MOST, 1, &err), err);
    assert_ok(sheen_view_choice_make(&b, &mesh, (const double(*)[3])backwards, N_VIEWS, MOST, 2, &err), err);
    assert_memory_equal(a.highest, b.highest, mesh.n_triangles * sizeof *a.highest);
    int *n_seen = calloc(mesh.n_triangles, sizeof *n_seen);
    assert_non_null(n_seen);
    for (int v = 0; v < N_VIEWS; v++) {
        sheen_texel_view view;
        see_all(&view, &mesh);
        sheen_view_choice_apply(&a, &view, cameras[v]);
        for (size_t f = 0; f < mesh.n_triangles; f++) {
            float to[3];
            const float *p = mesh.p_obj + 3 * (size_t)mesh.triangles[3 * f], *n = p - mesh.p_obj + mesh.n_obj;
            for (int k = 0; k < 3; k++)
                to[k] = (float)cameras[v][k] - p[k];
            n_seen[f] += view.seen[3 * f] && n[0] * to[0] + n[1] * to[1] + n[2] * to[2] > 0;
        }
        sheen_texel_view_release(&view);
    }
    for (size_t f = 0; f < mesh.n_triangles; f++)
        assert_in_range(n_seen[f], MOST / 2, MOST); // some face it with another corner only
    free(n_seen);
    sheen_view_choice_release(&a);
    sheen_view_choice_release(&b);
    sheen_mesh_release(&mesh);
}

static void all_remain_where_they_are_few(void **state)
{
    (void)state;
    double cameras[N_VIEWS][3];
    sheen_mesh mesh;
    sheen_view_choice c;
    sheen_texel_view view;
    sheen_err err;
    make_cameras(cameras, &mesh);
    assert_ok(sheen_view_choice_make(&c, &mesh, (const double(*)[3])cameras, MOST, MOST, 1, &err), err);
    see_all(&view, &mesh);
    sheen_view_choice_apply(&c, &view, cameras[0]);
    assert_null(memchr(view.seen, 0, view.n_texels));
    sheen_texel_view_release(&view);
    sheen_view_choice_release(&c);
    sheen_mesh_release(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_remain_and_the_same_in_any_order),
        cmocka_unit_test(all_remain_where_they_are_few),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
