// SPDX-License-Identifier: Apache-2.0
// test_gbuffer.c - what a camera sees, against a plain ray tracer, pixel by pixel.
#include "render/gbuffer.h"
#include "tests/support.h"
#include "tests/support_scene.h"

#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"

typedef struct world {
    sheen_mesh mesh;
    sheen_scene *scene;
    sheen_camera cam;
    double rt_cam_obj[6];
} world;

static void make_world(world *w, int distorted)
{
    sheen_err err = {0};
    test_figure(&w->mesh, 4, 0.1f, 0.04f);
    assert_ok(sheen_scene_new(&w->scene, &w->mesh, &err), err);
    test_camera(&w->cam, 80, 60, 90, distorted);
    test_look(w->rt_cam_obj, 0.3, 0.2, 0.25);
}

static void free_world(world *w)
{
    sheen_scene_free(&w->scene);
    sheen_mesh_release(&w->mesh);
}

static void make(sheen_gbuffer *g, const world *w, int samples, int n_threads)
{
    sheen_err err = {0};
    assert_ok(sheen_gbuffer_make(g, w->scene, &w->mesh, &w->cam, w->rt_cam_obj, samples, n_threads, &err),
              err);
}

// The sample that covers a place of the image, NULL outside the window.
static const sheen_hit *sample_at(const sheen_gbuffer *g, int sx, int sy)
{
    const int n = g->samples_per_side, x = sx - g->x0_px * n, y = sy - g->y0_px * n;
    if (x < 0 || y < 0 || x >= g->width_px * n || y >= g->height_px * n)
        return NULL;
    return g->hits + (size_t)y * (size_t)(g->width_px * n) + (size_t)x;
}

static void compare_with_brute_force(int distorted, int n)
{
    world w;
    make_world(&w, distorted);
    sheen_gbuffer g;
    make(&g, &w, n, 1);
    sheen_Rt Rt_cam_obj, Rt_obj_cam;
    sheen_Rt_from_rt(&Rt_cam_obj, w.rt_cam_obj);
    sheen_Rt_invert(&Rt_obj_cam, &Rt_cam_obj);
    size_t n_hits = 0, n_off = 0;
    for (int sy = 0; sy < w.cam.height_px * n; sy++)
        for (int sx = 0; sx < w.cam.width_px * n; sx++) {
            const double q_px[2] = {(sx + 0.5) / n - 0.5, (sy + 0.5) / n - 0.5};
            double v[3];
            assert_int_equal(sheen_camera_unproject(&w.cam, v, q_px, 1, NULL), SHEEN_OK);
            sheen_Rt_direction(v, &Rt_obj_cam, v);
            const sheen_hit want = test_first_hit(&w.mesh, Rt_obj_cam.t, v);
            const sheen_hit *got = sample_at(&g, sx, sy);
            n_hits += want.triangle != SHEEN_NO_HIT;
            if ((got ? got->triangle : SHEEN_NO_HIT) != want.triangle)
                n_off++; // edges
            else if (want.triangle != SHEEN_NO_HIT)
                assert_close(got->t_m, want.t_m,
                             1e-4); // near the outline the surface runs away from the camera
        }
    assert_true(n_hits > 500);
    assert_in_range(n_off, 0, 1 + n_hits / 500);
    for (int k = 0; k < 3; k++)
        assert_close(g.p_camera_obj[k], Rt_obj_cam.t[k], 1e-12);
    sheen_gbuffer_release(&g);
    free_world(&w);
}

static void pinhole_agrees_with_brute_force(void **state)
{
    (void)state;
    compare_with_brute_force(0, 1);
    compare_with_brute_force(0, 2);
}

static void lens_agrees_with_brute_force(void **state)
{
    (void)state;
    compare_with_brute_force(1, 1);
    compare_with_brute_force(1, 3);
}

// A pinhole's picture is drawn triangle by triangle: no hole between triangles, and what rays say but on edges.
static void drawn_agrees_with_traced(const world *w, int samples)
{
    sheen_gbuffer drawn, traced;
    sheen_err err = {0};
    make(&drawn, w, samples, 1);
    assert_ok(sheen_gbuffer_make_ref(&traced, w->scene, &w->mesh, &w->cam, w->rt_cam_obj, samples, 1, &err),
              err);
    assert_int_equal(drawn.width_px, traced.width_px);
    assert_int_equal(drawn.height_px, traced.height_px);
    const size_t n = (size_t)(drawn.width_px * samples) * (size_t)(drawn.height_px * samples);
    size_t n_hits = 0, n_other = 0, n_holes = 0;
    for (size_t i = 0; i < n; i++) {
        const sheen_hit *got = drawn.hits + i, *want = traced.hits + i;
        n_hits += want->triangle != SHEEN_NO_HIT;
        n_holes += (got->triangle == SHEEN_NO_HIT) != (want->triangle == SHEEN_NO_HIT);
        n_other += got->triangle != want->triangle;
        if (got->triangle != want->triangle || want->triangle == SHEEN_NO_HIT)
            continue;
        float p[3], q[3], v[3], off[3];
        sheen_hit_surface(&w->mesh, got, drawn.p_camera_obj, p, NULL, v);
        sheen_hit_surface(&w->mesh, want, drawn.p_camera_obj, q, NULL, NULL);
        sheen_subf(off, p, q);
        const float along = sheen_dotf(off, v); // large where the surface runs along the ray
        assert_close(along, 0, 2e-4);
        assert_close(sqrtf(fmaxf(0, sheen_dotf(off, off) - along * along)), 0, 1e-5); // 3e-3 px here
        assert_close(got->t_m, want->t_m, 2e-4);
    }
    assert_true(n_hits > n / 8);
    assert_in_range(n_holes, 0, 3 + n_hits / 20000); // on the outline
    assert_in_range(n_other, 0, 3 + n_hits / 500);   // on edges
    sheen_gbuffer_release(&drawn);
    sheen_gbuffer_release(&traced);
}

