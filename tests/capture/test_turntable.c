// SPDX-License-Identifier: Apache-2.0
// test_turntable.c - the turntable's driver against a simulated Grbl controller, and that controller against Grbl's own
// documents.
#include "capture/turntable.h"

#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "capture/grbl_protocol.h"
#include "capture/serial_devices.h"
#include "tests/fake/fake_grbl.h"
#include "tests/support.h"

typedef struct station {
    fake_grbl board;
    sheen_table_options options;
    sheen_table *table;
    sheen_err err;
    int n_asked, stop_after; // stop_after: go_on says no from the n-th question on; 0: never
} station;

static bool go_on(void *self)
{
    station *s = self;
    s->n_asked++;
    return !s->stop_after || s->n_asked < s->stop_after;
}

static void plug(station *s)
{
    fake_grbl_init(&s->board);
    sheen_table_config_init(&s->options.config);
    s->options.config.speed_deg_s = 1000;
    s->options.go_on = go_on;
    s->options.self = s;
    s->options.greeting_ms = 60;
    s->options.poll_ms = 5;
    s->options.patience_ms = 2000;
    s->table = NULL;
}

static void open_at_zero(station *s)
{
    fake_grbl_start(&s->board);
    assert_ok(sheen_table_open(&s->table, s->board.path, &s->options, &s->err), s->err);
    assert_ok(sheen_table_set_angle(s->table, 0, &s->err), s->err);
}

static void unplug(station *s)
{
    sheen_table_close(&s->table);
    fake_grbl_stop(&s->board);
}

static void turns_to_angles_and_stands_there(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    open_at_zero(&s);
    const double angles[] = {30, 60, 45, 400, 0};
    for (size_t i = 0; i < 5; i++) {
        bool moving;
        sheen_table_state now;
        assert_ok(sheen_table_turn_to(s.table, angles[i], &s.err), s.err);
        assert_close(fake_grbl_table_deg(&s.board, &moving), angles[i], 0.004);
        assert_false(moving);
        assert_ok(sheen_table_get(&now, s.table, &s.err), s.err);
        assert_true(now.ready && now.angle_known);
        assert_close(now.angle_deg, angles[i], 0.004);
        assert_string_equal(now.what, "Idle");
    }
    unplug(&s);
}

// Thirds of a turn in a unit of 7.3 degrees: a hundred roundings must not add up.
static void rounding_does_not_add_up(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    s.board.true_deg_per_unit = s.options.config.degrees_per_unit = 7.3;
    s.options.config.speed_deg_s = 8000;
    open_at_zero(&s);
    for (int i = 1; i <= 30; i++)
        assert_ok(sheen_table_turn_to(s.table, i * 40.0 / 3, &s.err), s.err);
    assert_close(fake_grbl_table_deg(&s.board, NULL), 400, 7.3 / 250);
    unplug(&s);
}

static void direction_and_play_are_accounted_for(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    s.board.true_deg_per_unit = -2;
    s.board.play_deg = s.options.config.backlash_deg = 1.5;
    s.options.config.degrees_per_unit = 2;
    s.options.config.direction = -1;
    open_at_zero(&s);
    assert_ok(sheen_table_turn_to(s.table, 20, &s.err), s.err);
    const double at_20 = fake_grbl_table_deg(&s.board, NULL);
    const double angles[] = {60, 30, 20};
    for (size_t i = 0; i < 3; i++) {
        assert_ok(sheen_table_turn_to(s.table, angles[i], &s.err), s.err);
        assert_close(fake_grbl_table_deg(&s.board, NULL) - at_20, angles[i] - 20, 0.01);
    }
    unplug(&s);
}

static void refuses_to_turn_before_the_angle_is_known(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    fake_grbl_start(&s.board);
    assert_ok(sheen_table_open(&s.table, s.board.path, &s.options, &s.err), s.err);
    assert_fails(sheen_table_turn_to(s.table, 30, &s.err), s.err, SHEEN_EDATA, "angle is not known");
    assert_int_equal(s.board.n_moves, 0);
    unplug(&s);
}

