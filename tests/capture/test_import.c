// SPDX-License-Identifier: Apache-2.0
// test_import.c - what enters a session by import, and that a fault in any file leaves the session as it was.
#include "capture/import.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/capture/fixtures.h"
#include "tests/support.h"

enum { W = 16, H = 12 };

// Paths of the fixtures in this test's scratch folder.
typedef struct files {
    char a[TEST_PATH_MAX], b[TEST_PATH_MAX], exr[TEST_PATH_MAX], pictures[TEST_PATH_MAX];
    char camera[TEST_PATH_MAX], poses[TEST_PATH_MAX], mesh[TEST_PATH_MAX], board[TEST_PATH_MAX];
    char masks[TEST_PATH_MAX], mask_a[TEST_PATH_MAX];
} files;

static void make_files(files *f, void **state)
{
    static const char *const names[] = {"a", "b", "other"};
    sheen_err err;
    test_scratch_file(f->pictures, *state, "pictures");
    test_scratch_file(f->masks, *state, "masks");
    assert_ok(sheen_dir_make(f->pictures, &err), err);
    assert_ok(sheen_dir_make(f->masks, &err), err);
    test_scratch_file(f->a, *state, "pictures/a.png");
    test_scratch_file(f->b, *state, "pictures/b.jpg");
    test_scratch_file(f->exr, *state, "c.exr");
    test_scratch_file(f->camera, *state, "lens.cameramodel");
    test_scratch_file(f->poses, *state, "transforms.json");
    test_scratch_file(f->mesh, *state, "ball.obj");
    test_scratch_file(f->board, *state, "board.json");
    test_scratch_file(f->mask_a, *state, "masks/a.png");
    fixture_picture(f->a, W, H, 1, 0);
    fixture_picture(f->b, W, H, 2, 0);
    fixture_picture(f->exr, W, H, 3, 0);
    fixture_camera(f->camera, W, H);
    fixture_poses(f->poses, W, H, names, 3);
    fixture_mesh(f->mesh, 0);
    fixture_board(f->board);
    fixture_mask(f->mask_a, W, H);
}

static void make_session(sheen_session *s, void **state)
{
    char dir[TEST_PATH_MAX];
    sheen_err err;
    test_scratch_file(dir, *state, "s");
    assert_ok(sheen_session_create(s, dir, SHEEN_MOVING_CAMERA, &err), err);
}

static void everything_at_once(void **state)
{
    files f;
    sheen_session s;
    sheen_err err;
    sheen_import_report r;
    make_files(&f, state);
    make_session(&s, state);
    const char *const images[] = {f.pictures, f.exr};
    const sheen_import_options o = {.images = images,
                                    .n_images = 2,
                                    .camera = f.camera,
                                    .poses = f.poses,
                                    .mesh = f.mesh,
                                    .board = f.board,
                                    .calibration_board = f.board,
                                    .masks = f.masks,
                                    .set_moving = true,
                                    .moving = SHEEN_MOVING_OBJECT};
    assert_ok(sheen_import(&s, &o, &r, &err), err);
    assert_true(r.n_frames == 3 && !r.n_present && r.n_masks == 1 && r.n_poses == 2 && r.n_unposed == 1);
    assert_false(r.camera_from_poses);
    assert_int_equal(s.n_frames, 3);
    assert_int_equal(s.moving, SHEEN_MOVING_OBJECT);
    assert_string_equal(s.frames[1].file, "b.jpg");
    assert_string_equal(s.frames[1].source, "b.jpg");
    assert_int_equal(s.frames[1].transfer, SHEEN_TRANSFER_SRGB);
    assert_int_equal(s.frames[2].transfer, SHEEN_TRANSFER_LINEAR); // floats
    assert_true(s.frames[0].width_px == W && s.frames[0].height_px == H);
    static const char *const there[] = {"frames/a.png", "masks/a.png", "camera.cameramodel",    "poses.json",
                                        "mesh.obj",     "board.json",  "calibration-board.json"};
    for (size_t i = 0; i < sizeof there / sizeof *there; i++)
        assert_true(sheen_session_has(&s, there[i]));
    assert_false(sheen_session_has(&s, ".staging"));
    size_t n, m;
    char path[SHEEN_PATH_MAX];
    assert_ok(sheen_session_path(path, &s, "frames/b.jpg", &err), err);
    uint8_t *copied = test_file_read(path, &n), *original = test_file_read(f.b, &m);
    assert_int_equal(n, m);
    assert_memory_equal(copied, original, n);
    free(copied);
    free(original);
    sheen_poses poses;
    assert_ok(sheen_poses_load(&poses, &s, &err), err);
    assert_true(poses.imported);
    const sheen_frame_pose *a = sheen_poses_find(&poses, "a"), *c = sheen_poses_find(&poses, "c");
    assert_true(a && a->found && c && !c->found);
    assert_close(a->rt_cam_board[5], 0.5 + 0.03 * 0.6 * -1, 0.05); // half a metre away
    sheen_poses_release(&poses);
    sheen_session_release(&s);
}

