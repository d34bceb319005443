// SPDX-License-Identifier: Apache-2.0
// test_session.c - the session's folder: frames, poses, stamps, and what a power cut may leave in it.
#include "base/session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/image_file.h"
#include "base/json_write.h"
#include "tests/support.h"

static void session_dir(char out[TEST_PATH_MAX], void **state)
{
    test_scratch_file(out, *state, "s");
}

static void file_of(char out[SHEEN_PATH_MAX], const sheen_session *s, const char *file)
{
    sheen_err err;
    assert_ok(sheen_session_path(out, s, file, &err), err);
}

static void new_session(sheen_session *s, void **state)
{
    char dir[TEST_PATH_MAX];
    sheen_err err;
    session_dir(dir, state);
    assert_ok(sheen_session_create(s, dir, SHEEN_MOVING_CAMERA, &err), err);
}

static void reopen(sheen_session *s)
{
    char path[SHEEN_PATH_MAX];
    sheen_err err;
    memcpy(path, s->path, sizeof path);
    sheen_session_release(s);
    assert_ok(sheen_session_open(s, path, &err), err);
}

static void add(sheen_session *s, const char *name, sheen_role role, const char *payload)
{
    sheen_frame_info f;
    sheen_err err;
    sheen_frame_info_init(&f);
    snprintf(f.name, sizeof f.name, "%s", name);
    f.role = role;
    f.width_px = 4;
    f.height_px = 3;
    assert_ok(sheen_session_add_frame(s, &f, "bin", payload, strlen(payload), &err), err);
}

static void a_frame_comes_back_as_it_went(void **state)
{
    sheen_session s;
    sheen_err err;
    new_session(&s, state);
    sheen_frame_info f;
    sheen_frame_info_init(&f);
    snprintf(f.name, sizeof f.name, "a-b.c_9");
    f.role = SHEEN_ROLE_TEST;
    f.width_px = 640;
    f.height_px = 480;
    f.fourcc = 0x20363159u | 0x80000000u; // "Y16 " big-endian
    f.stride_bytes = 1280;
    f.transfer = SHEEN_TRANSFER_REC709;
    f.t_ns = INT64_C(9007199254740993); // does not fit a double
    f.sequence = 17;
    f.table_asked_deg = 30;
    f.table_measured_deg = 30.0125;
    snprintf(f.source, sizeof f.source, "v4l2:/dev/\"video0\"");
    assert_ok(sheen_session_add_frame(&s, &f, "raw", "\0\1\2", 3, &err), err);
    reopen(&s);
    assert_int_equal(s.n_frames, 1);
    const sheen_frame_info *g = sheen_session_find(&s, "a-b.c_9");
    assert_non_null(g);
    assert_string_equal(g->file, "a-b.c_9.raw");
    assert_int_equal(g->role, f.role);
    assert_int_equal(g->width_px, 640);
    assert_int_equal(g->height_px, 480);
    assert_int_equal(g->fourcc, f.fourcc);
    assert_int_equal(g->stride_bytes, 1280);
    assert_int_equal(g->transfer, f.transfer);
    assert_true(g->t_ns == f.t_ns && g->sequence == 17);
    assert_close(g->table_asked_deg, 30, 0);
    assert_close(g->table_measured_deg, 30.0125, 0);
    assert_string_equal(g->source, f.source);
    uint8_t *data;
    size_t n;
    assert_ok(sheen_session_payload(&data, &n, &s, g, &err), err);
    assert_int_equal(n, 3);
    assert_memory_equal(data, "\0\1\2", 3);
    free(data);
    sheen_session_release(&s);
}

static void what_a_pipeline_says_comes_back(void **state)
{
    sheen_session s;
    sheen_err err;
    sheen_frame_info f;
    new_session(&s, state);
    sheen_frame_info_init(&f);
    snprintf(f.name, sizeof f.name, "a");
    f.width_px = f.height_px = 1;
    f.pipeline = (sheen_frame_pipeline){19998.5, 1.5, 1.01, 1.6, 2.1, {4096, 4095, 0, 1}};
    assert_ok(sheen_session_add_frame(&s, &f, "jpg", "x", 1, &err), err);
    reopen(&s);
    assert_memory_equal(&s.frames[0].pipeline, &f.pipeline, sizeof f.pipeline);
    sheen_session_release(&s);
}

