// SPDX-License-Identifier: Apache-2.0
// test_station.c - a day at the station, from outside: the program itself, a camera under it, a simulated controller with
// a table, and a person at a terminal.
#define _GNU_SOURCE // posix_openpt, ptsname
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/session.h"
#include "tests/fake/fake_grbl.h"
#include "tests/support.h"

typedef struct station {
    fake_grbl board;
    const test_scratch *scratch;
    int terminal; // the person's end
    pid_t program;
    char said[1 << 16];     // by the program, so far
    size_t n_said, n_heard; // bytes read; up to the last word that was waited for
} station;

static void build(station *st, const test_scratch *scratch)
{
    *st = (station){.scratch = scratch};
    fake_grbl_init(&st->board);
    st->board.speed_factor = 100;
    fake_grbl_start(&st->board);
}

// Starts "sheen capture <words>" with the camera and the table, in the scratch folder, at a terminal.
static void start(station *st, const char *words)
{
    char command[1200];
    st->terminal = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(st->terminal >= 0 && !grantpt(st->terminal) && !unlockpt(st->terminal));
    const char *name = ptsname(st->terminal);
    snprintf(command, sizeof command,
             "cd '%s' && exec '%s' - 'node=42;rate=60;width=64;height=48' '%s' capture %s --device "
             "'v4l2:/dev/video42?lock=off' --turntable '%s' --steps 4",
             st->scratch->path, WITH_CAMERA, SHEEN_PROGRAM, words, st->board.path);
    st->n_said = st->n_heard = 0;
    st->said[0] = '\0';
    st->program = fork();
    assert_true(st->program >= 0);
    if (!st->program) {
        setsid();
        const int fd = open(name, O_RDWR); // the first terminal that a session opens is its own: Ctrl-C works
        ioctl(fd, TIOCSCTTY, 0);
        dup2(fd, 0);
        dup2(fd, 1);
        dup2(fd, 2);
        execl("/bin/sh", "sh", "-c", command, (char *)NULL);
        _exit(127);
    }
}

// Reads what it says until `word` stands there after the word before; false: it ended without.
static bool says(station *st, const char *word)
{
    static const int most_ms = 60000;
    const char *found;
    struct pollfd p = {.fd = st->terminal, .events = POLLIN};
    while (!(found = strstr(st->said + st->n_heard, word))) {
        if (poll(&p, 1, most_ms) <= 0)
            return false;
        const ssize_t n = read(st->terminal, st->said + st->n_said, sizeof st->said - 1 - st->n_said);
        if (n <= 0) // the program is gone
            return false;
        st->n_said += (size_t)n;
        st->said[st->n_said] = '\0';
    }
    st->n_heard = (size_t)(found - st->said) + strlen(word);
    return true;
}

static void press(station *st, const char *keys)
{
    assert_int_equal(write(st->terminal, keys, strlen(keys)), strlen(keys));
}

#define assert_says(st, word)                                                                                \
    do {                                                                                                     \
        if (!says(st, word))                                                                                 \
            fail_msg("it does not say '%s':\n%s", word, (st)->said);                                         \
    } while (0)

