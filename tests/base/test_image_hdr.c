// SPDX-License-Identifier: Apache-2.0
// test_image_hdr.c - Radiance pictures: what is written reads back, both kinds of runs, headers.
#include "tests/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"

#define CORPUS SHEEN_TEST_DATA "/../fuzz/corpus/hdr/"

// The largest of a pixel's three is kept to one part in 256, the others on its scale.
static void assert_pixel(const float got[3], const float want[3])
{
    const float most = fmaxf(want[0], fmaxf(want[1], want[2]));
    for (int c = 0; c < 3; c++)
        assert_close(got[c], want[c], most / 128);
}

static void what_is_written_reads_back(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "a.hdr");
    const int widths[] = {1, 7, 8, 300}; // without and with runs
    uint64_t seed = 5;
    for (size_t k = 0; k < sizeof widths / sizeof *widths; k++) {
        sheen_image img;
        sheen_raster back;
        sheen_err err;
        assert_ok(sheen_image_init(&img, widths[k], 5, 3, &err), err);
        const size_t n = 15 * (size_t)widths[k];
        for (size_t i = 0; i < n; i++)
            img.data[i] = i % 90 < 45 ? (float)(exp(12 * test_random(&seed) - 4)) : 0.25f;
        assert_ok(sheen_hdr_write(path, &img, &err), err);
        assert_ok(sheen_raster_load(&back, path, &err), err);
        assert_int_equal(back.width_px, widths[k]);
        assert_int_equal(back.height_px, 5);
        assert_int_equal(back.n_channels, 3);
        for (size_t i = 0; i < n; i += 3)
            assert_pixel((const float *)back.data + i, img.data + i);
        sheen_raster_release(&back);
        sheen_image_release(&img);
    }
}

static void black_stays_black(void **state)
{
    const test_scratch *scratch = *state;
    char path[TEST_PATH_MAX];
    test_scratch_file(path, scratch, "black.hdr");
    float data[12 * 3] = {0};
    const sheen_image img = {data, 12, 1, 3};
    sheen_raster back;
    sheen_err err;
    assert_ok(sheen_hdr_write(path, &img, &err), err);
    assert_ok(sheen_raster_load(&back, path, &err), err);
    assert_memory_equal(back.data, data, sizeof data);
    sheen_raster_release(&back);
}

static void load(sheen_raster *r, const char *name)
{
    char path[TEST_PATH_MAX];
    sheen_err err;
    snprintf(path, sizeof path, "%s%s", CORPUS, name);
    assert_ok(sheen_raster_load(r, path, &err), err);
}

static void both_kinds_of_runs_and_exposures(void **state)
{
    (void)state;
    sheen_raster r;
    load(&r, "runs-20x3.hdr"); // pixels 9 and on are 9 8 7 at exponent 130; both exposures make 0.5
    for (int y = 0; y < 3; y++)
        for (int x = 9; x < 20; x++) {
            const float *p = (const float *)r.data + (y * 20 + x) * 3;
            assert_close(p[0], 2 * 9.5 / 64, 1e-6);
            assert_close(p[1], 2 * 8.5 / 64, 1e-6);
            assert_close(p[2], 2 * 7.5 / 64, 1e-6);
        }
    sheen_raster_release(&r);
    load(&r, "old-runs-5x1.hdr");
    for (int x = 0; x < 4; x++)
        assert_close(((const float *)r.data)[3 * x], 10.5 / 128, 1e-7);
    assert_close(((const float *)r.data)[12], 40.5 / 256, 1e-7);
    sheen_raster_release(&r);
    load(&r, "old-runs-300x1.hdr"); // 1 + 43 + 256
    for (int x = 0; x < 300; x++)
        assert_close(((const float *)r.data)[3 * x + 2], 30.5 / 128, 1e-7);
    sheen_raster_release(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_is_written_reads_back, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(black_stays_black, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test(both_kinds_of_runs_and_exposures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