// A picture's name that is none for a frame is altered; poses and masks are still found by the picture's own.
static void masks_and_poses_of_pictures_with_odd_names(void **state)
{
    static const char *const names[] = {"a b(1)"};
    files f;
    sheen_session s;
    sheen_err err;
    sheen_import_report r;
    char picture[TEST_PATH_MAX], mask[TEST_PATH_MAX];
    make_files(&f, state);
    make_session(&s, state);
    test_scratch_file(picture, *state, "a b(1).png");
    test_scratch_file(mask, *state, "masks/a b(1).png");
    fixture_picture(picture, W, H, 1, 0);
    fixture_mask(mask, W, H);
    fixture_poses(f.poses, W, H, names, 1);
    const char *const images[] = {picture};
    const sheen_import_options o = {.images = images, .n_images = 1, .poses = f.poses, .masks = f.masks};
    assert_ok(sheen_import(&s, &o, &r, &err), err);
    assert_true(r.n_frames == 1 && r.n_poses == 1 && r.n_masks == 1);
    assert_true(sheen_session_has(&s, "masks/a_b_1_.png"));
    sheen_session_release(&s);
}

static void the_same_pictures_again_are_skipped(void **state)
{
    files f;
    sheen_session s;
    sheen_err err;
    sheen_import_report r;
    make_files(&f, state);
    make_session(&s, state);
    const char *const one[] = {f.a}, *const both[] = {f.a, f.b};
    sheen_import_options o = {.images = one, .n_images = 1};
    assert_ok(sheen_import(&s, &o, &r, &err), err);
    o = (sheen_import_options){.images = both, .n_images = 2};
    assert_ok(sheen_import(&s, &o, &r, &err), err);
    assert_true(r.n_frames == 1 && r.n_present == 1 && s.n_frames == 2);
    o.role = SHEEN_ROLE_TEST;
    assert_fails(sheen_import(&s, &o, &r, &err), err, SHEEN_EARG, "role 'input'");
    o = (sheen_import_options){
        .images = both, .n_images = 2, .set_transfer = true, .transfer = SHEEN_TRANSFER_LINEAR};
    assert_fails(sheen_import(&s, &o, &r, &err), err, SHEEN_EARG, "transfer 'srgb'");
    fixture_picture(f.a, W, H, 77, 0);
    o = (sheen_import_options){.images = both, .n_images = 2};
    assert_fails(sheen_import(&s, &o, &r, &err), err, SHEEN_EARG, "other content");
    sheen_session_release(&s);
}

static void poses_bring_their_camera(void **state)
{
    files f;
    sheen_session s;
    sheen_err err;
    sheen_import_report r;
    char path[SHEEN_PATH_MAX];
    make_files(&f, state);
    make_session(&s, state);
    const char *const images[] = {f.a, f.b};
    const sheen_import_options o = {.images = images, .n_images = 2, .poses = f.poses};
    assert_ok(sheen_import(&s, &o, &r, &err), err);
    assert_true(r.camera_from_poses);
    sheen_camera camera;
    assert_ok(sheen_session_path(path, &s, SHEEN_SESSION_CAMERA, &err), err);
    assert_ok(sheen_camera_load(&camera, path, &err), err);
    assert_close(camera.intrinsics[0], 2.0 * W, 1e-9);
    assert_close(camera.intrinsics[2], (W - 1) / 2.0, 1e-9);
    assert_int_equal(camera.width_px, W);
    sheen_session_release(&s);
}

static void a_new_mesh_replaces_the_old_and_its_registration(void **state)
{
    files f;
    sheen_session s;
    sheen_err err;
    sheen_import_report r;
    double rt[6] = {0, 0, 0, 1, 2, 3};
    char path[SHEEN_PATH_MAX];
    make_files(&f, state);
    make_session(&s, state);
    assert_ok(sheen_session_path(path, &s, "mesh.ply", &err), err);
    test_file_write_text(path, "an older one");
    assert_ok(sheen_registration_save(rt, &s, &err), err);
    const sheen_import_options o = {.mesh = f.mesh};
    assert_ok(sheen_import(&s, &o, &r, &err), err);
    assert_string_equal(sheen_session_mesh_file(&s), "mesh.obj");
    assert_ok(sheen_registration_load(rt, &s, &err), err);
    assert_close(rt[5], 0, 0);
    sheen_session_release(&s);
}