static void boards_of_all_habits_are_understood(void **state)
{
    (void)state;
    for (int habit = 0; habit < 7; habit++) {
        station s = {0};
        plug(&s);
        s.board.resets_on_open = habit == 1;
        s.board.reports_work = habit == 2;
        s.board.work_offset = 12.5;
        s.board.settings[13] = habit == 3; // inches
        s.board.faults.noise = habit == 4;
        s.board.other_firmware = habit == 5;
        s.options.config.acceleration_deg_s2 = habit == 6 ? 400 : 0;
        open_at_zero(&s);
        assert_ok(sheen_table_turn_to(s.table, 90, &s.err), s.err);
        assert_close(fake_grbl_table_deg(&s.board, NULL), 90, 0.004);
        if (habit == 6)
            assert_close(s.board.settings[120], 400, 1e-9);
        unplug(&s);
    }
}

// The second opening must not reset a board that the first one left with HUPCL cleared.
static void closing_leaves_the_board_alone(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    s.board.resets_on_open = true;
    open_at_zero(&s);
    assert_ok(sheen_table_turn_to(s.table, 50, &s.err), s.err);
    sheen_table_close(&s.table);
    poll(NULL, 0, 20);
    assert_ok(sheen_table_open(&s.table, s.board.path, &s.options, &s.err), s.err);
    sheen_table_state now;
    assert_ok(sheen_table_get(&now, s.table, &s.err), s.err);
    assert_close(now.position_deg, 50, 0.004);
    assert_false(now.angle_known);
    unplug(&s);
}

// A failure half-way through the second move: what is said, and that the angle is not known afterwards.
static void fails_half_way(fake_grbl_faults faults, sheen_status code, const char *part)
{
    station s = {0};
    plug(&s);
    s.board.faults = faults;
    open_at_zero(&s);
    assert_ok(sheen_table_turn_to(s.table, 30, &s.err), s.err);
    assert_fails(sheen_table_turn_to(s.table, 60, &s.err), s.err, code, part);
    assert_fails(sheen_table_turn_to(s.table, 90, &s.err), s.err, SHEEN_EDATA, "not known");
    unplug(&s);
}

static void what_goes_wrong_is_said_and_the_angle_forgotten(void **state)
{
    (void)state;
    fails_half_way((fake_grbl_faults){.cut_at_move = 2}, SHEEN_ENODEV, "is gone");
    fails_half_way((fake_grbl_faults){.alarm_at_move = 2}, SHEEN_EIO, "a limit switch was touched");
    fails_half_way((fake_grbl_faults){.reset_at_move = 2}, SHEEN_EIO, "was reset");
    fails_half_way((fake_grbl_faults){.block_at_move = 2}, SHEEN_EIO, "is it blocked");
    fails_half_way((fake_grbl_faults){.stop_at_move = 2}, SHEEN_EIO, "stopped at 45");
}

static void an_alarm_is_ended_by_unlocking(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    s.board.homing_lock = true;
    fake_grbl_start(&s.board);
    assert_ok(sheen_table_open(&s.table, s.board.path, &s.options, &s.err), s.err);
    assert_ok(sheen_table_set_angle(s.table, 0, &s.err), s.err);
    assert_fails(sheen_table_turn_to(s.table, 30, &s.err), s.err, SHEEN_EIO, "--unlock");
    assert_ok(sheen_table_unlock(s.table, &s.err), s.err);
    assert_ok(sheen_table_set_angle(s.table, 0, &s.err), s.err);
    assert_ok(sheen_table_turn_to(s.table, 30, &s.err), s.err);
    unplug(&s);
}

static void homing_knows_the_angle(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    s.board.homing_lock = true;
    s.board.settings[22] = 1;
    fake_grbl_start(&s.board);
    assert_ok(sheen_table_open(&s.table, s.board.path, &s.options, &s.err), s.err);
    assert_ok(sheen_table_home(s.table, &s.err), s.err);
    assert_ok(sheen_table_turn_to(s.table, 30, &s.err), s.err);
    unplug(&s);
    plug(&s);
    open_at_zero(&s);
    assert_fails(sheen_table_home(s.table, &s.err), s.err, SHEEN_EARG, "homing is not switched on");
    unplug(&s);
}

