// SPDX-License-Identifier: Apache-2.0
// support_scene.c - meshes, cameras and a plain ray tracer for the tests of render and fit.
#include "tests/support_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "tests/support.h"

// The icosahedron's corners are the cyclic permutations of (0, +-1, +-golden); faces are found by distance.
static int icosahedron(double corner[12][3], int face[20][3])
{
    const double golden = (1 + sqrt(5.0)) / 2;
    int n = 0, n_faces = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int sign = 0; sign < 4; sign++, n++) {
            corner[n][axis] = 0;
            corner[n][(axis + 1) % 3] = sign & 1 ? 1 : -1;
            corner[n][(axis + 2) % 3] = sign & 2 ? golden : -golden;
        }
    for (int a = 0; a < 12; a++)
        for (int b = a + 1; b < 12; b++)
            for (int c = b + 1; c < 12; c++) {
                double ab[3], bc[3], ca[3], n_out[3];
                sheen_sub(ab, corner[b], corner[a]);
                sheen_sub(bc, corner[c], corner[b]);
                sheen_sub(ca, corner[a], corner[c]);
                if (sheen_norm(ab) > 2.1 || sheen_norm(bc) > 2.1 || sheen_norm(ca) > 2.1)
                    continue;
                sheen_cross(n_out, ab, bc);
                const int flip = sheen_dot(n_out, corner[a]) < 0; // counter-clockwise from outside
                face[n_faces][0] = a;
                face[n_faces][1] = flip ? c : b;
                face[n_faces++][2] = flip ? b : c;
            }
    return n_faces;
}

static void allocate(sheen_mesh *mesh, size_t n_vertices, size_t n_triangles)
{
    *mesh = (sheen_mesh){.n_vertices = n_vertices, .n_triangles = n_triangles};
    mesh->p_obj = calloc(n_vertices, 3 * sizeof *mesh->p_obj);
    mesh->n_obj = calloc(n_vertices, 3 * sizeof *mesh->n_obj);
    mesh->triangles = calloc(n_triangles, 3 * sizeof *mesh->triangles);
    assert_non_null(mesh->p_obj);
    assert_non_null(mesh->n_obj);
    assert_non_null(mesh->triangles);
}

// Vertices on faces' common sides must be one vertex: they are numbered by where they lie.
static uint32_t vertex_at(sheen_mesh *mesh, uint32_t *slots, size_t n_slots, const float p[3])
{
    uint64_t key = 0;
    for (int k = 0; k < 3; k++)
        key = key * UINT64_C(1000003) + (uint64_t)(int64_t)lrintf((p[k] + 2) * 1e5f);
    for (size_t slot = key % n_slots;; slot = (slot + 1) % n_slots) {
        if (slots[slot] == UINT32_MAX) {
            slots[slot] = (uint32_t)mesh->n_vertices++;
            memcpy(mesh->p_obj + 3 * (size_t)slots[slot], p, 3 * sizeof *p);
            return slots[slot];
        }
        float d[3];
        sheen_subf(d, p, mesh->p_obj + 3 * (size_t)slots[slot]);
        if (sheen_dotf(d, d) < 1e-10f)
            return slots[slot];
    }
}

static void add_face(sheen_mesh *mesh, uint32_t *slots, size_t n_slots, double corner[12][3],
                     const int face[3], int f)
{
    uint32_t previous[512], current[512];
    assert_true(f < 512);
    for (int j = 0; j <= f; j++) {
        for (int i = 0; i + j <= f; i++) {
            double p[3];
            for (int k = 0; k < 3; k++)
                p[k] = corner[face[0]][k] * (f - i - j) + corner[face[1]][k] * i + corner[face[2]][k] * j;
            sheen_normalize(p);
            const float unit[3] = {(float)p[0], (float)p[1], (float)p[2]};
            current[i] = vertex_at(mesh, slots, n_slots, unit);
        }
        for (int i = 0; j && i + j <= f; i++) {
            const uint32_t upright[3] = {previous[i], previous[i + 1], current[i]};
            memcpy(mesh->triangles + 3 * mesh->n_triangles++, upright, sizeof upright);
            if (i + j < f) {
                const uint32_t turned[3] = {previous[i + 1], current[i + 1], current[i]};
                memcpy(mesh->triangles + 3 * mesh->n_triangles++, turned, sizeof turned);
            }
        }
        memcpy(previous, current, sizeof previous);
    }
}

static void unit_sphere(sheen_mesh *mesh, int frequency)
{
    const size_t n_triangles = 20 * (size_t)frequency * (size_t)frequency, n_vertices = n_triangles / 2 + 2;
    double corner[12][3];
    int face[20][3];
    assert_int_equal(icosahedron(corner, face), 20);
    allocate(mesh, n_vertices + 1, n_triangles);
    mesh->n_vertices = mesh->n_triangles = 0;
    const size_t n_slots = 4 * n_vertices;
    uint32_t *slots = malloc(n_slots * sizeof *slots);
    assert_non_null(slots);
    memset(slots, 0xff, n_slots * sizeof *slots);
    for (int t = 0; t < 20; t++)
        add_face(mesh, slots, n_slots, corner, face[t], frequency);
    free(slots);
    assert_int_equal(mesh->n_vertices, n_vertices);
    assert_int_equal(mesh->n_triangles, n_triangles);
}

