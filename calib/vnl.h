// SPDX-License-Identifier: Apache-2.0
// vnl.h - tables of board corners in mrcal's text format, "# filename x y level".
//
// A frame has one row for each corner of the grid, row by row from the upper left as read on the page; a corner
// that was not seen is "FILE - - -". A frame in which nothing was seen has that row once. File names are relative
// to the table's own folder; level 0 is full resolution and each further one halves a corner's weight.
#ifndef SHEEN_CALIB_VNL_H
#define SHEEN_CALIB_VNL_H

#include <stddef.h>

#include "base/board.h"
#include "base/status.h"
#include "calib/view.h"

#ifdef __cplusplus
extern "C" {
#endif

// Writes the saddles of n views (view.file, seen from the table's folder). EIO, EACCESS, ENOMEM.
sheen_status sheen_vnl_save(const char *path, const sheen_board *board, const sheen_board_view *views,
                            size_t n, sheen_err *err);

typedef struct sheen_vnl_frame {
    char file[256];
    size_t n_found;
    double *corners; // [n_rows * n_cols][3]: x, y in px, weight; weight 0 where it was not seen
} sheen_vnl_frame;

typedef struct sheen_vnl {
    int n_cols, n_rows; // corners of the grid
    size_t n_frames;
    sheen_vnl_frame *frames;
} sheen_vnl;

// Reads a table for a grid of n_cols x n_rows corners (1..1000 each). Further columns are ignored. EFORMAT: not
// such a table, a frame with another number of rows, a number that is not finite.
sheen_status sheen_vnl_parse(sheen_vnl *out, const void *data, size_t size_bytes, int n_cols, int n_rows,
                             sheen_err *err);
sheen_status sheen_vnl_load(sheen_vnl *out, const char *path, int n_cols, int n_rows, sheen_err *err);
void sheen_vnl_release(sheen_vnl *vnl);

#ifdef __cplusplus
}
#endif
#endif