static void stops_at_once_and_knows_where(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    s.options.config.speed_deg_s = 100;
    open_at_zero(&s);
    s.stop_after = 3;
    assert_fails(sheen_table_turn_to(s.table, 300, &s.err), s.err, SHEEN_ECANCEL, "stopped on the way");
    bool moving;
    sheen_table_state now;
    const double deg = fake_grbl_table_deg(&s.board, &moving);
    assert_false(moving);
    assert_true(deg < 150);
    assert_ok(sheen_table_get(&now, s.table, &s.err), s.err);
    assert_true(now.angle_known);
    assert_close(now.angle_deg, deg, 0.004);
    s.stop_after = 0;
    s.options.config.speed_deg_s = 1000;
    assert_ok(sheen_table_turn_to(s.table, deg + 20, &s.err), s.err);
    unplug(&s);
}

static void a_board_that_does_not_stop_is_reset_and_that_is_said(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    s.options.config.speed_deg_s = 20;
    s.board.faults.ignores_cancel = true;
    open_at_zero(&s);
    s.stop_after = 3;
    assert_fails(sheen_table_turn_to(s.table, 300, &s.err), s.err, SHEEN_ECANCEL, "was reset");
    poll(NULL, 0, 20);
    bool moving;
    assert_true(fake_grbl_table_deg(&s.board, &moving) < 150);
    assert_false(moving);
    assert_fails(sheen_table_turn_to(s.table, 30, &s.err), s.err, SHEEN_EDATA, "not known");
    unplug(&s);
}

static void refuses_what_cannot_be(void **state)
{
    (void)state;
    station s = {0};
    sheen_err *err = &s.err;
    plug(&s);
    assert_fails(sheen_table_open(&s.table, "/nowhere/tty", &s.options, err), s.err, SHEEN_ENODEV,
                 "no turntable");
    assert_fails(sheen_table_open(&s.table, "/dev/null", &s.options, err), s.err, SHEEN_EARG,
                 "not a serial line");
    assert_fails(sheen_table_open(&s.table, "manual:", &s.options, err), s.err, SHEEN_EUNSUP,
                 "nobody can be asked");
    s.options.config.baud = 12345;
    assert_fails(sheen_table_open(&s.table, "/dev/null", &s.options, err), s.err, SHEEN_EARG, "12345 baud");
    s.options.config.baud = 115200;
    s.board.faults.deaf = true;
    fake_grbl_start(&s.board);
    assert_fails(sheen_table_open(&s.table, s.board.path, &s.options, err), s.err, SHEEN_ETIMEOUT,
                 "speaks Grbl");
    fake_grbl_stop(&s.board);
    plug(&s);
    s.options.config.axis = 'A';
    fake_grbl_start(&s.board);
    assert_fails(sheen_table_open(&s.table, s.board.path, &s.options, err), s.err, SHEEN_EARG, "no axis A");
    fake_grbl_stop(&s.board);
    plug(&s);
    open_at_zero(&s);
    sheen_table *second;
    assert_fails(sheen_table_open(&second, s.board.path, &s.options, err), s.err, SHEEN_EACCESS,
                 "another program");
    s.board.settings[20] = 1;
    assert_fails(sheen_table_turn_to(s.table, 30, err), s.err, SHEEN_EARG, "outside the travel");
    sheen_table_state now; // refused is not lost: nothing moved
    assert_ok(sheen_table_get(&now, s.table, err), s.err);
    assert_true(now.angle_known);
    unplug(&s);
}

static void a_lost_answer_is_not_taken_for_the_next(void **state)
{
    (void)state;
    station s = {0};
    plug(&s);
    open_at_zero(&s);
    s.board.faults.swallows_ok = true;
    assert_fails(sheen_table_turn_to(s.table, 30, &s.err), s.err, SHEEN_ETIMEOUT, "did not answer");
    assert_fails(sheen_table_turn_to(s.table, 30, &s.err), s.err, SHEEN_EDATA, "not known");
    assert_ok(sheen_table_set_angle(s.table, 30, &s.err), s.err);
    assert_ok(sheen_table_turn_to(s.table, 60, &s.err), s.err);
    assert_close(fake_grbl_table_deg(&s.board, NULL), 60, 0.01);
    unplug(&s);
}

// ---- by hand

typedef struct person {
    double at_deg, clumsiness_deg;
    int n_turns;
} person;

