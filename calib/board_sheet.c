// SPDX-License-Identifier: Apache-2.0
// board_sheet.c - where a board lies on its paper.
#include "calib/board_sheet.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <strings.h>

static const struct {
    const char *name;
    double short_mm, long_mm;
} papers[] = {{"a4", 210, 297},  {"a3", 297, 420},         {"a2", 420, 594},         {"a1", 594, 841},
              {"a0", 841, 1189}, {"letter", 215.9, 279.4}, {"tabloid", 279.4, 431.8}};

static const double EDGE_MM = 10;       // what printers leave white
static const double BELOW_MM = 26;      // a white rim, the ruler, two lines of text
static const double BESIDE_MM = 16;     // a white rim, the other ruler
static const double LARGEST_MM = 10000; // of a sheet's side

static sheen_status paper_size(double *short_mm, double *long_mm, const char *paper, sheen_err *err)
{
    for (size_t i = 0; i < sizeof papers / sizeof *papers; i++)
        if (!strcasecmp(paper, papers[i].name)) {
            *short_mm = papers[i].short_mm;
            *long_mm = papers[i].long_mm;
            return SHEEN_OK;
        }
    char *end;
    const double a = strtod(paper, &end), b = *end == 'x' ? strtod(end + 1, &end) : 0;
    if (*end || !(a >= 50 && b >= 50 && a <= LARGEST_MM && b <= LARGEST_MM))
        return sheen_fail(
            err, SHEEN_EARG,
            "there is no paper '%.40s': use a4, a3, a2, a1, a0, letter, tabloid, or WIDTHxHEIGHT "
            "in millimetres",
            paper);
    *short_mm = fmin(a, b);
    *long_mm = fmax(a, b);
    return SHEEN_OK;
}

static double largest_mm(double width_mm, double height_mm, int n_cols, int n_rows)
{
    return fmin((width_mm - 2 * EDGE_MM - BESIDE_MM) / n_cols, (height_mm - 2 * EDGE_MM - BELOW_MM) / n_rows);
}

static sheen_status lay_out(sheen_sheet *sheet, const char *paper, int n_cols, int n_rows, sheen_err *err)
{
    double short_mm = 0, long_mm = 0;
    const sheen_status s = paper_size(&short_mm, &long_mm, paper, err);
    if (s)
        return s;
    const bool across = largest_mm(long_mm, short_mm, n_cols, n_rows) >=
                        largest_mm(short_mm, long_mm, n_cols, n_rows);
    *sheet = (sheen_sheet){.width_mm = across ? long_mm : short_mm, .height_mm = across ? short_mm : long_mm};
    return SHEEN_OK;
}

sheen_status sheen_sheet_largest_square(double *square_m, const char *paper, int n_cols, int n_rows,
                                        sheen_err *err)
{
    sheen_sheet sheet;
    const sheen_status s = lay_out(&sheet, paper, n_cols, n_rows, err);
    if (s)
        return s;
    const double mm = largest_mm(sheet.width_mm, sheet.height_mm, n_cols, n_rows);
    const double round_mm = mm >= 5 ? floor(mm) : floor(10 * mm) / 10;
    if (!(round_mm >= 1))
        return sheen_fail(err, SHEEN_EARG,
                          "%d x %d squares do not fit on '%.40s': use fewer, or larger paper", n_cols, n_rows,
                          paper);
    *square_m = round_mm / 1000;
    return SHEEN_OK;
}

sheen_status sheen_sheet_plan(sheen_sheet *sheet, const char *paper, int n_cols, int n_rows, double square_m,
                              sheen_err *err)
{
    const sheen_status s = lay_out(sheet, paper, n_cols, n_rows, err);
    if (s)
        return s;
    const double fits_mm = largest_mm(sheet->width_mm, sheet->height_mm, n_cols, n_rows);
    sheet->board_width_mm = 1000 * square_m * n_cols;
    sheet->board_height_mm = 1000 * square_m * n_rows;
    if (!(1000 * square_m <= fits_mm))
        return sheen_fail(
            err, SHEEN_EARG,
            "%d x %d squares of %g mm with their rulers do not fit on '%.40s' (%g x %g mm): use "
            "squares of at most %.1f mm, fewer of them, or larger paper",
            n_cols, n_rows, 1000 * square_m, paper, sheet->width_mm, sheet->height_mm,
            floor(10 * fits_mm) / 10);
    sheet->board_x_mm = (sheet->width_mm - BESIDE_MM - sheet->board_width_mm) / 2;
    sheet->board_y_mm = (sheet->height_mm - BELOW_MM - sheet->board_height_mm) / 2;
    return SHEEN_OK;
}
