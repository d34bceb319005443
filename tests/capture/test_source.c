// SPDX-License-Identifier: Apache-2.0
// test_source.c - sources by URI, replay of a session, and the recorder.
#include "capture/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "capture/record.h"
#include "tests/support.h"

static void make_session(sheen_session *s, void **state, const char *name)
{
    char dir[TEST_PATH_MAX];
    sheen_err err;
    test_scratch_file(dir, *state, name);
    assert_ok(sheen_session_create(s, dir, SHEEN_MOVING_CAMERA, &err), err);
}

static void add(sheen_session *s, const char *name, sheen_role role, int64_t sequence)
{
    sheen_frame_info f;
    sheen_err err;
    char payload[80];
    sheen_frame_info_init(&f);
    snprintf(f.name, sizeof f.name, "%s", name);
    snprintf(f.source, sizeof f.source, "v4l2:/dev/video0");
    f.role = role;
    f.width_px = 640;
    f.height_px = 480;
    f.fourcc = 0x56595559;
    f.stride_bytes = 1280;
    f.transfer = SHEEN_TRANSFER_REC709;
    f.sequence = sequence;
    f.t_ns = 1000 * sequence;
    f.table_asked_deg = f.table_measured_deg = 3.0 * (double)sequence;
    snprintf(payload, sizeof payload, "payload of %s", name);
    assert_ok(sheen_session_add_frame(s, &f, "raw", payload, strlen(payload), &err), err);
}

// Three frames, one of them with a mask.
static void make_recording(sheen_session *s, void **state)
{
    sheen_err err;
    make_session(s, state, "recording");
    add(s, "a", SHEEN_ROLE_INPUT, 4);
    add(s, "b", SHEEN_ROLE_TEST, 5);
    add(s, "c", SHEEN_ROLE_INPUT, 7);
    assert_ok(sheen_session_add_mask(s, SHEEN_SESSION_MASKS, "b", "mask of b", 9, &err), err);
}

static void open_replay(sheen_source **src, const sheen_session *s, const char *query)
{
    char uri[SHEEN_PATH_MAX + 64];
    sheen_err err;
    snprintf(uri, sizeof uri, "replay:%s%s", s->path, query);
    assert_ok(sheen_source_open(src, uri, &err), err);
}

static void replays_every_frame_as_it_was(void **state)
{
    sheen_session s;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    make_recording(&s, state);
    open_replay(&src, &s, "");
    assert_int_equal(sheen_source_count(src), 3);
    for (size_t i = 0; i < 3; i++) {
        assert_ok(sheen_source_next(src, 1000, &frame, &err), err);
        char payload[80];
        snprintf(payload, sizeof payload, "payload of %s", s.frames[i].name);
        assert_int_equal(frame.size_bytes, strlen(payload));
        assert_memory_equal(frame.data, payload, frame.size_bytes);
        assert_string_equal(frame.extension, "raw");
        assert_string_equal(frame.info.name, s.frames[i].name);
        assert_string_equal(frame.info.source, "v4l2:/dev/video0");
        assert_int_equal(frame.info.role, s.frames[i].role);
        assert_true(frame.info.fourcc == 0x56595559 && frame.info.stride_bytes == 1280);
        assert_true(frame.info.sequence == s.frames[i].sequence && frame.info.t_ns == s.frames[i].t_ns);
        assert_close(frame.info.table_measured_deg, s.frames[i].table_measured_deg, 0);
        if (i == 1)
            assert_memory_equal(frame.mask, "mask of b", 9);
        else
            assert_null(frame.mask);
    }
    assert_fails(sheen_source_next(src, 1000, &frame, &err), err, SHEEN_EEND, "over");
    sheen_source_close(&src);
    assert_null(src);
    sheen_source_close(&src);
    sheen_session_release(&s);
}

static void replays_one_role(void **state)
{
    sheen_session s;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    make_recording(&s, state);
    open_replay(&src, &s, "?role=input");
    assert_int_equal(sheen_source_count(src), 2);
    assert_ok(sheen_source_next(src, 0, &frame, &err), err);
    assert_string_equal(frame.info.name, "a");
    assert_ok(sheen_source_next(src, 0, &frame, &err), err);
    assert_string_equal(frame.info.name, "c");
    assert_fails(sheen_source_next(src, 0, &frame, &err), err, SHEEN_EEND, "");
    sheen_source_close(&src);
    sheen_session_release(&s);
}

static void a_stopped_source_says_so(void **state)
{
    sheen_session s;
    sheen_source *src;
    sheen_frame frame;
    sheen_err err;
    make_recording(&s, state);
    open_replay(&src, &s, "");
    sheen_source_stop(src);
    assert_fails(sheen_source_next(src, 0, &frame, &err), err, SHEEN_ECANCEL, "stopped");
    sheen_source_close(&src);
    sheen_session_release(&s);
}

