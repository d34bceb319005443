// SPDX-License-Identifier: Apache-2.0
// support.c - helpers that all tests share.
#define _XOPEN_SOURCE 700 // nftw
#include "tests/support.h"

#include <errno.h>
#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void test_assert_close(double got, double want, double tolerance, const char *what, const char *file,
                       int line)
{
    if (isnan(got) && isnan(want))
        return;
    const double off = fabs(got - want);
    if (got == want || off <= tolerance) // false where one is NaN
        return;
    print_error("%s is %.17g, not %.17g: off by %.3g, allowed %.3g\n", what, got, want, off, tolerance);
    _fail(file, line);
}

void test_assert_ok(sheen_status got, const sheen_err *err, const char *what, const char *file, int line)
{
    if (got == SHEEN_OK)
        return;
    print_error("%s failed with %d: %s\n", what, (int)got, err->msg);
    _fail(file, line);
}

void test_assert_fails(sheen_status got, const sheen_err *err, sheen_status want, const char *part,
                       const char *what, const char *file, int line)
{
    if (got != want) {
        print_error("%s returned %d, not %d: %s\n", what, (int)got, (int)want,
                    got == SHEEN_OK ? "" : err->msg);
        _fail(file, line);
        return;
    }
    if (err->code == want && strstr(err->msg, part))
        return;
    print_error("%s says (%d) \"%s\", which lacks \"%s\"\n", what, (int)err->code, err->msg, part);
    _fail(file, line);
}

static int n_skipped;

void test_skip(const char *reason)
{
    print_message("skipped: %s\n", reason);
    n_skipped++;
    skip();
}

int test_result(int n_failed)
{
    const int ctest_skip = 77; // SKIP_RETURN_CODE of sheen_test
    return n_failed ? 1 : n_skipped ? ctest_skip : 0;
}

void test_scratch_make(test_scratch *scratch)
{
    const char *tmp = getenv("TMPDIR");
    const int n = snprintf(scratch->path, sizeof scratch->path, "%s/sheen-test-XXXXXX",
                           tmp && *tmp ? tmp : "/tmp");
    if (n < 0 || (size_t)n >= sizeof scratch->path || !mkdtemp(scratch->path))
        fail_msg("cannot make a scratch folder '%s': %s", scratch->path, strerror(errno));
}

static int remove_one(const char *path, const struct stat *st, int kind, struct FTW *where)
{
    (void)st;
    (void)kind;
    (void)where;
    return remove(path);
}

void test_scratch_remove(test_scratch *scratch)
{
    if (nftw(scratch->path, remove_one, 16, FTW_DEPTH | FTW_PHYS))
        fail_msg("cannot remove scratch folder '%s': %s", scratch->path, strerror(errno));
    scratch->path[0] = '\0';
}

void test_scratch_file(char out[TEST_PATH_MAX], const test_scratch *scratch, const char *name)
{
    const int n = snprintf(out, TEST_PATH_MAX, "%s/%s", scratch->path, name);
    if (n < 0 || n >= TEST_PATH_MAX)
        fail_msg("name too long: '%s'", name);
}

int test_scratch_setup(void **state)
{
    test_scratch *scratch = malloc(sizeof *scratch);
    if (!scratch)
        return -1;
    test_scratch_make(scratch);
    *state = scratch;
    return 0;
}

int test_scratch_teardown(void **state)
{
    test_scratch *scratch = *state;
    test_scratch_remove(scratch);
    free(scratch);
    return 0;
}

uint8_t *test_file_read(const char *path, size_t *size_bytes_out)
{
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END))
        fail_msg("cannot open '%s': %s", path, strerror(errno));
    const long size = ftell(f);
    if (size < 0)
        fail_msg("cannot read '%s': %s", path, strerror(errno));
    rewind(f);
    const size_t size_bytes = (size_t)size;
    uint8_t *data = malloc(size_bytes + 1);
    if (!data || fread(data, 1, size_bytes, f) != size_bytes)
        fail_msg("cannot read %zu bytes from '%s'", size_bytes, path);
    fclose(f);
    data[size_bytes] = 0;
    if (size_bytes_out)
        *size_bytes_out = size_bytes;
    return data;
}

void test_file_write(const char *path, const void *data, size_t size_bytes)
{
    FILE *f = fopen(path, "wb");
    if (!f)
        fail_msg("cannot write '%s': %s", path, strerror(errno));
    const size_t n = size_bytes ? fwrite(data, 1, size_bytes, f) : 0;
    if (fclose(f) || n != size_bytes)
        fail_msg("cannot write '%s': %s", path, strerror(errno));
}

void test_file_write_text(const char *path, const char *text)
{
    test_file_write(path, text, strlen(text));
}

// splitmix64: every seed, 0 too, starts a good sequence.
static uint64_t next_bits(uint64_t *seed)
{
    *seed += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t z = *seed;
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

double test_random(uint64_t *seed)
{
    return (double)(next_bits(seed) >> 11) * 0x1p-53;
}

double test_random_normal(uint64_t *seed)
{
    const double u = 1 - test_random(seed); // (0, 1]: Box-Muller takes its logarithm
    const double turn_rad = 2 * 3.14159265358979323846 * test_random(seed);
    return sqrt(-2 * log(u)) * cos(turn_rad);
}