static sheen_status turn(void *self, double delta_deg, double *position_deg, sheen_err *err)
{
    person *p = self;
    (void)err;
    p->n_turns++;
    p->at_deg += delta_deg + p->clumsiness_deg;
    *position_deg = p->at_deg;
    return SHEEN_OK;
}

static void a_person_turns_and_the_tags_say_how_far(void **state)
{
    (void)state;
    person p = {.clumsiness_deg = 0.7};
    sheen_table_options o = {.turn_by_hand = turn, .self = &p};
    sheen_table *table;
    sheen_table_state now;
    sheen_err err;
    assert_ok(sheen_table_open(&table, "manual:", &o, &err), err);
    assert_ok(sheen_table_set_angle(table, 10, &err), err);
    assert_ok(sheen_table_turn_to(table, 40, &err), err);
    assert_ok(sheen_table_get(&now, table, &err), err);
    assert_close(now.angle_deg, 40.7, 1e-9);
    assert_ok(sheen_table_turn_to(table, 70, &err), err); // asked for the rest, 29.3
    assert_ok(sheen_table_get(&now, table, &err), err);
    assert_close(now.angle_deg, 70.7, 1e-9);
    assert_fails(sheen_table_unlock(table, &err), err, SHEEN_EUNSUP, "no lock");
    sheen_table_close(&table);
}

// ---- which device

static void the_link_comes_first_and_a_choice_is_asked_for(void **state)
{
    (void)state;
    sheen_serial_device d[2] = {{.path = "/dev/ttyUSB0", .by_id = "/dev/serial/by-id/usb-a"},
                                {.path = "/dev/ttyACM0"}};
    char path[SHEEN_SERIAL_DEVICE_PATH];
    sheen_err err;
    assert_fails(sheen_serial_device_choose(path, d, 0, &err), err, SHEEN_ENODEV, "no turntable");
    assert_ok(sheen_serial_device_choose(path, d, 1, &err), err);
    assert_string_equal(path, "/dev/serial/by-id/usb-a");
    assert_fails(sheen_serial_device_choose(path, d, 2, &err), err, SHEEN_EDATA, "usb-a, /dev/ttyACM0");
    d[1].is_turntable = true;
    assert_ok(sheen_serial_device_choose(path, d, 2, &err), err);
    assert_string_equal(path, "/dev/sheen/turntable");
}

// ---- the file

