// SPDX-License-Identifier: Apache-2.0
// test_mesh.c - meshes: every format's variants, normals, bounds, and files that are broken or lie.
#include "tests/base/damaged_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/mesh.h"

#define CORPUS TEST_CORPUS

// The tetrahedron of the corpora: the origin and a unit along each axis, turned outwards.
static const float tetrahedron_p[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const uint32_t tetrahedron_t[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

static void assert_tetrahedron(const sheen_mesh *mesh)
{
    assert_int_equal(mesh->n_vertices, 4);
    assert_int_equal(mesh->n_triangles, 4);
    assert_memory_equal(mesh->p_obj, tetrahedron_p, sizeof tetrahedron_p);
    assert_memory_equal(mesh->triangles, tetrahedron_t, sizeof tetrahedron_t);
    // three faces of area 1/2 look along -x, -y, -z at the origin
    for (int c = 0; c < 3; c++)
        assert_close(mesh->n_obj[c], -sqrt(1.0 / 3), 1e-6);
    // at (1, 0, 0): -z/2, -y/2 and (1, 1, 1)/2 add up to (1, 0, 0)/2
    assert_close(mesh->n_obj[3], 1, 1e-6);
    assert_close(mesh->n_obj[4], 0, 1e-6);
}

static void reads_the_same_from_every_format(void **state)
{
    (void)state;
    static const char *const paths[] = {CORPUS "ply/ascii.ply",       CORPUS "ply/little-endian.ply",
                                        CORPUS "ply/crlf.ply",        CORPUS "ply/big-endian-double.ply",
                                        CORPUS "obj/tetrahedron.obj", CORPUS "glb/indices-u8.glb",
                                        CORPUS "glb/indices-u16.glb", CORPUS "glb/indices-u32.glb",
                                        CORPUS "glb/no-scenes.glb"};
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        sheen_err err;
        sheen_mesh mesh;
        assert_ok(sheen_mesh_load(&mesh, paths[i], &err), err);
        assert_tetrahedron(&mesh);
        sheen_mesh_release(&mesh);
    }
}

static sheen_mesh parse_text(const char *text, const char *name)
{
    sheen_err err;
    sheen_mesh mesh;
    assert_ok(sheen_mesh_parse(&mesh, text, strlen(text), name, &err), err);
    return mesh;
}

static void polygons_become_fans_and_colours_are_skipped(void **state)
{
    (void)state;
    sheen_mesh mesh = parse_text(
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty uchar red\n"
        "property float y\nproperty float z\nproperty float nx\nproperty float ny\n"
        "property float nz\nelement face 2\nproperty uchar flags\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 255 0 0 0 0 2\n1 7 0 0 0 nan 1\n1 0 1 0 0 3 4\n0 0 1 0 1 0 0\n9 9 9 9 0 0 0\n"
        "1 4 0 1 2 3\n2 3 1 1 2\n",
        NULL);
    static const uint32_t want[] = {0, 1, 2, 0, 2, 3}; // the second face repeats a vertex: dropped
    assert_int_equal(mesh.n_vertices, 5);              // the unused one stays
    assert_int_equal(mesh.n_triangles, 2);
    assert_memory_equal(mesh.triangles, want, sizeof want);
    assert_close(mesh.n_obj[2], 1, 0);        // made a unit
    assert_close(mesh.n_obj[3 + 2], 1, 1e-6); // nan: found from the triangles
    assert_close(mesh.n_obj[6 + 1], 0.6, 1e-6);
    assert_close(mesh.n_obj[6 + 2], 0.8, 1e-6);
    assert_close(mesh.n_obj[12 + 2], 1, 0); // no normal and no triangle: +z
    sheen_mesh_release(&mesh);
}

static void obj_corners_with_two_normals_repeat_the_vertex(void **state)
{
    (void)state;
    sheen_mesh mesh = parse_text(
        "# a folded sheet\nv 0 0 0\nv 0 1 0\nv 1 0 0\nv 0 0 1\nvt 0 0\nvn 0 0 -5\nvn -1 0 0\n"
        "f 1/1/1 2/1/1 3/1/1\nf 1//2 4//2 2//2\n",
        "SHEET.OBJ");
    assert_int_equal(mesh.n_vertices, 6); // 1 and 2 lie on the fold
    static const uint32_t want[] = {0, 1, 2, 4, 3, 5};
    assert_memory_equal(mesh.triangles, want, sizeof want);
    assert_close(mesh.n_obj[2], -1, 0);
    assert_close(mesh.n_obj[3 * 4], -1, 0);
    assert_memory_equal(mesh.p_obj + 3 * 5, mesh.p_obj + 3 * 1, 3 * sizeof(float));
    sheen_mesh_release(&mesh);

    mesh = parse_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 5 5 5\nf 4 1 2\n", "a.obj");
    static const uint32_t relative[] = {0, 1, 2, 3, 0, 1};
    assert_memory_equal(mesh.triangles, relative, sizeof relative);
    sheen_mesh_release(&mesh);
}

// Node 1: scaled by 2, turned by 90 degrees about z, moved. Node 2: mirrored in x, at x = 2 * 5 + 1.
static void glb_nodes_place_and_mirror(void **state)
{
    (void)state;
    sheen_err err;
    sheen_mesh mesh;
    assert_ok(sheen_mesh_load(&mesh, CORPUS "glb/transforms.glb", &err), err);
    assert_int_equal(mesh.n_vertices, 8);
    assert_int_equal(mesh.n_triangles, 8);
    int n_found = 0;
    for (size_t i = 0; i < 8; i++) {
        const float *p = mesh.p_obj + 3 * i;
        // (1, 0, 0) of each: R gives (0, 1, 0), doubled and moved by (1, 2, 3); the mirror gives (-1 + 5, 0, 0)
        n_found += fabsf(p[0] - 1) < 1e-5f && fabsf(p[1] - 4) < 1e-5f && fabsf(p[2] - 3) < 1e-5f;
        n_found += fabsf(p[0] - 9) < 1e-5f && fabsf(p[1] - 2) < 1e-5f && fabsf(p[2] - 3) < 1e-5f;
    }
    assert_int_equal(n_found, 2);
    // both are still turned outwards: the volume by the divergence theorem is 8/6 each
    double volume = 0;
    for (size_t i = 0; i < mesh.n_triangles; i++) {
        const float *a = mesh.p_obj + 3 * mesh.triangles[3 * i],
                    *b = mesh.p_obj + 3 * mesh.triangles[3 * i + 1];
        const float *c = mesh.p_obj + 3 * mesh.triangles[3 * i + 2];
        volume += (double)(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                           a[2] * (b[0] * c[1] - b[1] * c[0])) /
                  6;
    }
    assert_close(volume, 2 * 8.0 / 6, 1e-4);
    sheen_mesh_release(&mesh);
}

static void glb_strips_fans_and_normals(void **state)
{
    (void)state;
    sheen_err err;
    sheen_mesh mesh;
    assert_ok(sheen_mesh_load(&mesh, CORPUS "glb/strip.glb", &err), err);
    static const uint32_t strip[] = {0, 1, 2, 1, 3, 2}; // glTF 2.0, 3.7.2.1: every second one turned
    assert_memory_equal(mesh.triangles, strip, sizeof strip);
    sheen_mesh_release(&mesh);
    assert_ok(sheen_mesh_load(&mesh, CORPUS "glb/fan.glb", &err), err);
    static const uint32_t fan[] = {1, 2, 0, 2, 3, 0};
    assert_memory_equal(mesh.triangles, fan, sizeof fan);
    sheen_mesh_release(&mesh);
    size_t size_bytes; // as it is in the file, not mended
    uint8_t *file = test_file_read(CORPUS "glb/normals.glb", &size_bytes);
    assert_ok(sheen_mesh_parse(&mesh, file, size_bytes, "normals.glb", &err), err);
    free(file);
    for (int i = 0; i < 4; i++)
        assert_close(mesh.n_obj[3 * i + 2], 1, 0); // (0, 0, 2) in the file
    sheen_mesh_release(&mesh);
}

static void saved_ply_reads_back_exactly(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "a.ply");
    sheen_err err;
    sheen_mesh mesh, back;
    assert_ok(sheen_mesh_load(&mesh, CORPUS "obj/tetrahedron.obj", &err), err);
    assert_ok(sheen_mesh_save_ply(&mesh, path, &err), err);
    assert_ok(sheen_mesh_load(&back, path, &err), err);
    assert_tetrahedron(&back);
    for (int i = 0; i < 12; i++)
        assert_close(back.n_obj[i], mesh.n_obj[i], 1e-7);
    sheen_mesh_release(&back);
    sheen_mesh_release(&mesh);
}