static void says_what_is_wrong_with_a_uri(void **state)
{
    sheen_session s;
    char empty[SHEEN_PATH_MAX + 16], role[SHEEN_PATH_MAX + 64], option[SHEEN_PATH_MAX + 64];
    make_session(&s, state, "empty");
    snprintf(empty, sizeof empty, "replay:%s", s.path);
    snprintf(role, sizeof role, "replay:%s?role=king", s.path);
    snprintf(option, sizeof option, "replay:%s?speed=2", s.path);
    const struct {
        const char *uri;
        sheen_status code;
        const char *says;
    } cases[] = {
        {"nope:x", SHEEN_EARG, "unknown kind of source 'nope:x'"},
        {"", SHEEN_EARG, "unknown kind of source ''"},
        {"replay", SHEEN_EARG, "unknown kind of source 'replay'"},
        {"replay:", SHEEN_EARG, "names nothing"},
        {"repl:x", SHEEN_EARG, "unknown kind"},
        {"v4l2:/nowhere/video0", SHEEN_ENODEV, "there is no '/nowhere/video0'"},
        {"v4l2:/dev/null", SHEEN_EUNSUP, "'/dev/null' is no camera"},
        {"v4l2:?size=2x2", SHEEN_EARG, "names no camera"},
#ifdef SHEEN_LIBCAMERA
        {"libcamera:no/such", SHEEN_ENODEV, "'no/such' is none"},
#else
        {"libcamera:0", SHEEN_EUNSUP, "no support for 'libcamera:0'"},
#endif
        {"replay:/nowhere/at/all", SHEEN_EIO, "cannot open source 'replay:/nowhere/at/all'"},
        {empty, SHEEN_EDATA, "no frames"},
        {role, SHEEN_EARG, "unknown role 'king'"},
        {option, SHEEN_EARG, "unknown option '?speed=2'"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_source *src;
        sheen_err err;
        assert_fails(sheen_source_open(&src, cases[i].uri, &err), err, cases[i].code, cases[i].says);
        assert_null(src);
    }
    sheen_session_release(&s);
}

static void assert_same_frames(const sheen_session *a, const sheen_session *b)
{
    assert_int_equal(a->n_frames, b->n_frames);
    for (size_t i = 0; i < a->n_frames; i++)
        assert_memory_equal(&a->frames[i], &b->frames[i], sizeof a->frames[i]);
}

static void records_once(void **state)
{
    sheen_session s, t;
    sheen_source *src;
    sheen_err err;
    sheen_record_report report;
    const sheen_record_options options = {0}, two = {.count = 2};
    make_recording(&s, state);
    make_session(&t, state, "copy");
    open_replay(&src, &s, "");
    assert_ok(sheen_record(&t, src, &two, &report, &err), err);
    assert_true(report.n_recorded == 2 && !report.n_present);
    sheen_source_close(&src);
    open_replay(&src, &s, ""); // goes on where it was
    assert_ok(sheen_record(&t, src, &options, &report, &err), err);
    assert_true(report.n_recorded == 1 && report.n_present == 2);
    sheen_source_close(&src);
    assert_same_frames(&s, &t);
    assert_true(sheen_session_has(&t, "masks/b.png") && !sheen_session_has(&t, "masks/a.png"));
    sheen_session_release(&t);
    sheen_session_release(&s);
}

static void another_frame_of_a_taken_name_gets_a_number(void **state)
{
    sheen_session s, t;
    sheen_source *src;
    sheen_err err;
    sheen_record_report report;
    const sheen_record_options options = {.set_role = true, .role = SHEEN_ROLE_CALIBRATION};
    make_recording(&s, state);
    make_session(&t, state, "copy");
    add(&t, "b", SHEEN_ROLE_INPUT, 99);
    open_replay(&src, &s, "?role=test");
    assert_ok(sheen_record(&t, src, &options, &report, &err), err);
    sheen_source_close(&src);
    assert_int_equal(report.n_recorded, 1);
    assert_int_equal(t.n_frames, 2);
    assert_string_equal(t.frames[0].name, "000000");
    assert_int_equal(t.frames[0].role, SHEEN_ROLE_CALIBRATION);
    assert_true(sheen_session_has(&t, "masks/000000.png"));
    sheen_session_release(&t);
    sheen_session_release(&s);
}

static bool stop_at_two(void *self, const char *what, int done, int total)
{
    assert_string_equal(what, "recording");
    assert_int_equal(total, 3);
    *(int *)self = done;
    return done < 2;
}

static void a_cancelled_recording_keeps_what_it_has(void **state)
{
    sheen_session s, t;
    sheen_source *src;
    sheen_err err;
    sheen_record_report report;
    int done = -1;
    const sheen_record_options options = {.progress = {.step = stop_at_two, .self = &done}};
    make_recording(&s, state);
    make_session(&t, state, "copy");
    open_replay(&src, &s, "");
    assert_fails(sheen_record(&t, src, &options, &report, &err), err, SHEEN_ECANCEL, "recording");
    sheen_source_close(&src);
    assert_int_equal(done, 2);
    assert_int_equal(report.n_recorded, 2);
    assert_int_equal(t.n_frames, 2);
    sheen_session_release(&t);
    sheen_session_release(&s);
}

static void a_damaged_recording_stops_at_the_damage(void **state)
{
    sheen_session s, t;
    sheen_source *src;
    sheen_err err;
    sheen_record_report report;
    char path[SHEEN_PATH_MAX];
    const sheen_record_options options = {0};
    make_recording(&s, state);
    make_session(&t, state, "copy");
    assert_ok(sheen_session_path(path, &s, "frames/b.raw", &err), err);
    test_file_write_text(path, "cut");
    open_replay(&src, &s, "");
    assert_fails(sheen_record(&t, src, &options, &report, &err), err, SHEEN_EFORMAT, "frames/b.raw");
    sheen_source_close(&src);
    assert_int_equal(t.n_frames, 1);
    sheen_session_release(&t);
    sheen_session_release(&s);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(replays_every_frame_as_it_was),
        WITH_SCRATCH(replays_one_role),
        WITH_SCRATCH(a_stopped_source_says_so),
        WITH_SCRATCH(says_what_is_wrong_with_a_uri),
        WITH_SCRATCH(records_once),
        WITH_SCRATCH(another_frame_of_a_taken_name_gets_a_number),
        WITH_SCRATCH(a_cancelled_recording_keeps_what_it_has),
        WITH_SCRATCH(a_damaged_recording_stops_at_the_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