static void drawing_and_tracing_agree(void **state)
{
    (void)state;
    sheen_err err = {0};
    world w;
    make_world(&w, 0);
    drawn_agrees_with_traced(&w, 1);
    drawn_agrees_with_traced(&w, 4);
    test_look(w.rt_cam_obj, 0.13, 0.05, 0.05); // close: triangles run out of the picture
    drawn_agrees_with_traced(&w, 3);
    free_world(&w);

    // Thousands of triangles of a few samples each, and a bowl whose inside is seen.
    test_figure(&w.mesh, 30, 0.1f, 0.03f);
    assert_ok(sheen_scene_new(&w.scene, &w.mesh, &err), err);
    test_camera(&w.cam, 320, 240, 450, 0);
    test_look(w.rt_cam_obj, -0.2, 0.25, 0.2);
    drawn_agrees_with_traced(&w, 1);
    sheen_scene_free(&w.scene);
    size_t n = 0;
    for (size_t t = 0; t < w.mesh.n_triangles; t++)
        if (w.mesh.p_obj[3 * (size_t)w.mesh.triangles[3 * t] + 2] < 0) {
            memmove(w.mesh.triangles + 3 * n, w.mesh.triangles + 3 * t, 3 * sizeof *w.mesh.triangles);
            n++;
        }
    w.mesh.n_triangles = n;
    assert_ok(sheen_scene_new(&w.scene, &w.mesh, &err), err);
    drawn_agrees_with_traced(&w, 2);
    for (size_t t = 0; t < n;
         t += 2) { // half of them turned over: what faces away hides as well as is hidden
        uint32_t *corner = w.mesh.triangles + 3 * t, first = corner[0];
        corner[0] = corner[1];
        corner[1] = first;
    }
    sheen_scene_free(&w.scene);
    assert_ok(sheen_scene_new(&w.scene, &w.mesh, &err), err);
    drawn_agrees_with_traced(&w, 2);
    free_world(&w);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    for (int distorted = 0; distorted < 2; distorted++) {
        world w;
        make_world(&w, distorted);
        sheen_gbuffer one, four;
        make(&one, &w, 2, 1);
        make(&four, &w, 2, 4);
        assert_int_equal(one.width_px, four.width_px);
        assert_memory_equal(one.hits, four.hits,
                            (size_t)(4 * one.width_px * one.height_px) * sizeof *one.hits);
        sheen_gbuffer_release(&one);
        sheen_gbuffer_release(&four);
        free_world(&w);
    }
}

// A point that is seen lies where its pixel says: project(surface) = sample, to a fraction of the float's
// step.
static void compare_projection(int distorted)
{
    world w;
    make_world(&w, distorted);
    sheen_gbuffer g;
    make(&g, &w, 2, 0);
    sheen_Rt Rt_cam_obj;
    sheen_Rt_from_rt(&Rt_cam_obj, w.rt_cam_obj);
    size_t n = 0;
    for (int sy = 0; sy < w.cam.height_px * 2; sy++)
        for (int sx = 0; sx < w.cam.width_px * 2; sx++) {
            const sheen_hit *hit = sample_at(&g, sx, sy);
            if (!hit || hit->triangle == SHEEN_NO_HIT)
                continue;
            float p[3], normal[3], v[3];
            sheen_hit_surface(&w.mesh, hit, g.p_camera_obj, p, normal, v);
            double p_cam[3] = {(double)p[0], (double)p[1], (double)p[2]}, q[2];
            sheen_Rt_point(p_cam, &Rt_cam_obj, p_cam);
            assert_int_equal(sheen_camera_project(&w.cam, q, NULL, p_cam, 1, NULL), SHEEN_OK);
            assert_close(q[0], (sx + 0.5) / 2 - 0.5, 2e-3);
            assert_close(q[1], (sy + 0.5) / 2 - 0.5, 2e-3);
            assert_close(sheen_dotf(normal, normal), 1, 1e-6);
            float toward[3];
            for (int k = 0; k < 3; k++)
                toward[k] = (float)(g.p_camera_obj[k] - (double)p[k]);
            assert_close(sheen_normalizef(toward), hit->t_m, 4e-6);
            assert_close(sheen_dotf(toward, v), 1, 1e-6);
            n++;
        }
    assert_true(n > 1500);
    sheen_gbuffer_release(&g);
    free_world(&w);
}