void test_sphere(sheen_mesh *mesh, int frequency, const float centre_obj[3], float radius_m)
{
    unit_sphere(mesh, frequency);
    memcpy(mesh->n_obj, mesh->p_obj, mesh->n_vertices * 3 * sizeof *mesh->p_obj);
    for (size_t i = 0; i < 3 * mesh->n_vertices; i++)
        mesh->p_obj[i] = centre_obj[i % 3] + radius_m * mesh->p_obj[i];
}

// Normals by area, here and not by the function under test elsewhere.
static void normals_of(sheen_mesh *mesh)
{
    memset(mesh->n_obj, 0, mesh->n_vertices * 3 * sizeof *mesh->n_obj);
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *corner = mesh->triangles + 3 * t;
        float a[3], b[3], n[3];
        sheen_subf(a, mesh->p_obj + 3 * (size_t)corner[1], mesh->p_obj + 3 * (size_t)corner[0]);
        sheen_subf(b, mesh->p_obj + 3 * (size_t)corner[2], mesh->p_obj + 3 * (size_t)corner[0]);
        sheen_crossf(n, a, b);
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++)
                mesh->n_obj[3 * (size_t)corner[c] + (size_t)k] += n[k];
    }
    for (size_t i = 0; i < mesh->n_vertices; i++)
        sheen_normalizef(mesh->n_obj + 3 * i);
}

void test_figure(sheen_mesh *mesh, int frequency, float radius_m, float bump_m)
{
    unit_sphere(mesh, frequency);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        float *p = mesh->p_obj + 3 * i;
        const float wave = sinf(4 * p[0] + 1) * sinf(5 * p[1] - 2) + 0.5f * sinf(7 * p[2] + 3 * p[0]);
        const float r = radius_m + bump_m * wave / 1.5f;
        for (int k = 0; k < 3; k++)
            p[k] *= r;
    }
    normals_of(mesh);
}

void test_triangles(sheen_mesh *mesh, const float *corners_obj, size_t n_triangles)
{
    allocate(mesh, 3 * n_triangles, n_triangles);
    memcpy(mesh->p_obj, corners_obj, 9 * n_triangles * sizeof *corners_obj);
    for (size_t i = 0; i < 3 * n_triangles; i++)
        mesh->triangles[i] = (uint32_t)i;
    normals_of(mesh);
}

void test_camera(sheen_camera *cam, int width_px, int height_px, double f_px, int distorted)
{
    static const double distortion[5] = {-0.12, 0.05, 0.0008, -0.0006, 0.01};
    const double fxycxy[4] = {f_px, f_px * 1.001, 0.5 * width_px + 3.2, 0.5 * height_px - 4.7};
    sheen_err err = {0};
    assert_ok(sheen_camera_opencv(cam, width_px, height_px, fxycxy, distorted ? distortion : NULL,
                                  distorted ? 5 : 0, &err),
              err);
}

void test_look(double rt_cam_obj[6], double x_m, double y_m, double z_m)
{
    const double up[3] = {0, 0, 1}, from[3] = {x_m, y_m, z_m};
    double forward[3] = {-x_m, -y_m, -z_m}, right[3], down[3];
    sheen_normalize(forward);
    sheen_cross(right, forward, up);
    sheen_normalize(right);
    sheen_cross(down, forward, right);
    sheen_Rt Rt;
    for (int k = 0; k < 3; k++) {
        Rt.R[0][k] = right[k];
        Rt.R[1][k] = down[k];
        Rt.R[2][k] = forward[k];
    }
    Rt.t[0] = -sheen_dot(right, from);
    Rt.t[1] = -sheen_dot(down, from);
    Rt.t[2] = -sheen_dot(forward, from);
    sheen_rt_from_Rt(rt_cam_obj, &Rt);
}

sheen_hit test_first_hit(const sheen_mesh *mesh, const double origin_obj[3], const double v_obj[3])
{
    sheen_hit hit = {.triangle = SHEEN_NO_HIT};
    double nearest_m = HUGE_VAL;
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        double p[3][3], e1[3], e2[3], s[3], h[3], q[3];
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++)
                p[c][k] = (double)mesh->p_obj[3 * (size_t)mesh->triangles[3 * t + (size_t)c] + (size_t)k];
        sheen_sub(e1, p[1], p[0]);
        sheen_sub(e2, p[2], p[0]);
        sheen_cross(h, v_obj, e2);
        const double det = sheen_dot(e1, h);
        if (det == 0)
            continue;
        sheen_sub(s, origin_obj, p[0]);
        sheen_cross(q, s, e1);
        const double b1 = sheen_dot(s, h) / det, b2 = sheen_dot(v_obj, q) / det, t_m = sheen_dot(e2, q) / det;
        if (b1 < 0 || b2 < 0 || b1 + b2 > 1 || t_m <= 0 || t_m >= nearest_m)
            continue;
        nearest_m = t_m;
        hit = (sheen_hit){.triangle = (uint32_t)t, .b1 = (float)b1, .b2 = (float)b2, .t_m = (float)t_m};
    }
    return hit;
}

void test_direction(float v[3], uint64_t *seed)
{
    do
        for (int k = 0; k < 3; k++)
            v[k] = (float)test_random_normal(seed);
    while (sheen_dotf(v, v) < 1e-3f);
    sheen_normalizef(v);
}
