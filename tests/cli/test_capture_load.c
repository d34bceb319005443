// SPDX-License-Identifier: Apache-2.0
// test_capture_load.c - a capture under load: a minute at full rate, a slow disk, a full one, and 200 kills.
//
// The camera is the fake one on the machine's clock; its own work is part of the processor time that is printed.
#define _GNU_SOURCE // unshare
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/image_file.h"
#include "base/session.h"
#include "capture/record.h"
#include "capture/v4l2_source.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

enum { W = 1280, H = 720, N_PICTURES = 15, RATE = 30, N_KILLS = 200 };

static int64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void make_session(sheen_session *s, const char *dir, const char *name)
{
    char path[TEST_PATH_MAX];
    sheen_err err;
    snprintf(path, sizeof path, "%.400s/%s", dir, name);
    assert_ok(sheen_session_create(s, path, SHEEN_MOVING_CAMERA, &err), err);
}

// JPEGs with the detail of a textured scene, some 250 kB each.
static void make_recording(sheen_session *s, const test_scratch *scratch, int n_pictures)
{
    sheen_raster r;
    sheen_err err;
    uint64_t seed = 5;
    char path[TEST_PATH_MAX];
    make_session(s, scratch->path, "recorded");
    assert_ok(sheen_raster_init(&r, W, H, 3, 8, &err), err);
    test_scratch_file(path, scratch, "picture.jpg");
    for (int i = 0; i < n_pictures; i++) {
        sheen_frame_info f;
        size_t n;
        for (size_t k = 0; k < (size_t)3 * W * H; k++)
            ((uint8_t *)r.data)[k] = (uint8_t)(k / 3 % W / 8 + k / 3 / W / 8 +
                                               (size_t)(30 * test_random(&seed)));
        assert_ok(sheen_jpeg_write(path, &r, 85, &err), err);
        uint8_t *jpeg = test_file_read(path, &n);
        sheen_frame_info_init(&f);
        sheen_session_next_name(s, f.name);
        f.width_px = W;
        f.height_px = H;
        assert_ok(sheen_session_add_frame(s, &f, "jpg", jpeg, n, &err), err);
        free(jpeg);
    }
    sheen_raster_release(&r);
}

static void open_camera(sheen_source **src, fake_v4l2 *f, const sheen_session *recorded, int rate_hz)
{
    sheen_err err;
    fake_v4l2_init(f);
    f->clock_ns = clock_ns;
    f->interval_ns = 1000000000 / rate_hz / 1000 * 1000;
    if (recorded)
        assert_ok(fake_v4l2_play(f, recorded, &err), err);
    assert_ok(sheen_v4l2_source_open(src, &f->io, "/dev/video0?lock=off", &err), err);
}