static void unknown_stays_unknown(void **state)
{
    sheen_session s;
    new_session(&s, state);
    add(&s, "a", SHEEN_ROLE_INPUT, "x");
    reopen(&s);
    assert_true(s.frames[0].t_ns == -1 && s.frames[0].sequence == -1 && !s.frames[0].fourcc);
    assert_true(isnan(s.frames[0].table_asked_deg) && isnan(s.frames[0].table_measured_deg));
    sheen_session_release(&s);
}

static void frames_are_sorted_by_name(void **state)
{
    sheen_session s;
    new_session(&s, state);
    static const char *const names[] = {"b", "a", "a-b", "a.json", "000001", "Z"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        add(&s, names[i], i % 2 ? SHEEN_ROLE_INPUT : SHEEN_ROLE_CALIBRATION, names[i]);
    for (int round = 0; round < 2; round++) {
        assert_int_equal(s.n_frames, 6);
        for (size_t i = 0; i + 1 < s.n_frames; i++)
            assert_true(strcmp(s.frames[i].name, s.frames[i + 1].name) < 0);
        for (size_t i = 0; i < 6; i++)
            assert_non_null(sheen_session_find(&s, names[i]));
        assert_null(sheen_session_find(&s, "c"));
        assert_int_equal(sheen_session_count_role(&s, SHEEN_ROLE_CALIBRATION), 3);
        assert_int_equal(sheen_session_count_role(&s, SHEEN_ROLE_TEST), 0);
        reopen(&s);
    }
    char name[64];
    sheen_session_next_name(&s, name);
    assert_string_equal(name, "000002");
    sheen_session_release(&s);
}

static void refuses_bad_names(void **state)
{
    sheen_session s;
    sheen_err err;
    new_session(&s, state);
    add(&s, "taken", SHEEN_ROLE_INPUT, "x");
    static const char *const bad[] = {"",
                                      ".a",
                                      "a/b",
                                      "a b",
                                      "../a",
                                      "\xc3\xa4",
                                      "0123456789012345678901234567890123456789012345678901234567890"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        sheen_frame_info f;
        sheen_frame_info_init(&f);
        snprintf(f.name, sizeof f.name, "%s", bad[i]);
        assert_fails(sheen_session_add_frame(&s, &f, "png", "x", 1, &err), err, SHEEN_EARG,
                     "no name for a frame");
    }
    sheen_frame_info f;
    sheen_frame_info_init(&f);
    snprintf(f.name, sizeof f.name, "taken");
    assert_fails(sheen_session_add_frame(&s, &f, "png", "x", 1, &err), err, SHEEN_EARG, "already");
    snprintf(f.name, sizeof f.name, "new");
    assert_fails(sheen_session_add_frame(&s, &f, "json", "x", 1, &err), err, SHEEN_EARG, "ending");
    assert_fails(sheen_session_add_frame(&s, &f, "a/b", "x", 1, &err), err, SHEEN_EARG, "ending");
    assert_int_equal(s.n_frames, 1);
    sheen_session_release(&s);
}

static void leftovers_of_a_power_cut_are_not_listed(void **state)
{
    sheen_session s;
    char path[SHEEN_PATH_MAX];
    new_session(&s, state);
    add(&s, "a", SHEEN_ROLE_INPUT, "x");
    add(&s, "b", SHEEN_ROLE_INPUT, "y");
    static const char *const leftovers[] = {"frames/c.png", "frames/.d.json.x1y2z3", ".session.json.abcdef",
                                            "frames/.json"};
    for (size_t i = 0; i < sizeof leftovers / sizeof *leftovers; i++) {
        file_of(path, &s, leftovers[i]);
        test_file_write_text(path, "{\"half");
    }
    file_of(path, &s, "frames/b.bin");
    assert_int_equal(unlink(path), 0);
    reopen(&s);
    assert_int_equal(s.n_frames, 1);
    assert_string_equal(s.frames[0].name, "a");
    add(&s, "b", SHEEN_ROLE_INPUT, "y"); // goes on where it was
    add(&s, "c", SHEEN_ROLE_INPUT, "z");
    reopen(&s);
    assert_int_equal(s.n_frames, 3);
    sheen_session_release(&s);
}

static void says_what_is_damaged(void **state)
{
    static const struct {
        const char *file, *text;
        sheen_status code;
        const char *says;
    } cases[] = {
        {"session.json", "", SHEEN_EFORMAT, "session.json'"},
        {"session.json", "{}", SHEEN_EFORMAT, "schema"},
        {"session.json", "{\"schema\":\"sheen-session/2\",\"moving\":\"camera\",\"created\":\"\"}",
         SHEEN_EFORMAT, "update sheen"},
        {"session.json", "{\"schema\":\"sheen-session/1\",\"moving\":\"moon\",\"created\":\"\"}",
         SHEEN_EFORMAT, "moon"},
        {"frames/a.json", "", SHEEN_EFORMAT, "frames/a.json"},
        {"frames/a.json", "[1]", SHEEN_EFORMAT, "frames/a.json"},
        {"frames/a.json",
         "{\"schema\":\"sheen-frame/1\",\"file\":\"../"
         "x.png\",\"role\":\"input\",\"transfer\":\"srgb\",\"source\":\"\","
         "\"payload_digest\":\"00000000000000000000000000000000\"}",
         SHEEN_EFORMAT, "../x.png"},
        {"frames/a.json",
         "{\"schema\":\"sheen-frame/"
         "1\",\"file\":\"a.bin\",\"role\":\"king\",\"transfer\":\"srgb\",\"source\":\"\","
         "\"payload_digest\":\"00000000000000000000000000000000\"}",
         SHEEN_EFORMAT, "king"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_session s, t;
        sheen_err err;
        char path[SHEEN_PATH_MAX];
        new_session(&s, state);
        add(&s, "a", SHEEN_ROLE_INPUT, "x");
        file_of(path, &s, cases[i].file);
        test_file_write_text(path, cases[i].text);
        assert_fails(sheen_session_open(&t, s.path, &err), err, cases[i].code, cases[i].says);
        assert_null(t.frames);
        assert_ok(sheen_dir_remove(s.path, &err), err);
        sheen_session_release(&s);
    }
}

static void opens_only_sessions_and_makes_only_new_ones(void **state)
{
    sheen_session s;
    sheen_err err;
    char dir[TEST_PATH_MAX], file[TEST_PATH_MAX];
    session_dir(dir, state);
    assert_fails(sheen_session_open(&s, dir, &err), err, SHEEN_EIO, "no such folder");
    assert_int_equal(mkdir(dir, 0777), 0);
    assert_fails(sheen_session_open(&s, dir, &err), err, SHEEN_EFORMAT, "not a session");
    snprintf(file, sizeof file, "%.400s/thesis.txt", dir);
    test_file_write_text(file, "x");
    assert_fails(sheen_session_create(&s, dir, SHEEN_MOVING_CAMERA, &err), err, SHEEN_EARG, "other things");
    assert_int_equal(unlink(file), 0);
    assert_ok(sheen_session_create(&s, dir, SHEEN_MOVING_OBJECT, &err), err);
    sheen_session_release(&s);
    assert_ok(sheen_session_create(&s, dir, SHEEN_MOVING_CAMERA, &err), err); // exists: opened as it is
    assert_int_equal(s.moving, SHEEN_MOVING_OBJECT);
    assert_int_equal(strlen(s.created), 20);
    sheen_session_release(&s);
}

static void a_changed_payload_is_noticed(void **state)
{
    sheen_session s;
    sheen_err err;
    char path[SHEEN_PATH_MAX];
    uint8_t *data;
    size_t n;
    new_session(&s, state);
    add(&s, "a", SHEEN_ROLE_INPUT, "right");
    file_of(path, &s, "frames/a.bin");
    test_file_write_text(path, "wrong");
    assert_fails(sheen_session_payload(&data, &n, &s, &s.frames[0], &err), err, SHEEN_EFORMAT, "digest");
    assert_null(data);
    sheen_session_release(&s);
}

static void poses_come_back(void **state)
{
    sheen_session s;
    sheen_err err;
    new_session(&s, state);
    sheen_poses none;
    assert_fails(sheen_poses_load(&none, &s, &err), err, SHEEN_EDATA, "no poses yet");
    sheen_frame_pose list[2] = {{.name = "b", .found = true, .rms_px = 0.1, .n_points = 60, .n_outliers = 2},
                                {.name = "a", .reason = "the board is not in view"}};
    for (int i = 0; i < 6; i++)
        list[0].rt_cam_board[i] = 1.0 / (i + 3);
    for (int i = 0; i < 36; i++)
        list[0].covariance[i] = 1e-9 * i / 7;
    for (int imported = 0; imported < 2; imported++) {
        sheen_poses p = {.poses = list, .n_poses = 2, .imported = imported}, q;
        assert_ok(sheen_poses_save(&p, &s, &err), err);
        assert_ok(sheen_poses_load(&q, &s, &err), err);
        assert_int_equal(q.n_poses, 2);
        assert_int_equal(q.imported, imported);
        const sheen_frame_pose *a = sheen_poses_find(&q, "a"), *b = sheen_poses_find(&q, "b");
        assert_true(a && b && !a->found && b->found);
        assert_string_equal(a->reason, "the board is not in view");
        assert_memory_equal(b->rt_cam_board, list[0].rt_cam_board, sizeof b->rt_cam_board);
        assert_close(b->rms_px, imported ? (double)NAN : 0.1, 0);
        assert_close(b->covariance[35], imported ? 0 : list[0].covariance[35], 0);
        assert_int_equal(b->n_points, imported ? 0 : 60);
        sheen_poses_release(&q);
    }
    sheen_session_release(&s);
}

static void damaged_poses_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",
        "{\"schema\":\"sheen-poses/1\",\"imported\":true}",
        "{\"schema\":\"sheen-poses/2\",\"imported\":true,\"frames\":[]}",
        "{\"schema\":\"sheen-poses/1\",\"imported\":true,\"frames\":[{\"name\":\"a\",\"found\":true}]}",
        "{\"schema\":\"sheen-poses/1\",\"imported\":true,\"frames\":"
        "[{\"name\":\"a\",\"found\":true,\"rt_cam_board\":[1,2,3,4,5]}]}",
        "{\"schema\":\"sheen-poses/1\",\"imported\":true,\"frames\":"
        "[{\"name\":\"a\",\"found\":false},{\"name\":\"a\",\"found\":false}]}",
        "{\"schema\":\"sheen-poses/1\",\"imported\":true,\"frames\":[{\"name\":\"a/b\",\"found\":false}]}",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        sheen_poses p;
        sheen_err err;
        assert_fails(sheen_poses_parse(&p, bad[i], strlen(bad[i]), &err), err, SHEEN_EFORMAT, "");
        assert_null(p.poses);
    }
}