// What the session's folder holds, as one text: names and digests of all files.
static void fingerprint(char out[4096], const sheen_session *s)
{
    static const char *const folders[] = {"", "frames", "masks"};
    size_t used = 0;
    for (size_t k = 0; k < 3; k++) {
        char dir[SHEEN_PATH_MAX], path[SHEEN_PATH_MAX], digest[33];
        sheen_err err;
        sheen_names names;
        assert_ok(sheen_session_path(dir, s, folders[k], &err), err);
        if (!sheen_dir_exists(dir))
            continue;
        assert_ok(sheen_dir_list(&names, dir, NULL, &err), err);
        for (size_t i = 0; i < names.count; i++) {
            assert_ok(sheen_path_join(path, dir, names.names[i], &err), err);
            digest[0] = 0;
            if (sheen_file_exists(path))
                assert_ok(sheen_file_digest(digest, path, &err), err);
            used += (size_t)snprintf(out + used, 4096 - used, "%s/%s %s\n", folders[k], names.names[i],
                                     digest);
            assert_true(used < 4096);
        }
        sheen_names_release(&names);
    }
}

static void cut(const char *path)
{
    size_t n;
    uint8_t *data = test_file_read(path, &n);
    test_file_write(path, data, n / 2);
    free(data);
}

// Each damage is done to one file of an import that asks for everything; nothing of it may enter.
enum damage {
    EMPTY_PICTURE,
    CUT_PICTURE,
    CUT_JPEG,
    NO_PICTURE,
    NOT_A_PICTURE,
    CUT_EXR,
    CAMERA_OF_OTHER_SIZE,
    EMPTY_CAMERA,
    POSES_NOT_FINITE,
    POSES_OF_OTHERS,
    NO_POSES,
    CUT_MESH,
    MESH_OF_UNKNOWN_KIND,
    MASK_OF_OTHER_SIZE,
    NO_MASKS,
    MASKS_OF_OTHERS,
    EMPTY_BOARD,
    N_DAMAGES
};

static const struct {
    sheen_status code;
    const char *says;
} expected[N_DAMAGES] = {
    [EMPTY_PICTURE] = {SHEEN_EFORMAT, "a.png"},
    [CUT_PICTURE] = {SHEEN_EFORMAT, "a.png"},
    [CUT_JPEG] = {SHEEN_EFORMAT, "b.jpg"},
    [NO_PICTURE] = {SHEEN_EIO, "b.jpg"},
    [NOT_A_PICTURE] = {SHEEN_EARG, "lens.cameramodel"},
    [CUT_EXR] = {SHEEN_EFORMAT, "c.exr"},
    [CAMERA_OF_OTHER_SIZE] = {SHEEN_EFORMAT, "16 x 12"},
    [EMPTY_CAMERA] = {SHEEN_EFORMAT, "lens.cameramodel"},
    [POSES_NOT_FINITE] = {SHEEN_EFORMAT, "transforms.json"},
    [POSES_OF_OTHERS] = {SHEEN_EDATA, "transforms.json"},
    [NO_POSES] = {SHEEN_EIO, "transforms.json"},
    [CUT_MESH] = {SHEEN_EFORMAT, "ball.obj"},
    [MESH_OF_UNKNOWN_KIND] = {SHEEN_EARG, "board.json"},
    [MASK_OF_OTHER_SIZE] = {SHEEN_EFORMAT, "masks/a.png"},
    [NO_MASKS] = {SHEEN_EIO, "nowhere"},
    [MASKS_OF_OTHERS] = {SHEEN_EDATA, "masks"},
    [EMPTY_BOARD] = {SHEEN_EFORMAT, "board.json"},
};

