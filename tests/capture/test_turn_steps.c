// SPDX-License-Identifier: Apache-2.0
// test_turn_steps.c - a station without hardware: a simulated controller turns a table, a camera films it, and a session
// fills; the cable is pulled at every step in turn.
#include "capture/turn_steps.h"

#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "capture/source_backend.h"
#include "tests/fake/fake_grbl.h"
#include "tests/support.h"

enum { WIDTH = 64, HEIGHT = 48, LAG = 3, STEPS = 6 };

// A camera whose picture follows the table: a wave whose phase is the angle. What it gives was exposed LAG frames ago.
typedef struct film {
    fake_grbl *board;
    uint8_t pixels[LAG + 1][WIDTH * HEIGHT * 3];
    int64_t t_ns[LAG + 1];
    int64_t n;
} film;

static double wave(double angle_deg, int x)
{
    return 0.5 + 0.4 * sin((angle_deg + 360.0 * x / WIDTH) * 3.14159265358979323846 / 180);
}

static void expose(film *f)
{
    const int slot = (int)(f->n++ % (LAG + 1));
    f->t_ns[slot] = sheen_clock_ns();
    const double angle_deg = fake_grbl_table_deg(f->board, NULL);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        f->pixels[slot][i] = (uint8_t)lround(255 * wave(angle_deg, i / 3 % WIDTH));
}

static sheen_status film_next(void *self, int timeout_ms, sheen_frame *frame, sheen_err *err)
{
    film *f = self;
    (void)timeout_ms;
    (void)err;
    do {
        poll(NULL, 0, 4);
        expose(f);
    } while (f->n <= LAG);
    const int slot = (int)(f->n % (LAG + 1)); // the oldest
    frame->extension = "raw";
    frame->data = f->pixels[slot];
    frame->size_bytes = sizeof f->pixels[slot];
    frame->info.width_px = WIDTH;
    frame->info.height_px = HEIGHT;
    frame->info.stride_bytes = 3 * WIDTH;
    frame->info.fourcc = 0x33424752; // RGB3
    frame->info.transfer = SHEEN_TRANSFER_LINEAR;
    frame->info.t_ns = f->t_ns[slot];
    frame->info.sequence = f->n;
    return SHEEN_OK;
}

static void film_close(void *self)
{
    free(self);
}

static void film_counters(sheen_source_counts *out, const void *self)
{
    out->n_frames = ((const film *)self)->n;
}

static const sheen_source_backend films = {
    .scheme = "film", .next = film_next, .counters = film_counters, .close = film_close};

// The angle in a picture, from the wave's phase.
static double angle_in(const uint8_t *rgb)
{
    double s = 0, c = 0;
    for (int x = 0; x < WIDTH; x++) {
        const double phase = 2 * 3.14159265358979323846 * x / WIDTH, y = rgb[3 * x] / 255.0 - 0.5;
        s += y * cos(phase);
        c += y * sin(phase);
    }
    return atan2(s, c) * 180 / 3.14159265358979323846;
}

typedef struct station {
    fake_grbl board;
    sheen_session session;
    sheen_table *table;
    sheen_source *camera;
    sheen_turn_options o;
    sheen_table_options to;
    int n_rounds_asked, stop_after;
    int n_off, n_on; // times that the object was asked to be taken off, and put on
    bool blind;
} station;

static sheen_status see(void *self, const sheen_frame *frame, const sheen_frame_info *reference,
                        double *angle_deg, sheen_err *err)
{
    station *st = self;
    double from_deg = 0;
    if (st->blind)
        return sheen_fail(err, SHEEN_EDATA, "no board");
    if (reference) {
        uint8_t *data;
        size_t size_bytes;
        const sheen_status s = sheen_session_payload(&data, &size_bytes, &st->session, reference, err);
        if (s)
            return s;
        from_deg = angle_in(data);
        free(data);
    }
    *angle_deg = reference ? angle_in(frame->data) - from_deg : 0;
    *angle_deg -= 360 * round(*angle_deg / 360);
    return SHEEN_OK;
}

static sheen_status next_round(void *self, int i_round, sheen_err *err)
{
    station *st = self;
    (void)err;
    assert_int_equal(i_round, 2);
    st->n_rounds_asked++;
    return SHEEN_OK;
}

static sheen_status place_object(void *self, bool on, sheen_err *err)
{
    station *st = self;
    (void)err;
    st->n_off += !on;
    st->n_on += on;
    return SHEEN_OK;
}

static bool go_on(void *self)
{
    station *st = self;
    return !st->stop_after || --st->stop_after > 0;
}