static void bounds_and_sphere_hold_all(void **state)
{
    (void)state;
    sheen_mesh mesh = parse_text("v -1 0 2\nv 3 0 2\nv 1 4 4\nf 1 2 3\n", "a.obj");
    float min_obj[3], max_obj[3], centre_obj[3], radius_m;
    sheen_mesh_bounds(&mesh, min_obj, max_obj);
    sheen_mesh_sphere(&mesh, centre_obj, &radius_m);
    static const float want_min[] = {-1, 0, 2}, want_max[] = {3, 4, 4}, want_centre[] = {1, 2, 3};
    assert_memory_equal(min_obj, want_min, sizeof want_min);
    assert_memory_equal(max_obj, want_max, sizeof want_max);
    assert_memory_equal(centre_obj, want_centre, sizeof want_centre);
    assert_close(radius_m, 3, 1e-5); // to (-1, 0, 2): 2, 2, 1
    sheen_mesh_release(&mesh);
}

static void normals_weigh_by_area(void **state)
{
    (void)state;
    float p[] = {0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0, 1, 7, 7, 7}, n[15];
    uint32_t t[] = {0, 1, 2, 0, 2, 3}; // areas 3/2 along z and 1/2 along x
    sheen_mesh mesh = {p, n, t, 5, 2};
    sheen_mesh_compute_normals(&mesh);
    assert_close(n[0], 1 / sqrt(10.0), 1e-6);
    assert_close(n[2], 3 / sqrt(10.0), 1e-6);
    assert_close(n[5], 1, 0);
    assert_close(n[9], 1, 0);
    assert_close(n[14], 1, 0); // nobody's vertex
}

