// SPDX-License-Identifier: Apache-2.0
// test_record_faults.c - a recording whose file calls fail, each in turn: the linker puts the functions below between sheen
// and the C library (--wrap).
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "capture/record.h"
#include "capture/v4l2_source.h"
#include "tests/fake/fake_v4l2.h"
#include "tests/support.h"

enum { COUNT = 3 };

// The plan: of the calls while it is armed, number fail_call (from 1) fails; the writer has a thread of its own.
static atomic_bool armed;
static atomic_int n_calls;
static int fail_call, fail_code;
static bool short_writes;

static bool fails(void)
{
    if (!atomic_load(&armed) || atomic_fetch_add(&n_calls, 1) + 1 != fail_call)
        return false;
    errno = fail_code;
    return true;
}

// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): the linker's names
int __real_open(const char *path, int flags, ...);
ssize_t __real_write(int fd, const void *data, size_t size_bytes);
int __real_fsync(int fd);
int __real_close(int fd);
int __real_rename(const char *from, const char *to);
int __real_mkdir(const char *path, mode_t mode);
int __wrap_open(const char *path, int flags, ...);
ssize_t __wrap_write(int fd, const void *data, size_t size_bytes);
int __wrap_fsync(int fd);
int __wrap_close(int fd);
int __wrap_rename(const char *from, const char *to);
int __wrap_mkdir(const char *path, mode_t mode);

int __wrap_open(const char *path, int flags, ...)
{
    mode_t mode = 0;
    if (flags & O_CREAT) {
        va_list more;
        va_start(more, flags);
        mode = va_arg(more, mode_t);
        va_end(more);
    }
    return fails() ? -1 : __real_open(path, flags, mode);
}

ssize_t __wrap_write(int fd, const void *data, size_t size_bytes)
{
    if (fails())
        return -1;
    return __real_write(fd, data, atomic_load(&armed) && short_writes ? size_bytes / 2 + 1 : size_bytes);
}

int __wrap_fsync(int fd)
{
    return fails() ? -1 : __real_fsync(fd);
}

// As Linux does it: the file is closed whatever it says.
int __wrap_close(int fd)
{
    const bool told = fails();
    const int code = __real_close(fd);
    if (!told)
        return code;
    errno = fail_code;
    return -1;
}

int __wrap_rename(const char *from, const char *to)
{
    return fails() ? -1 : __real_rename(from, to);
}

int __wrap_mkdir(const char *path, mode_t mode)
{
    return fails() ? -1 : __real_mkdir(path, mode);
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

typedef struct told {
    char names[COUNT][64], digests[COUNT][33];
    size_t n;
} told;

static sheen_status ask(void *self, int64_t *since_ns, sheen_err *err)
{
    (void)self;
    (void)err;
    *since_ns = 0;
    return SHEEN_OK;
}

static sheen_status stored(void *self, const sheen_frame_info *f, sheen_err *err)
{
    told *t = self;
    (void)err;
    assert_true(t->n < COUNT);
    memcpy(t->names[t->n], f->name, sizeof f->name);
    memcpy(t->digests[t->n], f->payload_digest, sizeof f->payload_digest);
    t->n++;
    return SHEEN_OK;
}

static size_t count_names(const char *path, bool hidden)
{
    char command[TEST_PATH_MAX + 32];
    size_t n = 0;
    snprintf(command, sizeof command, "ls -A '%.400s'", path);
    FILE *list = popen(command, "r"); // NOLINT(cert-env33-c)
    assert_non_null(list);
    for (char line[256]; fgets(line, sizeof line, list);)
        n += !hidden || line[0] == '.';
    pclose(list);
    return n;
}

// Every frame that was told to be stored is in the session as it was told, and no half file is left beside them.
static void check_session(const char *path, const told *t, size_t n_recorded)
{
    sheen_session s;
    sheen_err err;
    char frames[TEST_PATH_MAX];
    assert_ok(sheen_session_open(&s, path, &err), err);
    assert_true(s.n_frames == n_recorded && t->n <= n_recorded);
    for (size_t i = 0; i < t->n; i++) {
        const sheen_frame_info *f = sheen_session_find(&s, t->names[i]);
        assert_non_null(f);
        assert_string_equal(f->payload_digest, t->digests[i]);
    }
    for (size_t i = 0; i < s.n_frames; i++) {
        sheen_raster r;
        assert_ok(sheen_session_raster(&r, &s, &s.frames[i], &err), err);
        sheen_raster_release(&r);
    }
    sheen_session_release(&s);
    snprintf(frames, sizeof frames, "%.400s/frames", path);
    if (sheen_dir_exists(frames))
        assert_int_equal(count_names(frames, true), 0);
}

// One recording with call n failing; true: there was no such call.
static bool record_once(void **state, int code, int n)
{
    fake_v4l2 f;
    sheen_session s;
    sheen_source *src;
    sheen_record_report report = {0};
    told t = {0};
    char path[TEST_PATH_MAX];
    sheen_err err = {0};
    sheen_err clean_up;
    test_scratch_file(path, *state, "faults");
    fake_v4l2_init(&f);
    assert_ok(sheen_session_create(&s, path, SHEEN_MOVING_CAMERA, &clean_up), clean_up);
    assert_ok(sheen_v4l2_source_open(&src, &f.io, "/dev/video0?lock=off", &clean_up), clean_up);
    const sheen_record_options o = {.count = COUNT, .policy = {.self = &t, .ask = ask, .stored = stored}};
    const size_t n_open = count_names("/proc/self/fd", false);
    fail_call = n;
    fail_code = code;
    atomic_store(&n_calls, 0);
    atomic_store(&armed, true);
    const sheen_status st = sheen_record(&s, src, &o, &report, &err);
    atomic_store(&armed, false);
    assert_int_equal(count_names("/proc/self/fd", false), n_open);
    sheen_source_close(&src);
    assert_true(fake_v4l2_is_clean(&f));
    if (st) {
        assert_true(st == err.code && (st == SHEEN_EIO || st == SHEEN_EACCESS));
        assert_true(strlen(err.msg) > 20 && strstr(err.msg, "faults/")); // the file is named
        assert_true(code != ENOSPC || strstr(err.msg, "disk is full"));
    } else
        assert_true(report.n_recorded == COUNT && t.n == COUNT && report.n_lost == 0);
    if (code == EINTR) // an interruption is no failure
        assert_int_equal(st, SHEEN_OK);
    check_session(path, &t, report.n_recorded);
    sheen_session_release(&s);
    assert_ok(sheen_dir_remove(path, &clean_up), clean_up);
    return atomic_load(&n_calls) < n;
}

static void a_recording_survives_any_file_call_that_fails(void **state)
{
    static const int codes[] = {EIO, ENODEV, EINTR, EAGAIN, ENOSPC, EROFS};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++)
        for (short_writes = false;; short_writes = true) {
            int n = 1;
            while (!record_once(state, codes[i], n)) {
                n++;
                assert_true(n < 500);
            }
            assert_true(n > 6 * COUNT); // open, write, fsync, close, rename of two files a frame, and more
            if (short_writes)
                break;
        }
}

int main(void)
{
    if (!access("/dev/shm", W_OK))
        setenv("TMPDIR", "/dev/shm", 0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_recording_survives_any_file_call_that_fails, test_scratch_setup,
                                        test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