static void build(station *st, const test_scratch *scratch, const char *name)
{
    sheen_err err;
    char path[TEST_PATH_MAX];
    *st = (station){.o = {.n_steps = STEPS, .n_rounds = 1, .see = see, .next_round = next_round}};
    fake_grbl_init(&st->board);
    sheen_table_config_init(&st->to.config);
    st->to.config.speed_deg_s = 2000;
    st->to.greeting_ms = 30;
    st->to.poll_ms = 3;
    st->to.patience_ms = 6000;
    st->to.go_on = go_on;
    st->to.self = st->o.self = st;
    test_scratch_file(path, scratch, name);
    assert_ok(sheen_session_create(&st->session, path, SHEEN_MOVING_OBJECT, &err), err);
}

// One run of the program: opens the table and the camera, records what is missing, closes them.
static sheen_status record_once(station *st, sheen_err *err)
{
    sheen_turn_steps steps;
    sheen_record_report report;
    film *f = calloc(1, sizeof *f);
    f->board = &st->board;
    fake_grbl_start(&st->board);
    sheen_status s = sheen_table_open(&st->table, st->board.path, &st->to, err);
    assert_ok(sheen_source_adopt(&st->camera, &films, f, err), *err);
    if (!s) {
        assert_ok(sheen_turn_steps_init(&steps, &st->session, st->table, &st->o, err), *err);
        const sheen_record_options o = {.count = sheen_turn_steps_missing(&st->session, &st->o),
                                        .policy = sheen_turn_steps_policy(&steps)};
        s = sheen_record(&st->session, st->camera, &o, &report, err);
        sheen_turn_steps_release(&steps);
    }
    sheen_table_close(&st->table);
    sheen_source_close(&st->camera);
    fake_grbl_stop(&st->board);
    return s;
}

static void check_complete(station *st)
{
    sheen_err err;
    assert_int_equal(st->session.n_frames, STEPS * st->o.n_rounds);
    for (size_t i = 0; i < st->session.n_frames; i++) {
        const sheen_frame_info *f = &st->session.frames[i];
        const sheen_frame_info *first = &st->session.frames[i / STEPS * STEPS];
        uint8_t *data, *zero;
        size_t size_bytes;
        assert_close(f->table_asked_deg, 360.0 / STEPS * (double)(i % STEPS), 1e-9);
        assert_ok(sheen_session_payload(&data, &size_bytes, &st->session, f, &err), err);
        assert_ok(sheen_session_payload(&zero, &size_bytes, &st->session, first, &err), err);
        const double off = angle_in(data) - angle_in(zero) - f->table_asked_deg;
        assert_close(off - 360 * round(off / 360), 0, 0.3); // the picture itself, as well as 8 bits show it
        if (!st->blind)
            assert_close(f->table_measured_deg, f->table_asked_deg, 0.3);
        free(data);
        free(zero);
    }
}

static void a_turn_is_recorded_step_by_step(void **state)
{
    station st;
    sheen_err err;
    build(&st, *state, "turn.session");
    assert_ok(record_once(&st, &err), err);
    check_complete(&st);
    assert_int_equal(sheen_turn_steps_missing(&st.session, &st.o), 0);
    sheen_session_release(&st.session);
}

static void a_second_round_asks_for_the_camera(void **state)
{
    station st;
    sheen_err err;
    build(&st, *state, "rounds.session");
    st.o.n_rounds = 2;
    assert_ok(record_once(&st, &err), err);
    check_complete(&st);
    assert_int_equal(st.n_rounds_asked, 1);
    sheen_session_release(&st.session);
}

// The angle that a frame's picture shows.
static double angle_of(station *st, const char *name)
{
    sheen_err err;
    uint8_t *data;
    size_t size_bytes;
    const sheen_frame_info *f = sheen_session_find(&st->session, name);
    assert_non_null(f);
    assert_ok(sheen_session_payload(&data, &size_bytes, &st->session, f, &err), err);
    const double angle_deg = angle_in(data);
    free(data);
    return angle_deg;
}

// Two rounds, and before them the empty table at the place of the first step; also where the cable is pulled. The object is put on
// once, and stays.
static void a_recording_begins_with_the_empty_table(void **state)
{
    for (int cut = 0; cut < 2; cut++) {
        station st;
        sheen_err err;
        build(&st, *state, cut ? "cut-empty.session" : "empty.session");
        st.o.place_object = place_object;
        st.o.n_rounds = 2;
        assert_int_equal(sheen_turn_steps_missing(&st.session, &st.o), 1 + 2 * STEPS);
        if (cut) {
            st.board.faults.cut_at_move = 2;
            assert_fails(record_once(&st, &err), err, SHEEN_ENODEV, "is gone");
            st.board.faults = (fake_grbl_faults){0};
        }
        assert_ok(record_once(&st, &err), err);
        assert_int_equal(sheen_turn_steps_missing(&st.session, &st.o), 0);
        assert_int_equal(sheen_session_count_role(&st.session, SHEEN_ROLE_BACKGROUND), 1);
        assert_int_equal(sheen_session_count_role(&st.session, SHEEN_ROLE_INPUT), 2 * STEPS);
        assert_true(st.n_on == 1 && st.n_off == 1);
        assert_int_equal(sheen_frame_round(sheen_session_find(&st.session, "r1-empty")), 1);
        const double off = angle_of(&st, "r1-empty") - angle_of(&st, "r1-000");
        assert_close(off - 360 * round(off / 360), 0, 0.3);
        sheen_session_release(&st.session);
    }
}

