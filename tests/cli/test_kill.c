// SPDX-License-Identifier: Apache-2.0
// test_kill.c - the program is killed at random instants; the session opens, has whole frames only, and goes on.
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/session.h"
#include "capture/import.h"
#include "tests/capture/fixtures.h"
#include "tests/support.h"

enum { N_FRAMES = 12, N_KILLS = 40, W = 24, H = 16 };

static void sleep_s(double s)
{
    struct timespec t = {(time_t)s, (long)(1e9 * (s - (double)(time_t)s))};
    nanosleep(&t, NULL);
}

// Starts the program without a voice.
static pid_t start(char *const *argv)
{
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid)
        return pid;
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    execv(SHEEN_PROGRAM, argv);
    _exit(127);
}

// Waits for its end: its exit code, or -1 where a signal ended it.
static int finish(pid_t pid)
{
    int how;
    assert_true(waitpid(pid, &how, 0) == pid);
    return WIFEXITED(how) ? WEXITSTATUS(how) : -1;
}

// Runs the program, and sends it a signal after so many seconds.
static int run_with_signal(char *const *argv, int number, double after_s)
{
    const pid_t pid = start(argv);
    sleep_s(after_s);
    kill(pid, number);
    return finish(pid);
}

static int run(char *const *argv)
{
    return finish(start(argv));
}

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Opens the session and reads every frame that it lists; returns how many. A session that does not exist yet has none.
static size_t check_session(const char *path)
{
    sheen_session s;
    sheen_err err;
    char manifest[TEST_PATH_MAX];
    snprintf(manifest, sizeof manifest, "%.400s/session.json", path);
    if (!sheen_file_exists(manifest))
        return 0;
    assert_ok(sheen_session_open(&s, path, &err), err);
    for (size_t i = 0; i < s.n_frames; i++) {
        sheen_raster raster;
        sheen_image mask;
        assert_ok(sheen_session_raster(&raster, &s, &s.frames[i], &err), err);
        assert_ok(sheen_session_mask(&mask, &s, &s.frames[i], &err), err);
        assert_non_null(mask.data); // every frame of this test has one
        sheen_raster_release(&raster);
        sheen_image_release(&mask);
    }
    const size_t n = s.n_frames;
    sheen_session_release(&s);
    return n;
}

static void make_pictures(const test_scratch *scratch, char pictures[TEST_PATH_MAX],
                          char masks[TEST_PATH_MAX])
{
    sheen_err err;
    test_scratch_file(pictures, scratch, "pictures");
    test_scratch_file(masks, scratch, "masks");
    assert_ok(sheen_dir_make(pictures, &err), err);
    assert_ok(sheen_dir_make(masks, &err), err);
    for (int i = 0; i < N_FRAMES; i++) {
        char name[64], path[TEST_PATH_MAX];
        snprintf(name, sizeof name, "pictures/f%02d.png", i);
        test_scratch_file(path, scratch, name);
        fixture_picture(path, W, H, (unsigned)i, 0);
        snprintf(name, sizeof name, "masks/f%02d.png", i);
        test_scratch_file(path, scratch, name);
        fixture_mask(path, W, H);
    }
}