static void the_file_keeps_what_was_measured(void **state)
{
    sheen_table_config c, d;
    sheen_err err;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, *state, "turntable.json");
    sheen_table_config_init(&c);
    c.axis = 'A';
    c.degrees_per_unit = 1.00025;
    c.direction = -1;
    c.backlash_deg = 0.125;
    c.axis_board[1] = 0.01;
    c.measured = true;
    assert_ok(sheen_table_config_save(&c, path, &err), err);
    assert_ok(sheen_table_config_load(&d, path, &err), err);
    assert_memory_equal(&c.degrees_per_unit, &d.degrees_per_unit, sizeof c.degrees_per_unit);
    assert_true(d.axis == 'A' && d.direction == -1 && d.measured && d.axis_board[1] == 0.01 &&
                d.backlash_deg == 0.125);
    static const char *const wrong[][2] = {
        {"{\"schema\": \"sheen-turntable/1\", \"axis\": \"Q\"}", "'axis'"},
        {"{\"schema\": \"sheen-turntable/1\", \"direction\": 0}", "'direction'"},
        {"{\"schema\": \"sheen-turntable/1\", \"degrees_per_unit\": 0}", "'degrees_per_unit'"},
        {"{\"schema\": \"sheen-turntable/1\", \"speed_deg_s\": 1e9}", "'speed_deg_s'"},
        {"{}", "schema"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_fails(sheen_table_config_parse(&d, wrong[i][0], strlen(wrong[i][0]), &err), err, SHEEN_EFORMAT,
                     wrong[i][1]);
}

// ---- lines

static sheen_grbl_line parsed(const char *text)
{
    sheen_grbl_line line;
    sheen_grbl_line_parse(&line, text, strlen(text));
    return line;
}

static void lines_of_the_documents_are_read(void **state)
{
    (void)state;
    assert_int_equal(parsed("ok").kind, SHEEN_GRBL_OK);
    assert_int_equal(parsed("okay").kind, SHEEN_GRBL_OTHER);
    assert_int_equal(parsed("error:20").number, 20);
    assert_int_equal(parsed("error: Bad").kind, SHEEN_GRBL_OTHER);
    assert_int_equal(parsed("ALARM:3").number, 3);
    assert_int_equal(parsed("Grbl 1.1h ['$' for help]").kind, SHEEN_GRBL_GREETING);
    assert_int_equal(parsed("GrblHAL 1.1f ['$' or '$HELP' for help]").kind, SHEEN_GRBL_GREETING);
    assert_string_equal(parsed("[MSG:Caution: Unlocked]").text, "MSG:Caution: Unlocked");
    sheen_grbl_line l = parsed("$110=500.000");
    assert_true(l.kind == SHEEN_GRBL_SETTING && l.number == 110 && l.value == 500);
    assert_int_equal(parsed("$N0=G54").kind, SHEEN_GRBL_OTHER);
    l = parsed("<Hold:1|WPos:1.000,-2.500,0.000,7.25|Bf:15,128|FS:500,0|WCO:0.5,0,0,1>");
    assert_true(l.kind == SHEEN_GRBL_STATUS && l.state == SHEEN_GRBL_HOLD && l.n_machine == 0 &&
                l.n_work == 4);
    assert_true(l.work[1] == -2.5 && l.work[3] == 7.25 && l.n_offset == 4 && l.offset[3] == 1);
    assert_int_equal(parsed("<Tool|MPos:1,2,3>").state, SHEEN_GRBL_UNKNOWN);
    assert_int_equal(parsed("<Idle|MPos:1,,x>").n_machine, 0);
    assert_int_equal(parsed("<Idle|MPos:1,2,3").kind, SHEEN_GRBL_OTHER);
}

// ---- the simulated controller against Grbl's documents

// Sends text to the board and gathers what it says, lines joined by '|', until it has said `wanted` and then nothing for
// a moment.
static void converse(char *said, size_t size_bytes, int fd, const char *text, const char *wanted)
{
    size_t n = 0;
    int n_quiet = 0;
    assert_true(write(fd, text, strlen(text)) == (ssize_t)strlen(text));
    said[0] = '\0';
    while (n_quiet < (*wanted && !strstr(said, wanted) ? 100 : 1)) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        char c;
        if (poll(&p, 1, 20) < 1 || read(fd, &c, 1) != 1) {
            n_quiet++;
            continue;
        }
        n_quiet = 0;
        if (c != '\r' && n + 1 < size_bytes)
            said[n++] = c == '\n' ? '|' : c;
        said[n] = '\0';
    }
}

typedef struct claim {
    const char *document, *says; // where, and in our words what
    const char *sent, *heard;    // heard: must occur in the answer; "": nothing may come
} claim;