static void registration_is_the_identity_until_it_is_set(void **state)
{
    sheen_session s;
    sheen_err err;
    double rt[6] = {1, 1, 1, 1, 1, 1}, want[6] = {0.1, -0.2, 0.3, 0.01, 0.02, -0.03};
    new_session(&s, state);
    assert_ok(sheen_registration_load(rt, &s, &err), err);
    for (int i = 0; i < 6; i++)
        assert_close(rt[i], 0, 0);
    assert_ok(sheen_registration_save(want, &s, &err), err);
    assert_ok(sheen_registration_load(rt, &s, &err), err);
    assert_memory_equal(rt, want, sizeof rt);
    want[3] = (double)NAN;
    assert_fails(sheen_registration_save(want, &s, &err), err, SHEEN_EARG, "finite");
    sheen_session_release(&s);
}

static void write_result(const sheen_session *s, const char *const *files)
{
    sheen_json_writer w = {0};
    sheen_err err;
    char path[SHEEN_PATH_MAX];
    file_of(path, s, "result.json");
    sheen_json_open(&w, NULL, '{');
    assert_ok(sheen_stamp_write(&w, s, files, &err), err);
    sheen_json_close(&w);
    assert_ok(sheen_json_save(&w, path, &err), err);
}

static bool is_current(const sheen_session *s, const char *const *files)
{
    sheen_json *root;
    sheen_err err;
    char path[SHEEN_PATH_MAX];
    file_of(path, s, "result.json");
    assert_ok(sheen_json_load(&root, path, &err), err);
    const bool current = sheen_stamp_is_current(root, s, files);
    sheen_json_free(&root);
    return current;
}

