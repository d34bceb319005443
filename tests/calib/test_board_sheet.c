// SPDX-License-Identifier: Apache-2.0
// Printed boards, drawn again by other people's renderers (pdftoppm, rsvg-convert) and read by our own detector.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "calib/board_sheet.h"
#include "calib/saddles.h"
#include "support.h"

enum { DPI = 254 }; // 10 px a millimetre, so that a page is a whole number of pixels

static void have(const char *program)
{
    char command[128];
    snprintf(command, sizeof command, "command -v %s >/dev/null", program);
    if (system(command))
        test_skip(program);
}

static uint8_t *draw(const char *command, const char *png, int *width_px, int *height_px)
{
    sheen_err err;
    sheen_raster raster;
    assert_int_equal(system(command), 0);
    assert_ok(sheen_raster_load(&raster, png, &err), err);
    uint8_t *grey = malloc((size_t)raster.width_px * (size_t)raster.height_px);
    assert_non_null(grey);
    sheen_raster_grey(grey, &raster, SHEEN_TRANSFER_SRGB);
    *width_px = raster.width_px;
    *height_px = raster.height_px;
    sheen_raster_release(&raster);
    return grey;
}

// Every printed tag is read and every printed corner found, and all are where board.json says, to 0.01 mm in the
// mean of all and to 0.15 px (0.015 mm) each.
static void check_picture(const uint8_t *grey, int width_px, int height_px, const sheen_board *board,
                          const sheen_sheet *sheet)
{
    sheen_err err;
    sheen_tag_detector *detector;
    sheen_board_view view;
    assert_ok(sheen_tag_detector_new(&detector, board->family, &err), err);
    assert_ok(sheen_board_observe(&view, detector, grey, width_px, height_px, board, &err), err);
    size_t n_tags = 0, n_corners = 0;
    for (size_t i = 0; i < board->n_tags; i++)
        n_tags += board->tags[i].printed;
    for (size_t i = 0; i < board->n_corners; i++)
        n_corners += board->corners[i].printed;
    assert_int_equal(view.n_tags, n_tags);
    assert_int_equal(view.n_saddles, n_corners);

    const double px_per_mm = DPI / 25.4;
    double scale[2][2] = {{0}}, mean[2] = {0};
    for (size_t i = 0; i < view.n_saddles; i++)
        for (int k = 0; k < 2; k++) {
            const double p_mm = 1000 * view.saddles[i].p_board[k] * (k ? -1 : 1);
            const double centre_mm = k ? sheet->board_y_mm + sheet->board_height_mm / 2
                                       : sheet->board_x_mm + sheet->board_width_mm / 2;
            const double found_mm = (view.saddles[i].q_px[k] + 0.5) / px_per_mm - centre_mm;
            assert_close(found_mm, p_mm, 0.15 / px_per_mm);
            mean[k] += (found_mm - p_mm) / (double)view.n_saddles;
            scale[k][0] += found_mm * p_mm;
            scale[k][1] += p_mm * p_mm;
        }
    for (int k = 0; k < 2; k++) {
        assert_close(mean[k], 0, 0.01);
        assert_close(scale[k][0] / scale[k][1] * sheet->board_width_mm, sheet->board_width_mm, 0.01);
    }
    sheen_board_view_release(&view);
    sheen_tag_detector_free(&detector);
}

static void make(sheen_board *board, sheen_sheet *sheet, const char *paper, int first_id,
                 double blank_radius_m)
{
    sheen_err err;
    sheen_board_layout layout = {
        .n_cols = 9, .n_rows = 7, .first_id = first_id, .blank_radius_m = blank_radius_m};
    assert_ok(sheen_sheet_largest_square(&layout.square_m, paper, 9, 7, &err), err);
    layout.tag_side_m = 0.72 * layout.square_m;
    assert_ok(sheen_board_make(board, &layout, &err), err);
    assert_ok(sheen_sheet_plan(sheet, paper, 9, 7, layout.square_m, &err), err);
}