// Who stands on the table already is not taken off again.
static void an_object_that_was_recorded_is_left_alone(void **state)
{
    station st;
    sheen_turn_steps steps;
    sheen_err err;
    build(&st, *state, "begun.session");
    assert_ok(record_once(&st, &err), err);
    st.o.place_object = place_object;
    st.o.n_rounds = 2;
    assert_fails(sheen_turn_steps_init(&steps, &st.session, st.table, &st.o, &err), err, SHEEN_EARG,
                 "taken first");
    sheen_session_release(&st.session);
}

// The commanded angles tie the rounds together: the same one is the same place of the table, also where the program was
// started anew in between and the table had been turned by hand.
static void angles_count_on_from_round_to_round(void **state)
{
    for (int broken = 0; broken < 2; broken++) {
        station st;
        sheen_err err;
        build(&st, *state, broken ? "tied.session" : "tied2.session");
        if (broken) {
            assert_ok(record_once(&st, &err), err);
            fake_grbl_push(&st.board, 77);
        }
        st.o.n_rounds = 2;
        assert_ok(record_once(&st, &err), err);
        check_complete(&st);
        const double off = angle_of(&st, "r2-002") - angle_of(&st, "r1-002");
        assert_close(off - 360 * round(off / 360), 0, 0.6);
        sheen_session_release(&st.session);
    }
}

static void a_cable_pulled_at_any_step_costs_nothing(void **state)
{
    for (int at = 1; at < STEPS; at++)
        for (int kind = 0; kind < 2; kind++) {
            station st;
            sheen_err err;
            char name[64];
            snprintf(name, sizeof name, "cut%d%d.session", at, kind);
            build(&st, *state, name);
            if (kind)
                st.board.faults.cut_at_line = 1 + 2 * at; // as the jog or the dwell arrives
            else
                st.board.faults.cut_at_move = at; // half-way
            assert_fails(record_once(&st, &err), err, SHEEN_ENODEV, "is gone");
            assert_true(st.session.n_frames < STEPS);
            st.board.faults = (fake_grbl_faults){0};
            assert_ok(record_once(&st, &err), err); // powered up anew, the table somewhere between two steps
            check_complete(&st);
            sheen_session_release(&st.session);
        }
}

static void cancelled_and_gone_on_with(void **state)
{
    station st;
    sheen_err err;
    build(&st, *state, "cancel.session");
    st.stop_after = 12;
    assert_fails(record_once(&st, &err), err, SHEEN_ECANCEL, "stopped on the way");
    assert_true(st.session.n_frames < STEPS);
    st.stop_after = 0;
    assert_ok(record_once(&st, &err), err);
    check_complete(&st);
    sheen_session_release(&st.session);
}

static void a_table_that_slips_is_found_out(void **state)
{
    station st;
    sheen_err err;
    build(&st, *state, "slip.session");
    st.board.faults.slip_at_move = 3;
    assert_fails(record_once(&st, &err), err, SHEEN_EDATA, "the tags show 120");
    assert_int_equal(st.session.n_frames, 3);
    st.board.faults.slip_at_move = 0;
    assert_ok(record_once(&st, &err), err);
    check_complete(&st);
    sheen_session_release(&st.session);
}

static void without_tags_a_turn_is_recorded_but_not_gone_on_with(void **state)
{
    station st;
    sheen_err err;
    build(&st, *state, "blind.session");
    st.o.see = NULL;
    st.blind = true;
    st.board.faults.cut_at_move = 3;
    assert_fails(record_once(&st, &err), err, SHEEN_ENODEV, "is gone");
    assert_int_equal(st.session.n_frames, 3);
    assert_true(isnan(st.session.frames[1].table_measured_deg));
    st.board.faults.cut_at_move = 0;
    assert_fails(record_once(&st, &err), err, SHEEN_EDATA, "nothing can see it");
    sheen_session_release(&st.session);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_turn_is_recorded_step_by_step, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_second_round_asks_for_the_camera, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_recording_begins_with_the_empty_table, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(an_object_that_was_recorded_is_left_alone, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(angles_count_on_from_round_to_round, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_cable_pulled_at_any_step_costs_nothing, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(cancelled_and_gone_on_with, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_table_that_slips_is_found_out, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(without_tags_a_turn_is_recorded_but_not_gone_on_with,
                                        test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