static void surface_projects_onto_its_sample(void **state)
{
    (void)state;
    compare_projection(0);
    compare_projection(1);
}

static size_t count_hits(const sheen_gbuffer *g)
{
    size_t n = 0;
    const int s = g->samples_per_side;
    for (size_t i = 0; i < (size_t)(g->width_px * s) * (size_t)(g->height_px * s); i++)
        n += g->hits[i].triangle != SHEEN_NO_HIT;
    return n;
}

static void out_of_view_is_empty(void **state)
{
    (void)state;
    world w;
    make_world(&w, 0);
    sheen_gbuffer g;
    test_look(w.rt_cam_obj, 0.3, 0, 0);
    w.rt_cam_obj[5] = -0.3; // behind the camera
    make(&g, &w, 1, 0);
    assert_int_equal(g.width_px, 0);
    assert_int_equal(g.height_px, 0);
    sheen_gbuffer_release(&g);
    test_look(w.rt_cam_obj, 0.3, 0, 0);
    w.rt_cam_obj[3] = 2; // far to the right
    make(&g, &w, 1, 0);
    assert_int_equal(g.width_px, 0);
    sheen_gbuffer_release(&g);
    free_world(&w);
}

// From inside the figure all is object, though half of the vertices are behind the camera.
static void camera_inside_the_mesh(void **state)
{
    (void)state;
    world w;
    make_world(&w, 1);
    sheen_gbuffer g;
    test_look(w.rt_cam_obj, 0.01, 0, 0.005);
    make(&g, &w, 1, 0);
    assert_int_equal(g.width_px, w.cam.width_px);
    assert_int_equal(g.height_px, w.cam.height_px);
    assert_int_equal(count_hits(&g), w.cam.width_px * w.cam.height_px);
    sheen_gbuffer_release(&g);
    free_world(&w);
}

// One large triangle through a bent lens: its sides bulge out of the box of its corners, and must not be cut
// off.
static void window_holds_bent_sides(void **state)
{
    (void)state;
    static const float big[9] = {-0.13f, -0.09f, 0, 0.13f, -0.09f, 0, 0, 0.1f, 0};
    sheen_err err = {0};
    world w;
    test_triangles(&w.mesh, big, 1);
    assert_ok(sheen_scene_new(&w.scene, &w.mesh, &err), err);
    static const double distortion[4] = {-0.2, 0, 0, 0}, fxycxy[4] = {270, 270, 150, 120};
    assert_ok(sheen_camera_opencv(&w.cam, 300, 240, fxycxy, distortion, 4, &err), err);
    test_look(w.rt_cam_obj, 0, 1e-4, 0.25);
    sheen_gbuffer g;
    make(&g, &w, 1, 0);
    const size_t n = count_hits(&g);
    sheen_gbuffer_release(&g);
    size_t want = 0;
    sheen_Rt Rt_cam_obj, Rt_obj_cam;
    sheen_Rt_from_rt(&Rt_cam_obj, w.rt_cam_obj);
    sheen_Rt_invert(&Rt_obj_cam, &Rt_cam_obj);
    for (int i = 0; i < 300 * 240; i++) {
        const double q_px[2] = {i % 300, i / 300};
        double v[3];
        assert_int_equal(sheen_camera_unproject(&w.cam, v, q_px, 1, NULL), SHEEN_OK);
        sheen_Rt_direction(v, &Rt_obj_cam, v);
        want += test_first_hit(&w.mesh, Rt_obj_cam.t, v).triangle != SHEEN_NO_HIT;
    }
    assert_true(want > 1000);
    assert_close(n, want, 8); // of some 27,000, along the sides
    free_world(&w);
}

static void says_what_is_wrong(void **state)
{
    (void)state;
    world w;
    make_world(&w, 0);
    sheen_gbuffer g;
    sheen_err err = {0};
    assert_fails(sheen_gbuffer_make(&g, w.scene, &w.mesh, &w.cam, w.rt_cam_obj, 0, 1, &err), err, SHEEN_EARG,
                 "0 samples");
    w.rt_cam_obj[4] = (double)NAN;
    assert_fails(sheen_gbuffer_make(&g, w.scene, &w.mesh, &w.cam, w.rt_cam_obj, 1, 1, &err), err, SHEEN_EARG,
                 "not finite");
    sheen_gbuffer_release(&g);
    free_world(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pinhole_agrees_with_brute_force),
        cmocka_unit_test(lens_agrees_with_brute_force),
        cmocka_unit_test(drawing_and_tracing_agree),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(surface_projects_onto_its_sample),
        cmocka_unit_test(out_of_view_is_empty),
        cmocka_unit_test(camera_inside_the_mesh),
        cmocka_unit_test(window_holds_bent_sides),
        cmocka_unit_test(says_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