static void a_stamp_tells_what_has_changed(void **state)
{
    static const char *const files[] = {"camera.cameramodel", "board.json", "frames:input", NULL};
    static const char *const fewer[] = {"camera.cameramodel", "board.json", NULL};
    static const char *const more[] = {"camera.cameramodel", "board.json", "frames:input", "mesh.ply", NULL};
    sheen_session s;
    sheen_err err;
    char path[SHEEN_PATH_MAX];
    new_session(&s, state);
    add(&s, "a", SHEEN_ROLE_INPUT, "x");
    file_of(path, &s, "board.json");
    test_file_write_text(path, "board");
    write_result(&s, files);
    assert_true(is_current(&s, files));
    assert_false(is_current(&s, fewer));
    assert_false(is_current(&s, more));
    add(&s, "t", SHEEN_ROLE_TEST, "y"); // another role: no matter
    assert_true(is_current(&s, files));
    test_file_write_text(path, "other board");
    assert_false(is_current(&s, files));
    test_file_write_text(path, "board");
    assert_true(is_current(&s, files));
    file_of(path, &s, "camera.cameramodel"); // was missing
    test_file_write_text(path, "camera");
    assert_false(is_current(&s, files));
    assert_int_equal(unlink(path), 0);
    add(&s, "b", SHEEN_ROLE_INPUT, "z");
    assert_false(is_current(&s, files));
    write_result(&s, files);
    assert_true(is_current(&s, files));
    assert_ok(sheen_session_add_mask(&s, SHEEN_SESSION_MASKS, "b", "m", 1, &err), err);
    assert_false(is_current(&s, files));
    write_result(&s, files);
    s.frames[0].transfer = SHEEN_TRANSFER_LINEAR;
    assert_false(is_current(&s, files));
    static const char *const highlights[] = {"highlights:test", NULL};
    write_result(&s, highlights);
    assert_ok(sheen_session_add_mask(&s, SHEEN_SESSION_HIGHLIGHTS, "b", "m", 1, &err), err); // an input frame
    assert_true(is_current(&s, highlights));
    assert_ok(sheen_session_add_mask(&s, SHEEN_SESSION_HIGHLIGHTS, "t", "m", 1, &err), err);
    assert_false(is_current(&s, highlights));
    sheen_session_release(&s);
}

