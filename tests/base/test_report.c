// SPDX-License-Identifier: Apache-2.0
// A report: well-formed, escaped, self-contained, and nothing in it that is not a number.
#include "tests/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/report.h"

static char *read_all(const char *path)
{
    sheen_err err;
    uint8_t *data;
    size_t size_bytes;
    assert_ok(sheen_file_read(&data, &size_bytes, path, 1 << 20, &err), err);
    char *text = realloc(data, size_bytes + 1);
    assert_non_null(text);
    text[size_bytes] = 0;
    return text;
}

static size_t count(const char *text, const char *word)
{
    size_t n = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word))
        n++;
    return n;
}

// Each element that is opened is closed, in order.
static void assert_well_formed(const char *text)
{
    char open[64][16];
    int depth = 0;
    for (const char *at = strchr(text + 10, '<'); at; at = strchr(at + 1, '<')) {
        const char *end = strchr(at, '>');
        assert_non_null(end);
        const size_t length = strcspn(at + 1, " >/");
        if (end[-1] == '/' || !strncmp(at, "<meta", 5) || !strncmp(at, "<img", 4))
            continue;
        if (at[1] == '/') {
            assert_in_range(depth, 1, 64);
            depth--;
            assert_int_equal(strncmp(at + 2, open[depth], strlen(open[depth])), 0);
        } else {
            assert_in_range(depth, 0, 63);
            assert_in_range(length, 1, 15);
            snprintf(open[depth++], sizeof *open, "%.*s", (int)length, at + 1);
        }
    }
    assert_int_equal(depth, 0);
}

static void fill(sheen_report *r)
{
    sheen_err err;
    uint8_t grey[12] = {0, 80, 160, 255};
    sheen_raster picture = {.data = grey, .width_px = 4, .height_px = 3, .n_channels = 1, .bits = 8};
    const double xy[] = {0.1, 0.2, 0.5, NAN, 0.9, 0.8, 7, 7}, values[] = {0, 0.5, NAN, 1};
    sheen_plot p = {.title = "a < b", .x_label = "x", .y_label = "y & z", .x_max = 1, .y_max = 1};
    sheen_report_begin(r, "Report of 'x' & <y>", false, "take more \"frames\"");
    sheen_report_section(r, "Table");
    sheen_report_table(r, "name|a|b");
    sheen_report_row(r, "%s|%g|%g", "<first>", 1.5, (double)NAN);
    sheen_report_text(r, "%d of %d", 1, 2);
    sheen_report_section(r, "Plots");
    sheen_plot_begin(r, &p);
    sheen_plot_points(r, &p, xy, 4, NULL, 2);
    sheen_plot_line(r, &p, xy, 4, "#c33");
    sheen_plot_arrow(r, &p, xy, xy + 4, NULL);
    sheen_plot_point(r, &p, 0.5, 0.5, 0.25, true, 2);
    sheen_plot_label(r, &p, 0.5, 0.5, "<here>");
    sheen_plot_bars(r, &p, values, 4, NULL);
    sheen_plot_cells(r, &p, values, (const int[2]){2, 2}, (const double[2]){0, 1}, 1);
    sheen_plot_end(r, &p);
    assert_ok(sheen_report_picture(r, &picture, 80, "frame <1>", &err), err);
}

static void is_a_page_of_its_own(void **state)
{
    sheen_err err;
    char path[TEST_PATH_MAX];
    sheen_report r = {0};
    test_scratch_file(path, *state, "report.html");
    fill(&r);
    assert_ok(sheen_report_save(&r, path, &err), err);
    assert_null(r.text.bytes.data);
    char *text = read_all(path);
    assert_well_formed(text);
    assert_non_null(strstr(text, "<title>Report of 'x' &amp; &lt;y&gt;</title>"));
    assert_non_null(strstr(text, "<tr><td>&lt;first&gt;</td><td>1.5</td><td>\xe2\x80\x93</td></tr>"));
    assert_int_equal(count(text, "<section>"), 2);
    assert_int_equal(count(text, "<circle"), 3); // two of four points are to be seen, and the single one
    assert_int_equal(count(text, "data:image/png;base64,iVBORw0KGgo"), 1);
    assert_int_equal(count(text, "nan"), 0);
    assert_int_equal(count(text, "http"), 0); // nothing comes from elsewhere
    free(text);
}

static void a_range_of_nothing_is_drawn(void **state)
{
    sheen_err err;
    char path[TEST_PATH_MAX];
    sheen_report r = {0};
    sheen_plot p = {.x_min = 3, .x_max = 3, .y_min = 0, .y_max = (double)NAN};
    const double flat[4] = {2, 2, 2, 2};
    test_scratch_file(path, *state, "report.html");
    sheen_report_begin(&r, "Flat", true, "nothing");
    sheen_plot_begin(&r, &p);
    sheen_plot_cells(&r, &p, flat, (const int[2]){2, 2}, (const double[2]){2, 2}, -1);
    sheen_plot_end(&r, &p);
    assert_ok(sheen_report_save(&r, path, &err), err);
    char *text = read_all(path);
    assert_well_formed(text);
    assert_int_equal(count(text, "nan"), 0);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(is_a_page_of_its_own, test_scratch_setup, test_scratch_teardown),
        cmocka_unit_test_setup_teardown(a_range_of_nothing_is_drawn, test_scratch_setup,
                                        test_scratch_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