static sheen_status load_mesh(const char *path, sheen_err *err)
{
    sheen_mesh mesh;
    const sheen_status s = sheen_mesh_load(&mesh, path, err);
    assert_null(mesh.p_obj);
    return s;
}

static void says_what_is_wrong(void **state)
{
    (void)state;
    static const test_damaged_file files[] = {
        {"ply/cut.ply", SHEEN_EFORMAT, "PLY is cut short: face 3 of 4 is missing"},
        {"ply/claims-4e9-vertices.ply", SHEEN_EFORMAT,
         "PLY is cut short: its header claims 4000000000 records, 100 bytes follow"},
        {"ply/claims-4e9-faces.ply", SHEEN_EFORMAT,
         "PLY is cut short: its header claims 4000000000 records, 33 bytes follow"},
        {"ply/index-beyond.ply", SHEEN_EFORMAT, "a polygon names vertex 4 of 4"},
        {"ply/index-negative.ply", SHEEN_EFORMAT, "a polygon names vertex -1 of 4"},
        {"ply/vertex-nan.ply", SHEEN_EFORMAT, "vertex 1 is not finite"},
        {"ply/vertex-far.ply", SHEEN_EFORMAT, "vertex 1 lies 1e+30 m out, further than any object"},
        {"ply/points-only.ply", SHEEN_EDATA, "PLY has no faces: a point cloud is not a mesh"},
        {"ply/no-area.ply", SHEEN_EDATA, "it holds no triangle with an area"},
        {"ply/no-end.ply", SHEEN_EFORMAT, "PLY header has no end: the file is cut short"},
        {"ply/list-count-negative.ply", SHEEN_EFORMAT, "a list of -3 values in PLY is out of range"},
        {"obj/index-beyond.obj", SHEEN_EFORMAT, "a polygon names vertex 9 of 4"},
        {"obj/index-zero.obj", SHEEN_EFORMAT,
         "OBJ, line 5: a polygon's corner is not an index that counts from 1"},
        {"obj/negative-beyond.obj", SHEEN_EFORMAT,
         "OBJ, line 2: a polygon's corner is not an index that counts from 1"},
        {"obj/normal-beyond.obj", SHEEN_EFORMAT, "a polygon names normal 1 of 0"},
        {"obj/nan.obj", SHEEN_EFORMAT, "OBJ, line 1: a vertex wants three finite numbers"},
        {"obj/inf.obj", SHEEN_EFORMAT, "OBJ, line 1: a vertex wants three finite numbers"},
        {"obj/cut-in-vertex.obj", SHEEN_EFORMAT, "OBJ, line 2: a vertex wants three finite numbers"},
        {"obj/no-faces.obj", SHEEN_EDATA, "it holds no triangle with an area"},
        {"glb/cut.glb", SHEEN_EFORMAT, "glTF binary is cut short: 500 of 520 bytes"},
        {"glb/version-1.glb", SHEEN_EUNSUP, "glTF of version 1 is not supported: version 2 is"},
        {"glb/cycle.glb", SHEEN_EFORMAT, "glTF node 0 is reached in two ways"},
        {"glb/node-twice.glb", SHEEN_EFORMAT, "glTF node 1 is reached in two ways"},
        {"glb/node-missing.glb", SHEEN_EFORMAT, "glTF has no node 7"},
        {"glb/index-beyond.glb", SHEEN_EFORMAT, "a polygon names vertex 9 of 4"},
        {"glb/accessor-beyond-view.glb", SHEEN_EFORMAT, "glTF accessor 0 lies outside its buffer view"},
        {"glb/count-2e9.glb", SHEEN_EFORMAT, "glTF accessor 0 lies outside its buffer view"},
        {"glb/view-beyond-file.glb", SHEEN_EFORMAT, "glTF buffer view 0 lies outside the file's data"},
        {"glb/stride-too-small.glb", SHEEN_EFORMAT,
         "glTF accessor 0 has a component type or stride that is none"},
        {"glb/position-of-vec2.glb", SHEEN_EFORMAT, "glTF accessor 0 is not of type VEC3"},
        {"glb/sparse.glb", SHEEN_EUNSUP, "glTF with sparse or empty accessors is not supported"},
        {"glb/draco.glb", SHEEN_EUNSUP, "glTF with Draco compression is not supported: save it without"},
        {"glb/nan-matrix.glb", SHEEN_EFORMAT, "vertex 1 lies 1e+308 m out, further than any object"},
        {"glb/zero-scale.glb", SHEEN_EDATA, "it holds no triangle with an area"},
        {"glb/lines.glb", SHEEN_EDATA, "it holds no triangle with an area"},
        {"png/rgb8.png", SHEEN_EFORMAT,
         "not a mesh that is read here: neither PLY, OBJ (*.obj) nor glTF binary"},
    };
    test_damaged_files(files, sizeof files / sizeof *files, load_mesh);
    sheen_err err;
    sheen_mesh mesh;
    assert_int_equal(sheen_mesh_parse(&mesh, "", 0, "a.obj", &err), SHEEN_EFORMAT);
    assert_string_equal(err.msg, "the file is empty");
    assert_int_equal(sheen_mesh_parse(&mesh, "{}", 2, "a.gltf", &err), SHEEN_EUNSUP);
    assert_string_equal(err.msg, "glTF as text is not supported: save it as .glb");
}