static void do_damage(enum damage d, files *f, sheen_import_options *o, const char **images)
{
    static const char *const others[] = {"x", "y"};
    switch (d) {
    case EMPTY_PICTURE:
        test_file_write_text(f->a, "");
        break;
    case CUT_PICTURE:
        cut(f->a);
        break;
    case CUT_JPEG:
        cut(f->b);
        break;
    case NO_PICTURE:
        assert_int_equal(remove(f->b), 0);
        break;
    case NOT_A_PICTURE:
        images[1] = f->camera;
        break;
    case CUT_EXR:
        cut(f->exr);
        break;
    case CAMERA_OF_OTHER_SIZE:
        fixture_camera(f->camera, 2 * W, H);
        break;
    case EMPTY_CAMERA:
        test_file_write_text(f->camera, "");
        break;
    case POSES_NOT_FINITE:
        test_file_write_text(
            f->poses, "{\"fl_x\":30,\"fl_y\":30,\"cx\":8,\"cy\":6,\"w\":16,\"h\":12,\"frames\":[{\"file_"
                      "path\":\"a\",\"transform_matrix\":[[NaN,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
        break;
    case POSES_OF_OTHERS:
        fixture_poses(f->poses, W, H, others, 2);
        break;
    case NO_POSES:
        assert_int_equal(remove(f->poses), 0);
        break;
    case CUT_MESH:
        test_file_write_text(f->mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
        break;
    case MESH_OF_UNKNOWN_KIND:
        o->mesh = f->board;
        break;
    case MASK_OF_OTHER_SIZE:
        fixture_mask(f->mask_a, W, H + 1);
        break;
    case NO_MASKS:
        o->masks = "/nowhere";
        break;
    case MASKS_OF_OTHERS:
        assert_int_equal(remove(f->mask_a), 0);
        break;
    case EMPTY_BOARD:
        test_file_write_text(f->board, "");
        break;
    case N_DAMAGES:
        break;
    }
}

static void a_fault_leaves_the_session_as_it_was(void **state)
{
    for (int d = 0; d < N_DAMAGES; d++) {
        files f;
        sheen_session s;
        sheen_err err;
        sheen_import_report r;
        char before[4096], after[4096];
        make_files(&f, state);
        make_session(&s, state);
        const char *images[] = {f.exr, f.a, f.b};
        sheen_import_options o = {.images = images, .n_images = 1, .board = f.board};
        if (d != CUT_EXR)
            assert_ok(sheen_import(&s, &o, &r, &err), err);
        fingerprint(before, &s);
        const size_t n_frames = s.n_frames;
        o = (sheen_import_options){.images = images,
                                   .n_images = 3,
                                   .camera = f.camera,
                                   .poses = f.poses,
                                   .mesh = f.mesh,
                                   .board = f.board,
                                   .masks = f.masks};
        do_damage((enum damage)d, &f, &o, images);
        print_message("damage %d\n", d);
        assert_fails(sheen_import(&s, &o, &r, &err), err, expected[d].code, expected[d].says);
        fingerprint(after, &s);
        assert_string_equal(before, after);
        assert_int_equal(s.n_frames, n_frames);
        assert_false(sheen_session_has(&s, ".staging") || sheen_session_has(&s, ".commit"));
        assert_ok(sheen_dir_remove(s.path, &err), err);
        sheen_session_release(&s);
    }
}

static void names_of_frames_come_from_files(void **state)
{
    (void)state;
    static const struct {
        const char *path, *name;
    } cases[] = {
        {"in00.png", "in00"},         {"/x/y/DSC_0012.JPG", "DSC_0012"}, {"a b(1).png", "a_b_1_"},
        {"x/.hidden.png", "_hidden"}, {"two.dots.png", "two.dots"},      {"no_ending", "no_ending"},
    };
    sheen_err err;
    char name[64];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_ok(sheen_import_name(name, cases[i].path, &err), err);
        assert_string_equal(name, cases[i].name);
    }
    assert_fails(
        sheen_import_name(name, "0123456789012345678901234567890123456789012345678901234567890.png", &err),
        err, SHEEN_EARG, "too long");
}

static bool stop(void *self, const char *what, int done, int total)
{
    (void)self;
    (void)what;
    (void)total;
    return done < 1;
}

static void a_cancelled_import_leaves_nothing(void **state)
{
    files f;
    sheen_session s;
    sheen_err err;
    sheen_import_report r;
    make_files(&f, state);
    make_session(&s, state);
    const char *const images[] = {f.a, f.b};
    const sheen_import_options o = {.images = images, .n_images = 2, .progress = {.step = stop}};
    assert_fails(sheen_import(&s, &o, &r, &err), err, SHEEN_ECANCEL, "cancelled");
    assert_false(sheen_session_has(&s, "frames/a.png") || sheen_session_has(&s, ".staging"));
    sheen_session_release(&s);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(everything_at_once),
        WITH_SCRATCH(masks_and_poses_of_pictures_with_odd_names),
        WITH_SCRATCH(the_same_pictures_again_are_skipped),
        WITH_SCRATCH(poses_bring_their_camera),
        WITH_SCRATCH(a_new_mesh_replaces_the_old_and_its_registration),
        WITH_SCRATCH(a_fault_leaves_the_session_as_it_was),
        cmocka_unit_test(names_of_frames_come_from_files),
        WITH_SCRATCH(a_cancelled_import_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