static void a_pdf_shows_what_its_file_says(void **state)
{
    have("pdftoppm");
    char pdf[TEST_PATH_MAX], png[TEST_PATH_MAX], command[3 * TEST_PATH_MAX];
    sheen_board boards[2];
    sheen_sheet sheet;
    sheen_err err;
    test_scratch_file(pdf, *state, "board.pdf");
    test_scratch_file(png, *state, "board.png");
    make(&boards[0], &sheet, "a4", 0, 0);
    make(&boards[1], &sheet, "a4", 500, 0);
    assert_ok(sheen_sheet_print(boards, 2, &sheet, SHEEN_SHEET_PDF, pdf, &err), err);
    for (int i = 0; i < 2; i++) {
        int width_px, height_px;
        snprintf(command, sizeof command, "pdftoppm -r %d -f %d -singlefile -png '%s' '%.*s'", DPI, i + 1,
                 pdf, (int)strlen(png) - 4, png);
        uint8_t *grey = draw(command, png, &width_px, &height_px);
        check_picture(grey, width_px, height_px, &boards[i], &sheet);
        free(grey);
        sheen_board_release(&boards[i]);
    }
}

static void an_svg_shows_what_its_file_says(void **state)
{
    have("rsvg-convert");
    char svg[TEST_PATH_MAX], png[TEST_PATH_MAX], command[3 * TEST_PATH_MAX];
    sheen_board board;
    sheen_sheet sheet;
    sheen_err err;
    int width_px, height_px;
    test_scratch_file(svg, *state, "board.svg");
    test_scratch_file(png, *state, "board.png");
    make(&board, &sheet, "300x200", 40, 0.04);
    assert_ok(sheen_sheet_print(&board, 1, &sheet, SHEEN_SHEET_SVG, svg, &err), err);
    // a point is 1/72 inch, which rsvg-convert draws at 96 pixels an inch: zoom to DPI
    snprintf(command, sizeof command, "rsvg-convert -z %.9g -o '%s' '%s'", DPI / 96.0, png, svg);
    uint8_t *grey = draw(command, png, &width_px, &height_px);
    check_picture(grey, width_px, height_px, &board, &sheet);
    free(grey);
    assert_int_equal(sheen_sheet_print(&board, 0, &sheet, SHEEN_SHEET_SVG, svg, &err), SHEEN_EARG);
    sheen_board_release(&board);
}

static void says_what_does_not_fit(void **state)
{
    sheen_err err;
    sheen_sheet sheet;
    sheen_board board;
    double square_m;
    char pdf[TEST_PATH_MAX];
    test_scratch_file(pdf, *state, "board.pdf");
    assert_fails(
        sheen_sheet_plan(&sheet, "a4", 12, 9, 0.025, &err), err, SHEEN_EARG,
        "12 x 9 squares of 25 mm with their rulers do not fit on 'a4' (297 x 210 mm): use squares of "
        "at most 18.2 mm");
    assert_fails(sheen_sheet_plan(&sheet, "a9", 12, 9, 0.025, &err), err, SHEEN_EARG,
                 "there is no paper 'a9'");
    assert_fails(sheen_sheet_plan(&sheet, "200xtall", 12, 9, 0.02, &err), err, SHEEN_EARG, "no paper");
    assert_fails(sheen_sheet_largest_square(&square_m, "60x50", 100, 100, &err), err, SHEEN_EARG,
                 "100 x 100 squares do not fit on '60x50'");
    make(&board, &sheet, "a3", 580, 0); // the family ends at 586
    assert_fails(sheen_sheet_print(&board, 1, &sheet, SHEEN_SHEET_PDF, pdf, &err), err, SHEEN_EARG,
                 "the family 'tag36h11' has no tag 587: its ids are 0 to 586");
    sheen_board_release(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_pdf_shows_what_its_file_says, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(an_svg_shows_what_its_file_says, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test_setup_teardown(says_what_does_not_fit, test_scratch_setup, test_scratch_teardown),
    };
    return test_result(cmocka_run_group_tests(tests, NULL, NULL));
}