// Kills `argv`, which fills the session at `path` with N_FRAMES frames, again and again at random instants. all_or_nothing:
// there are never some of the frames only.
static void kill_often(char *const *argv, const char *path, bool all_or_nothing)
{
    sheen_err err;
    uint64_t seed = 1;
    int n_killed = 0, n_started = 0, n_partial = 0;
    const double start_s = now_s();
    assert_int_equal(run(argv), 0);
    const double whole_s = now_s() - start_s;
    assert_int_equal(check_session(path), N_FRAMES);
    while (n_killed < N_KILLS && n_started < 20 * N_KILLS) {
        assert_ok(sheen_dir_remove(path, &err), err);
        size_t n = 0;
        // The same session is killed on its way several times.
        while (n < N_FRAMES && n_killed < N_KILLS && n_started++ < 20 * N_KILLS) {
            const size_t n_before = n;
            if (run_with_signal(argv, SIGKILL, 1.2 * whole_s * test_random(&seed)) == -1)
                n_killed++;
            n = check_session(path);
            assert_true(n >= n_before); // what was there stays
            if (all_or_nothing)
                assert_true(n == 0 || n == N_FRAMES);
            n_partial += n > 0 && n < N_FRAMES;
        }
        assert_int_equal(run(argv), 0);
        assert_int_equal(check_session(path), N_FRAMES);
    }
    print_message("%d of %d runs of %.0f ms were killed, %d sessions were partly filled\n", n_killed,
                  n_started, 1e3 * whole_s, n_partial);
    assert_int_equal(n_killed, N_KILLS);
    if (!all_or_nothing)
        assert_true(n_partial > 0);
}

static void capture_survives_kills(void **state)
{
    char pictures[TEST_PATH_MAX], masks[TEST_PATH_MAX], recorded[TEST_PATH_MAX], session[TEST_PATH_MAX];
    char uri[TEST_PATH_MAX + 8];
    sheen_session s;
    sheen_err err;
    sheen_import_report report;
    make_pictures(*state, pictures, masks);
    test_scratch_file(recorded, *state, "recorded");
    test_scratch_file(session, *state, "session");
    const char *const images[] = {pictures};
    const sheen_import_options options = {.images = images, .n_images = 1, .masks = masks};
    assert_ok(sheen_session_create(&s, recorded, SHEEN_MOVING_CAMERA, &err), err);
    assert_ok(sheen_import(&s, &options, &report, &err), err);
    sheen_session_release(&s);
    snprintf(uri, sizeof uri, "replay:%s", recorded);
    char program[] = "sheen", command[] = "capture", device[] = "--device";
    char *const argv[] = {program, command, session, device, uri, NULL};
    kill_often(argv, session, false);
}

static void import_survives_kills(void **state)
{
    char pictures[TEST_PATH_MAX], masks_dir[TEST_PATH_MAX], session[TEST_PATH_MAX];
    make_pictures(*state, pictures, masks_dir);
    test_scratch_file(session, *state, "session");
    char program[] = "sheen", command[] = "import", masks[] = "--masks";
    char *const argv[] = {program, command, session, pictures, masks, masks_dir, NULL};
    kill_often(argv, session, true);
}

// Ctrl-C: exit code 1, the session stays usable, nothing half done.
static void an_interrupt_ends_cleanly(void **state)
{
    char pictures[TEST_PATH_MAX], masks_dir[TEST_PATH_MAX], session[TEST_PATH_MAX];
    make_pictures(*state, pictures, masks_dir);
    test_scratch_file(session, *state, "session");
    char program[] = "sheen", command[] = "import", masks[] = "--masks";
    char *const argv[] = {program, command, session, pictures, masks, masks_dir, NULL};
    int n_cancelled = 0;
    uint64_t seed = 3;
    const double start_s = now_s();
    assert_int_equal(run(argv), 0);
    const double whole_s = now_s() - start_s;
    for (int i = 0; i < 100 && n_cancelled < 3; i++) {
        sheen_err err;
        assert_ok(sheen_dir_remove(session, &err), err);
        const int code = run_with_signal(argv, SIGINT, whole_s * (0.2 + 0.8 * test_random(&seed)));
        const size_t n = check_session(session);
        if (code == 1) {
            n_cancelled++;
            assert_int_equal(n, 0);
            assert_false(sheen_dir_exists(session)); // it was made by this very command
        } else if (code == 0)
            assert_int_equal(n, N_FRAMES);
    }
    assert_int_equal(n_cancelled, 3);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(capture_survives_kills),
        WITH_SCRATCH(import_survives_kills),
        WITH_SCRATCH(an_interrupt_ends_cleanly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