// A cut binary file is refused at every length; of a cut OBJ a part may pass, but only whole triangles.
static void cut_files_never_give_half_a_mesh(void **state)
{
    (void)state;
    static const char *const paths[] = {CORPUS "ply/little-endian.ply", CORPUS "ply/big-endian-double.ply",
                                        CORPUS "glb/indices-u16.glb", CORPUS "obj/tetrahedron.obj"};
    for (size_t k = 0; k < sizeof paths / sizeof *paths; k++) {
        size_t size_bytes;
        uint8_t *data = test_file_read(paths[k], &size_bytes);
        for (size_t n = 0; n < size_bytes; n++) {
            sheen_mesh mesh;
            uint8_t *copy = malloc(n ? n : 1);
            assert_non_null(copy);
            memcpy(copy, data, n);
            const sheen_status s = sheen_mesh_parse(&mesh, copy, n, k == 3 ? "a.obj" : NULL, NULL);
            free(copy);
            if (k < 3)
                assert_int_equal(s, SHEEN_EFORMAT);
            else if (!s)
                assert_memory_equal(mesh.triangles, tetrahedron_t, 12 * mesh.n_triangles);
            sheen_mesh_release(&mesh);
        }
        free(data);
    }
}

static void reads_the_sample_mesh(void **state)
{
    (void)state;
    sheen_err err;
    sheen_mesh mesh;
    assert_ok(sheen_mesh_load(&mesh, SHEEN_TEST_DATA "/penguin/mesh.ply", &err), err);
    assert_int_equal(mesh.n_vertices, 8002);
    assert_int_equal(mesh.n_triangles, 16000);
    float min_obj[3], max_obj[3];
    sheen_mesh_bounds(&mesh, min_obj, max_obj);
    assert_true(min_obj[2] > -1e-3f && max_obj[2] < 0.13f); // stands on the board, a hand high
    // the file's normals agree with the triangles
    sheen_mesh found = mesh;
    found.n_obj = malloc(3 * mesh.n_vertices * sizeof(float));
    assert_non_null(found.n_obj);
    sheen_mesh_compute_normals(&found);
    double mean = 0;
    for (size_t i = 0; i < 3 * mesh.n_vertices; i++)
        mean += (double)(found.n_obj[i] * mesh.n_obj[i]) / (double)mesh.n_vertices;
    assert_true(mean > 0.999);
    free(found.n_obj);
    sheen_mesh_release(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_the_same_from_every_format),
        cmocka_unit_test(polygons_become_fans_and_colours_are_skipped),
        cmocka_unit_test(obj_corners_with_two_normals_repeat_the_vertex),
        cmocka_unit_test(glb_nodes_place_and_mirror),
        cmocka_unit_test(glb_strips_fans_and_normals),
        cmocka_unit_test_setup_teardown(saved_ply_reads_back_exactly, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(bounds_and_sphere_hold_all),
        cmocka_unit_test(normals_weigh_by_area),
        cmocka_unit_test(says_what_is_wrong),
        cmocka_unit_test(cut_files_never_give_half_a_mesh),
        cmocka_unit_test(reads_the_sample_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