static double cpu_s(void)
{
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return (double)u.ru_utime.tv_sec + (double)u.ru_stime.tv_sec +
           1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

static double most_memory_mb(void)
{
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return (double)u.ru_maxrss / 1e3;
}

// Every frame that the session lists is what its sidecar says; returns how many.
static size_t check_session(const char *path)
{
    sheen_session s;
    sheen_err err;
    assert_ok(sheen_session_open(&s, path, &err), err);
    for (size_t i = 0; i < s.n_frames; i++) {
        uint8_t *payload;
        size_t size_bytes;
        assert_ok(sheen_session_payload(&payload, &size_bytes, &s, &s.frames[i], &err), err);
        free(payload);
    }
    const size_t n = s.n_frames;
    sheen_session_release(&s);
    return n;
}

static void a_minute_at_full_rate_drops_nothing(void **state)
{
    const test_scratch *scratch = *state;
    sheen_session recorded, s;
    sheen_source *src;
    fake_v4l2 f;
    sheen_record_report report;
    sheen_source_counts counts;
    sheen_err err;
    enum { SECONDS = 60 };
    const sheen_record_options o = {.count = SECONDS * RATE};
    make_recording(&recorded, scratch, N_PICTURES);
    make_session(&s, scratch->path, "minute");
    open_camera(&src, &f, &recorded, RATE);
    const double cpu_before_s = cpu_s();
    const int64_t begun_ns = clock_ns();
    assert_ok(sheen_record(&s, src, &o, &report, &err), err);
    const double wall_s = 1e-9 * (double)(clock_ns() - begun_ns), used_s = cpu_s() - cpu_before_s;
    sheen_source_counters(&counts, src);
    print_message(
        "%zu frames of %d x %d px (%.0f kB) in %.1f s: %lld dropped, %zu passed over; %.1f s of processor "
        "time (%.1f ms a frame), at most %.0f MB of memory\n",
        report.n_recorded, W, H, (double)f.payload_bytes[0] / 1e3, wall_s, (long long)counts.n_dropped,
        report.n_skipped, used_s, 1e3 * used_s / (double)report.n_recorded, most_memory_mb());
    assert_int_equal(report.n_recorded, SECONDS * RATE);
    assert_true(!counts.n_dropped && !report.n_skipped && !report.n_lost);
    sheen_source_close(&src);
    assert_int_equal(check_session(s.path), SECONDS * RATE);
    fake_v4l2_release(&f);
    sheen_session_release(&s);
    sheen_session_release(&recorded);
}

// A disk that takes 5 MB/s.
static sheen_status write_slowly(void *self, const sheen_session *s, sheen_frame_info *info,
                                 const char *extension, const void *payload, size_t size_bytes,
                                 sheen_err *err)
{
    (void)self;
    const double s_needed = (double)size_bytes / 5e6;
    const struct timespec t = {(time_t)s_needed, (long)(1e9 * (s_needed - (double)(time_t)s_needed))};
    nanosleep(&t, NULL);
    return sheen_session_write_frame(s, info, extension, payload, size_bytes, err);
}

static sheen_status now(void *self, int64_t *since_ns, sheen_err *err)
{
    (void)self;
    (void)err;
    *since_ns = 0;
    return SHEEN_OK;
}

static void note(void *self, const char *text)
{
    if (strstr(text, "slower than the camera"))
        ++*(int *)self;
}

static void a_slow_disk_loses_no_still(void **state)
{
    const test_scratch *scratch = *state;
    sheen_session recorded;
    enum { QUEUE_BYTES = 4 << 20, COUNT = 200 };
    make_recording(&recorded, scratch, N_PICTURES);
    for (int stills = 0; stills < 2; stills++) {
        sheen_session s;
        sheen_source *src;
        fake_v4l2 f;
        sheen_record_report report;
        sheen_source_counts counts;
        sheen_err err;
        int n_noted = 0;
        const sheen_record_options o = {.count = COUNT,
                                        .queue_bytes = QUEUE_BYTES,
                                        .write = write_slowly,
                                        .notice = note,
                                        .notice_self = &n_noted,
                                        .policy = {.ask = stills ? now : NULL}};
        make_session(&s, scratch->path, stills ? "stills" : "all");
        open_camera(&src, &f, &recorded, RATE);
        const double before_mb = most_memory_mb();
        assert_ok(sheen_record(&s, src, &o, &report, &err), err);
        sheen_source_counters(&counts, src);
        print_message(
            "%s at 5 MB/s: %zu recorded, %zu passed over, %lld dropped by the camera, %zu lost; memory grew "
            "by %.0f MB\n",
            stills ? "stills" : "all that comes", report.n_recorded, report.n_skipped,
            (long long)counts.n_dropped, report.n_lost, most_memory_mb() - before_mb);
        assert_int_equal(report.n_recorded, COUNT);
        assert_int_equal(report.n_lost, 0);
        assert_int_equal(n_noted, 1);
        if (stills)
            assert_true(!report.n_skipped &&
                        counts.n_dropped > 0); // the camera waits, what was taken does not
        else
            assert_true(report.n_skipped > 0 && counts.n_dropped == 0);
        assert_true(most_memory_mb() - before_mb < 3 * QUEUE_BYTES / 1e6);
        sheen_source_close(&src);
        assert_int_equal(check_session(s.path), COUNT);
        fake_v4l2_release(&f);
        sheen_session_release(&s);
    }
    sheen_session_release(&recorded);
}

// What the child tells of each frame that it was told is safe.
typedef struct safe {
    char name[64], digest[33];
} safe;

static sheen_status tell(void *self, const sheen_frame_info *f, sheen_err *err)
{
    safe told = {0};
    memcpy(told.name, f->name, sizeof told.name);
    memcpy(told.digest, f->payload_digest, sizeof told.digest);
    return write(*(const int *)self, &told, sizeof told) == (ssize_t)sizeof told
               ? SHEEN_OK
               : sheen_fail(err, SHEEN_EIO, "nobody listens");
}

static void capture_until_killed(const char *path, int pipe_fd)
{
    sheen_session s;
    sheen_source *src;
    fake_v4l2 f;
    sheen_record_report report;
    sheen_err err;
    const sheen_record_options o = {.policy = {.self = &pipe_fd, .ask = now, .stored = tell}};
    if (sheen_session_create(&s, path, SHEEN_MOVING_CAMERA, &err))
        _exit(3);
    open_camera(&src, &f, NULL, 500);
    sheen_record(&s, src, &o, &report, &err);
    _exit(4);
}

static void kill_9_at_any_instant_leaves_every_safe_frame(void **state)
{
    char path[TEST_PATH_MAX];
    uint64_t seed = 11;
    size_t n_safe = 0, n_partial = 0;
    test_scratch_file(path, *state, "killed");
    for (int i = 0; i < N_KILLS; i++) {
        int ends[2], how;
        safe told;
        sheen_session s;
        sheen_err err;
        assert_int_equal(pipe(ends), 0);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (!child)
            capture_until_killed(path, ends[1]);
        close(ends[1]);
        const struct timespec t = {0, (long)(8e7 * test_random(&seed))};
        nanosleep(&t, NULL);
        kill(child, SIGKILL);
        assert_true(waitpid(child, &how, 0) == child && WIFSIGNALED(how));
        if (sheen_session_open(&s, path, &err)) { // killed before there was a session
            assert_int_equal(n_safe, 0);
            close(ends[0]);
            continue;
        }
        size_t n_now = 0;
        while (read(ends[0], &told, sizeof told) == (ssize_t)sizeof told) {
            const sheen_frame_info *f = sheen_session_find(&s, told.name);
            assert_non_null(f);
            assert_string_equal(f->payload_digest, told.digest);
            n_now++;
        }
        close(ends[0]);
        n_safe += n_now;
        n_partial += n_now > 0;
        assert_true(s.n_frames >= n_safe); // one more each time, where it was safe and not yet told
        assert_true(s.n_frames <= n_safe + (size_t)i + 1);
        n_safe = s.n_frames;
        sheen_session_release(&s);
    }
    assert_int_equal(check_session(path), n_safe);
    print_message("%d kills, %zu of them amid frames; %zu frames safe, all whole\n", N_KILLS, n_partial,
                  n_safe);
    assert_true(n_partial > 10);
}

// In a child, on a file system of its own of one megabyte; 77: none can be had.
static int fill_a_disk(const char *recorded, const char *dir)
{
    char command[3 * TEST_PATH_MAX];
    if (unshare(CLONE_NEWNS) || mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) ||
        mount("tmpfs", dir, "tmpfs", 0, "size=1m"))
        return 77;
    snprintf(
        command, sizeof command,
        "p='%s' d='%.400s' from='replay:%.400s'; \"$p\" capture \"$d/s\" --device \"$from\" >\"$d.said\" "
        "2>&1; "
        "code=$?; cat \"$d.said\"; [ $code = 1 ] || exit 2; grep -q 'disk is full' \"$d.said\" || exit 3; "
        "\"$p\" capture \"$d/s\" --device \"$from\" --count 1 >/dev/null || exit 4",
        SHEEN_PROGRAM, dir, recorded);
    const int how = system(command); // NOLINT(cert-env33-c): the program under test
    const int code = WIFEXITED(how) ? WEXITSTATUS(how) : 5;
    if (code)
        return code;
    snprintf(command, sizeof command, "%.400s/s", dir);
    return check_session(command) > 0 ? 0 : 6;
}

