// SPDX-License-Identifier: Apache-2.0
// board_sheet.h - a board on paper: vector PDF and SVG, with rulers to check the print.
//
// A sheet lies across where the board is wider than high. The board stands in the middle of what the rulers leave:
// one below it and one at its right, each with a mark a millimetre, since printers scale the two axes differently.
#ifndef SHEEN_CALIB_BOARD_SHEET_H
#define SHEEN_CALIB_BOARD_SHEET_H

#include "base/board.h"
#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_sheet {
    double width_mm, height_mm;    // of the paper, as the board lies on it
    double board_x_mm, board_y_mm; // upper left of its squares, from the paper's upper left
    double board_width_mm, board_height_mm;
} sheen_sheet;

// Paper "a4", "a3", "a2", "a1", "a0", "letter", "tabloid" or WIDTHxHEIGHT in millimetres, turned to suit n_cols x
// n_rows squares. EARG: no such paper; the squares do not fit (the sentence says which would).
sheen_status sheen_sheet_plan(sheen_sheet *sheet, const char *paper, int n_cols, int n_rows, double square_m,
                              sheen_err *err);
// The largest square (whole millimetres, else tenths) that fits on a paper. EARG where none does.
sheen_status sheen_sheet_largest_square(double *square_m, const char *paper, int n_cols, int n_rows,
                                        sheen_err *err);

typedef enum sheen_sheet_format { SHEEN_SHEET_PDF, SHEEN_SHEET_SVG } sheen_sheet_format;

// Prints n boards of one size, one page each (SVG: one board). EARG where there is no such tag; EIO, ENOMEM.
sheen_status sheen_sheet_print(const sheen_board *boards, size_t n, const sheen_sheet *sheet,
                               sheen_sheet_format format, const char *path, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
