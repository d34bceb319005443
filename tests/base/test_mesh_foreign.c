// SPDX-License-Identifier: Apache-2.0
// Meshes through assimp: an STL of each kind, glTF as text, and what is no mesh.
#include <string.h>

#include "base/mesh_foreign.h"
#include "support.h"

static const char stl[] =
    "solid t\n"
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 10 0 0\nvertex 0 10 0\nendloop\nendfacet\n"
    "facet normal 0 0 1\nouter loop\nvertex 10 0 0\nvertex 10 10 0\nvertex 0 10 0\nendloop\n"
    "endfacet\nendsolid t\n";

// One triangle, moved by its node by (1, 2, 3).
static const char gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"mesh\":0,\"translation\":[1,2,3]}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],"
    "\"max\":[1,1,0]}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";

static void reads_what_others_write(void **state)
{
    const test_scratch *scratch = *state;
    sheen_err err;
    sheen_mesh mesh;
    char path[TEST_PATH_MAX];
    float low[3], high[3];
    test_scratch_file(path, scratch, "part.stl");
    test_file_write_text(path, stl);
    assert_false(sheen_mesh_is_native(path));
    assert_ok(sheen_mesh_load_any(&mesh, path, &err), err);
    assert_int_equal((int)mesh.n_triangles, 2);
    sheen_mesh_bounds(&mesh, low, high);
    assert_close(high[0], 10, 0);
    sheen_mesh_release(&mesh);

    test_scratch_file(path, scratch, "part.gltf");
    test_file_write_text(path, gltf);
    assert_ok(sheen_mesh_load_any(&mesh, path, &err), err);
    assert_int_equal((int)mesh.n_triangles, 1);
    sheen_mesh_bounds(&mesh, low, high);
    assert_close(low[1], 2, 1e-6);
    assert_close(high[0], 2, 1e-6);
    sheen_mesh_release(&mesh);
}

static void says_what_is_no_mesh(void **state)
{
    const test_scratch *scratch = *state;
    sheen_err err;
    sheen_mesh mesh;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "no.stl");
    assert_fails(sheen_mesh_load_any(&mesh, path, &err), err, SHEEN_EIO, "no.stl");
    test_file_write_text(path, "");
    assert_fails(sheen_mesh_load_any(&mesh, path, &err), err, SHEEN_EFORMAT, "not a mesh that is read here");
    test_file_write_text(path, "solid nothing\nendsolid nothing\n");
    assert_int_not_equal(sheen_mesh_load_any(&mesh, path, &err), SHEEN_OK);
    // not a number: refused, or the facet dropped, but never let through
    test_file_write_text(
        path, "solid t\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\nvertex 10 0 0\nvertex 0 10 0\n"
              "endloop\nendfacet\nendsolid t\n");
    assert_int_not_equal(sheen_mesh_load_any(&mesh, path, &err), SHEEN_OK);
    test_scratch_file(path, scratch, "words.txt");
    test_file_write_text(path, "some words\n");
    assert_fails(sheen_mesh_load_any(&mesh, path, &err), err, SHEEN_EFORMAT, "words.txt");
}

// Cut short anywhere, a binary STL either reads or says why not, and the program lives on.
static void survives_damage(void **state)
{
    const test_scratch *scratch = *state;
    sheen_err err;
    sheen_mesh mesh;
    char path[TEST_PATH_MAX];
    uint8_t data[84 + 50] = {0};
    const float facet[12] = {0, 0, 1, 0, 0, 0, 5, 0, 0, 0, 5, 0};
    data[80] = 1;
    memcpy(data + 84, facet, sizeof facet);
    test_scratch_file(path, scratch, "part.stl");
    test_file_write(path, data, sizeof data);
    assert_ok(sheen_mesh_load_any(&mesh, path, &err), err);
    assert_int_equal((int)mesh.n_triangles, 1);
    sheen_mesh_release(&mesh);
    for (size_t n = 0; n < sizeof data; n += 13) {
        test_file_write(path, data, n);
        if (!sheen_mesh_load_any(&mesh, path, &err))
            sheen_mesh_release(&mesh);
    }
    data[82] = 0xff; // sixteen million facets that are not there
    test_file_write(path, data, sizeof data);
    if (!sheen_mesh_load_any(&mesh, path, &err))
        sheen_mesh_release(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(reads_what_others_write, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(says_what_is_no_mesh, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(survives_damage, test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