static void staged_files_enter_together(void **state)
{
    sheen_session s, staged;
    sheen_err err;
    char path[SHEEN_PATH_MAX];
    new_session(&s, state);
    add(&s, "a", SHEEN_ROLE_INPUT, "x");
    file_of(path, &s, "mesh.obj");
    test_file_write_text(path, "old");

    assert_ok(sheen_session_stage(&staged, &s, &err), err);
    add(&staged, "b", SHEEN_ROLE_INPUT, "y");
    sheen_session_unstage(&staged);
    reopen(&s);
    assert_int_equal(s.n_frames, 1);

    assert_ok(sheen_session_stage(&staged, &s, &err), err);
    add(&staged, "b", SHEEN_ROLE_INPUT, "y");
    assert_ok(sheen_session_add_mask(&staged, SHEEN_SESSION_MASKS, "b", "m", 1, &err), err);
    file_of(path, &staged, "mesh.ply");
    test_file_write_text(path, "new");
    assert_int_equal(s.n_frames, 1);
    assert_ok(sheen_session_commit(&s, &staged, &err), err);
    assert_int_equal(s.n_frames, 2);
    assert_string_equal(sheen_session_mesh_file(&s), "mesh.ply");
    assert_false(sheen_session_has(&s, "mesh.obj"));
    assert_true(sheen_session_has(&s, "masks/b.png"));
    assert_false(sheen_session_has(&s, ".commit") || sheen_session_has(&s, ".staging"));
    sheen_session_release(&s);
}

// Every state that a cut during the moves can leave: some files moved, the others still in .commit.
static void an_interrupted_commit_is_completed(void **state)
{
    static const char *const files[] = {"masks/b.png", "frames/b.bin", "frames/b.json", "mesh.ply"};
    enum { N_FILES = sizeof files / sizeof *files };
    for (int moved = 0; moved <= N_FILES; moved++) {
        sheen_session s, staged;
        sheen_err err;
        new_session(&s, state);
        assert_ok(sheen_session_stage(&staged, &s, &err), err);
        add(&staged, "b", SHEEN_ROLE_INPUT, "y");
        assert_ok(sheen_session_add_mask(&staged, SHEEN_SESSION_MASKS, "b", "m", 1, &err), err);
        char from[SHEEN_PATH_MAX], to[SHEEN_PATH_MAX];
        file_of(from, &staged, "mesh.ply");
        test_file_write_text(from, "new");
        file_of(to, &s, "masks");
        mkdir(to, 0777);
        file_of(to, &s, ".commit");
        assert_int_equal(rename(staged.path, to), 0);
        for (int i = 0; i < moved; i++) {
            char inside[64];
            snprintf(inside, sizeof inside, ".commit/%s", files[i]);
            file_of(from, &s, inside);
            file_of(to, &s, files[i]);
            assert_int_equal(rename(from, to), 0);
        }
        reopen(&s);
        assert_int_equal(s.n_frames, 1);
        for (int i = 0; i < N_FILES; i++)
            assert_true(sheen_session_has(&s, files[i]));
        assert_false(sheen_session_has(&s, ".commit"));
        assert_ok(sheen_dir_remove(s.path, &err), err);
        sheen_session_release(&s);
        sheen_session_release(&staged);
    }
}