// Each in turn on the same board, which stands at 0.
static const claim claims[] = {
    {"interface, streaming", "an empty line is answered by ok", "\n", "ok|"},
    {"interface, streaming", "one answer a line, in order", "\n\n$Q\n", "ok|ok|error:"},
    {"interface, response", "an unknown system command is an error", "$J\n", "error:3|"},
    {"csv, error 1", "a word begins with a letter", "10\n", "error:1|"},
    {"csv, error 2", "and goes on with a number", "GX\n", "error:2|"},
    {"csv, error 20", "G-code that it does not have", "G5\n", "error:20|"},
    {"csv, error 11", "a line longer than its buffer is not carried out",
     "G4P0.01(no)G4P0.01G4P0.01G4P0.01G4P0.01G4P0.01G4P0.01G4P0.01G4P0.01G4P0.01G4P0.01G4P0.01\n",
     "error:11|"},
    {"interface, parsing", "case, spaces and comments do not count", "g4 p0.001 ; wait\n", "ok|"},
    {"commands, ?", "a report at once, without ok, also in the middle of a line", "?",
     "<Idle|MPos:0.000,0.000,0.000|"},
    {"commands, $$", "settings, then one ok", "$$\n", "$110=72000.000|"},
    {"commands, $x=", "a setting is stored and answered", "$120=250\n", "ok|"},
    {"csv, error 4", "not a negative one", "$120=-1\n", "error:4|"},
    {"csv, error 5", "homing wants to be switched on", "$H\n", "error:5|"},
    {"csv, error 10", "soft limits want homing", "$20=1\n", "error:10|"},
    {"jogging", "a jog wants a feed rate", "$J=X10\n", "error:22|"},
    {"csv, error 16", "and takes no other G-codes", "$J=G1X10F100\n", "error:16|"},
    {"jogging", "ok when it is planned, not when it is done; state Jog meanwhile", "$J=G91X300F600\n?",
     "ok|<Jog|"},
    {"csv, error 9", "no G-code while it jogs", "G4P0.01\n", "error:9|"},
    {"csv, error 8", "nor what wants it idle", "$H\n", "error:8|"},
    {"jogging", "a jog cancel ends it where it is, without an answer", "\x85", ""},
    {"jogging", "and then it is Idle", "?", "<Idle|"},
    {"jogging", "a jog cancel does nothing when it is idle", "\x85?", "<Idle|"},
    {"jogging", "G53 is in machine coordinates", "$J=G53G90X0F60000\n", "ok|"},
    {"interface, dwell", "the dwell is answered when it is over", "G4P0.01\n", "ok|"},
    {"commands, !", "a hold when idle suspends it", "!?", "<Hold:0|"},
    {"csv, error 8", "and then it takes no jog", "$J=X10F100\n", "error:8|"},
    {"commands, ~", "until it is resumed", "~?", "<Idle|"},
    {"commands, 0x18", "a reset when it stands keeps it ready", "\x18", "Grbl 1.1h"},
    {"commands, 0x18", "a reset while it moves is alarm 3, then the greeting and the reminder",
     "$J=G91X300F600\n\x18", "ok|ALARM:3||Grbl 1.1h ['$' for help]|[MSG:'$H'|'$X' to unlock]|"},
    {"csv, error 9", "no G-code in alarm", "G4P0.01\n", "error:9|"},
    {"csv, error 8", "no jog in alarm", "$J=X10F100\n", "error:8|"},
    {"commands, $X", "unlocked, with a warning before the ok", "$X\n", "[MSG:Caution: Unlocked]|ok|"},
    {"commands, $SLP", "asleep until a reset", "$SLP\n?", "[MSG:Sleeping]|ok|<Sleep|"},
};

static void the_simulated_controller_does_what_the_documents_say(void **state)
{
    (void)state;
    fake_grbl board;
    char said[1024];
    fake_grbl_init(&board);
    fake_grbl_start(&board);
    const int fd = open(board.path, O_RDWR | O_NOCTTY);
    assert_true(fd >= 0);
    for (size_t i = 0; i < sizeof claims / sizeof *claims; i++) {
        const claim *c = &claims[i];
        converse(said, sizeof said, fd, c->sent, c->heard);
        if (*c->heard ? !strstr(said, c->heard) : *said != '\0')
            fail_msg("%s: %s: heard '%s'", c->document, c->says, said);
    }
    close(fd);
    fake_grbl_stop(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turns_to_angles_and_stands_there),
        cmocka_unit_test(rounding_does_not_add_up),
        cmocka_unit_test(direction_and_play_are_accounted_for),
        cmocka_unit_test(refuses_to_turn_before_the_angle_is_known),
        cmocka_unit_test(boards_of_all_habits_are_understood),
        cmocka_unit_test(closing_leaves_the_board_alone),
        cmocka_unit_test(what_goes_wrong_is_said_and_the_angle_forgotten),
        cmocka_unit_test(an_alarm_is_ended_by_unlocking),
        cmocka_unit_test(homing_knows_the_angle),
        cmocka_unit_test(stops_at_once_and_knows_where),
        cmocka_unit_test(a_board_that_does_not_stop_is_reset_and_that_is_said),
        cmocka_unit_test(refuses_what_cannot_be),
        cmocka_unit_test(a_lost_answer_is_not_taken_for_the_next),
        cmocka_unit_test(a_person_turns_and_the_tags_say_how_far),
        cmocka_unit_test(the_link_comes_first_and_a_choice_is_asked_for),
        cmocka_unit_test_setup_teardown(the_file_keeps_what_was_measured, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(lines_of_the_documents_are_read),
        cmocka_unit_test(the_simulated_controller_does_what_the_documents_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