static void a_full_disk_is_told_and_leaves_a_session(void **state)
{
    const test_scratch *scratch = *state;
    char dir[TEST_PATH_MAX];
    sheen_session recorded;
    sheen_err err;
    int how;
    make_recording(&recorded, scratch, N_PICTURES);
    test_scratch_file(dir, scratch, "small");
    assert_ok(sheen_dir_make(dir, &err), err);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (!child)
        _exit(fill_a_disk(recorded.path, dir));
    assert_true(waitpid(child, &how, 0) == child && WIFEXITED(how));
    sheen_session_release(&recorded);
    if (WEXITSTATUS(how) == 77) {
        test_skip("no file system of its own can be had here");
    }
    assert_int_equal(WEXITSTATUS(how), 0);
}

#define WITH_SCRATCH(f) cmocka_unit_test_setup_teardown(f, test_scratch_setup, test_scratch_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_SCRATCH(a_slow_disk_loses_no_still),
        WITH_SCRATCH(kill_9_at_any_instant_leaves_every_safe_frame),
        WITH_SCRATCH(a_full_disk_is_told_and_leaves_a_session),
        WITH_SCRATCH(a_minute_at_full_rate_drops_nothing),
    };
    return test_result(cmocka_run_group_tests(tests, NULL, NULL));
}