// Its exit status, after all that it has to say.
static int end(station *st)
{
    int status;
    says(st, "\x01never");
    assert_int_equal(waitpid(st->program, &status, 0), st->program);
    close(st->terminal);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static size_t frames_in(const station *st, const char *name)
{
    char path[TEST_PATH_MAX];
    sheen_session s;
    sheen_err err;
    test_scratch_file(path, st->scratch, name);
    if (sheen_session_open(&s, path, &err))
        return 0;
    const size_t n = s.n_frames;
    sheen_session_release(&s);
    return n;
}

static void write_text(const station *st, const char *name, const char *text)
{
    char path[TEST_PATH_MAX];
    test_scratch_file(path, st->scratch, name);
    test_file_write_text(path, text);
}

static void a_batch_takes_one_key_an_object(void **state)
{
    station st;
    build(&st, *state);
    write_text(&st, "items.csv", "code,name\r\n111,cup\r\n,bowl\r\n333,\"jug\"\r\n");
    start(&st, "day --batch items.csv");
    assert_says(&st, "[0 of 3 done] put 'cup'");
    press(&st, "\n");
    assert_says(&st, "[1 of 3 done] put 'bowl'");
    press(&st, "333\n"); // the person has the jug in hand and scans it
    assert_says(&st, "[2 of 3 done] put 'bowl'");
    press(&st, "999\n");
    assert_says(&st, "not on the list");
    press(&st, "q\n");
    assert_int_equal(end(&st), 3);
    assert_non_null(strstr(st.said, "2 of 3 objects are complete"));
    assert_non_null(strstr(st.said, "bowl                     not begun"));
    assert_int_equal(frames_in(&st, "day/cup.session"), 4);
    assert_int_equal(frames_in(&st, "day/jug.session"), 4);
    start(&st, "day --batch items.csv"); // another day
    assert_says(&st, "[2 of 3 done] put 'bowl'");
    press(&st, "\n");
    assert_int_equal(end(&st), 0);
    assert_non_null(strstr(st.said, "3 of 3 objects are complete"));
    fake_grbl_stop(&st.board);
}

static void a_broken_object_is_summed_up_and_gone_on_with(void **state)
{
    station st;
    build(&st, *state);
    write_text(&st, "items.csv", "name\ncup\n");
    st.board.faults.alarm_at_move = 2;
    start(&st, "day --batch items.csv");
    assert_says(&st, "put 'cup'");
    press(&st, "\n");
    assert_says(&st, "is in alarm");
    assert_says(&st, "put 'cup'"); // again, or s
    press(&st, "s\n");
    assert_int_equal(end(&st), 3);
    assert_non_null(strstr(st.said, "cup                      2 of 4 frames missing: "));
    assert_int_equal(frames_in(&st, "day/cup.session"), 2);
    fake_grbl_stop(&st.board);
}

static void a_model_that_fails_is_no_fault_of_the_capture(void **state)
{
    station st;
    build(&st, *state);
    start(&st, "one --then run");
    assert_int_equal(end(&st), 1);
    assert_non_null(strstr(st.said, "4 frames recorded"));
    assert_non_null(strstr(st.said, "the capture is complete, but no model was made of it: "));
    write_text(&st, "items.csv", "name\ncup\n");
    start(&st, "day --batch items.csv --then run");
    assert_says(&st, "put 'cup'");
    press(&st, "\n");
    assert_int_equal(end(&st), 3);
    assert_non_null(strstr(st.said, "1 of 1 objects are complete"));
    assert_non_null(strstr(st.said, "cup                      no model: "));
    fake_grbl_stop(&st.board);
}

// The person is asked for the empty table, and then for the object, before the first step.
static void an_empty_table_comes_first(void **state)
{
    station st;
    build(&st, *state);
    start(&st, "empty --background");
    assert_says(&st, "take the object off");
    press(&st, "\n");
    assert_says(&st, "put the object on");
    press(&st, "\n");
    assert_int_equal(end(&st), 0);
    assert_int_equal(frames_in(&st, "empty"), 5);
    start(&st, "empty --background");
    assert_says(&st, "all 5 frames are there");
    assert_int_equal(end(&st), 0);
    fake_grbl_stop(&st.board);
}

static void keys_pause_and_end(void **state)
{
    station st;
    bool moving = true;
    build(&st, *state);
    start(&st, "keys --hook 'echo at $ACTION'");
    assert_says(&st, "at download");
    press(&st, "p");
    assert_says(&st, "paused");
    const double before_deg = fake_grbl_table_deg(&st.board, &moving);
    assert_false(moving);
    poll(NULL, 0, 500);
    assert_close(before_deg, fake_grbl_table_deg(&st.board, NULL), 1e-9);
    press(&st, "p");
    assert_says(&st, "it goes on");
    press(&st, "q");
    assert_int_equal(end(&st), 1);
    const size_t n = frames_in(&st, "keys");
    assert_true(n > 0 && n < 4);
    assert_non_null(strstr(st.said, "the same command goes on from there"));
    fake_grbl_stop(&st.board);
}

// In the middle of a move, by the key and by Ctrl-C.
static void it_stops_at_once(void **state)
{
    static const char *const keys[] = {"s", "\x03"};
    station st;
    build(&st, *state);
    st.board.speed_factor = 0.2; // 4 degrees a second
    for (int i = 0; i < 2; i++) {
        bool moving = false;
        start(&st, i ? "slow2" : "slow");
        assert_says(&st, "stops the turntable at once");
        while (fake_grbl_table_deg(&st.board, &moving), !moving)
            poll(NULL, 0, 20);
        press(&st, keys[i]);
        assert_int_equal(end(&st), 1);
        fake_grbl_table_deg(&st.board, &moving);
        assert_false(moving);
    }
    fake_grbl_stop(&st.board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_batch_takes_one_key_an_object, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_broken_object_is_summed_up_and_gone_on_with, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_model_that_fails_is_no_fault_of_the_capture, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(an_empty_table_comes_first, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(keys_pause_and_end, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(it_stops_at_once, test_scratch_setup, test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