static void pictures_and_masks_are_decoded(void **state)
{
    sheen_session s;
    sheen_err err;
    char path[TEST_PATH_MAX];
    sheen_raster r;
    new_session(&s, state);
    assert_ok(sheen_raster_init(&r, 4, 3, 3, 8, &err), err);
    for (int i = 0; i < 36; i++)
        ((uint8_t *)r.data)[i] = (uint8_t)(i * 7);
    test_scratch_file(path, *state, "a.png");
    assert_ok(sheen_png_write(path, &r, &err), err);
    sheen_raster_release(&r);
    size_t n;
    uint8_t *png = test_file_read(path, &n);
    sheen_frame_info f;
    sheen_frame_info_init(&f);
    snprintf(f.name, sizeof f.name, "a");
    f.width_px = 4;
    f.height_px = 3;
    assert_ok(sheen_session_add_frame(&s, &f, "png", png, n, &err), err);
    sheen_raster raster;
    sheen_image img;
    assert_ok(sheen_session_mask(&img, &s, &f, &err), err);
    assert_null(img.data);
    assert_ok(sheen_session_image(&img, &s, &f, &err), err);
    assert_int_equal(img.n_channels, 3);
    assert_close(img.data[35], sheen_transfer_decode(SHEEN_TRANSFER_SRGB, 245 / 255.0f), 1e-6);
    sheen_image_release(&img);
    assert_ok(sheen_session_add_mask(&s, SHEEN_SESSION_MASKS, "a", png, n, &err), err);
    assert_ok(sheen_session_mask(&img, &s, &f, &err), err);
    assert_int_equal(img.n_channels, 1);
    assert_close(img.data[1], 21 / 255.0, 1e-6);
    sheen_image_release(&img);
    f.width_px = 5; // the description does not fit the picture
    assert_fails(sheen_session_image(&img, &s, &f, &err), err, SHEEN_EFORMAT, "5 x 3");
    assert_fails(sheen_session_mask(&img, &s, &f, &err), err, SHEEN_EFORMAT, "masks/a.png");
    f.width_px = 4;
    f.fourcc = 0x34363248; // "H264"
    assert_fails(sheen_session_image(&img, &s, &f, &err), err, SHEEN_EUNSUP, "raw data");
    f.fourcc = 0x56595559; // "YUYV": the picture's bytes for once taken as such a frame's
    f.stride_bytes = 8;
    f.height_px = 1;
    assert_ok(sheen_session_raster(&raster, &s, &f, &err), err);
    assert_true(raster.width_px == 4 && raster.n_channels == 3 && raster.bits == 16);
    sheen_raster_release(&raster);
    f.height_px = 30000;
    assert_fails(sheen_session_raster(&raster, &s, &f, &err), err, SHEEN_EFORMAT, "cut short");
    free(png);
    sheen_session_release(&s);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(a_frame_comes_back_as_it_went),
        WITH_SCRATCH(what_a_pipeline_says_comes_back),
        WITH_SCRATCH(unknown_stays_unknown),
        WITH_SCRATCH(frames_are_sorted_by_name),
        WITH_SCRATCH(refuses_bad_names),
        WITH_SCRATCH(leftovers_of_a_power_cut_are_not_listed),
        WITH_SCRATCH(says_what_is_damaged),
        WITH_SCRATCH(opens_only_sessions_and_makes_only_new_ones),
        WITH_SCRATCH(a_changed_payload_is_noticed),
        WITH_SCRATCH(poses_come_back),
        cmocka_unit_test(damaged_poses_are_refused),
        WITH_SCRATCH(registration_is_the_identity_until_it_is_set),
        WITH_SCRATCH(a_stamp_tells_what_has_changed),
        WITH_SCRATCH(staged_files_enter_together),
        WITH_SCRATCH(an_interrupted_commit_is_completed),
        WITH_SCRATCH(pictures_and_masks_are_decoded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
