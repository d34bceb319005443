// SPDX-License-Identifier: Apache-2.0
// board_sheet_cairo.c - draws a sheet through cairo: the one file that includes it.
//
// All that is black is one path, filled once: renderers then leave no hair lines between the cells of a tag. The
// surface's unit is the point (1/72 inch), of which cairo keeps 1/256: 1.4 micrometres on paper.
#include "calib/board_sheet.h"

#include <cairo/cairo-pdf.h>
#include <cairo/cairo-svg.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/bytes.h"
#include "base/file.h"
#include "calib/detect.h"

enum { RULER_MAX_MM = 200, RULER_STEP_MM = 10 };

static const double POINTS_PER_MM = 72 / 25.4;
static const double RIM_MM = 6; // between the squares and a ruler
static const double LINE_MM = 0.1, TEXT_MM = 3;

static cairo_status_t append(void *closure, const unsigned char *data, unsigned length)
{
    sheen_bytes *out = closure;
    return sheen_bytes_put(out, out->size_bytes, data, length) ? CAIRO_STATUS_SUCCESS
                                                               : CAIRO_STATUS_NO_MEMORY;
}

// The black cells of a tag whose black border's upper left is at (x, y) mm.
static void add_tag(cairo_t *cr, const sheen_tag_picture *picture, double x, double y, double side_mm)
{
    const double cell = side_mm / picture->side;
    for (int row = 0; row < picture->side; row++)
        for (int col = 0; col < picture->side; col++)
            if (!picture->white[row][col])
                cairo_rectangle(cr, x + col * cell, y + row * cell, cell, cell);
}

static sheen_status draw_board(cairo_t *cr, const sheen_board *board, const sheen_sheet *sheet,
                               sheen_err *err)
{
    const double square_mm = 1000 * board->square_m, tag_mm = 1000 * board->tag_side_m;
    const double rim_mm = (square_mm - tag_mm) / 2;
    for (int row = 0; row < board->n_rows; row++)
        for (int col = row % 2; col < board->n_cols; col += 2)
            cairo_rectangle(cr, sheet->board_x_mm + col * square_mm, sheet->board_y_mm + row * square_mm,
                            square_mm, square_mm);
    for (size_t i = 0; i < board->n_tags; i++) {
        sheen_tag_picture picture;
        if (!board->tags[i].printed)
            continue;
        const sheen_status s = sheen_tag_picture_get(&picture, board->family, board->tags[i].id, err);
        if (s)
            return s;
        add_tag(cr, &picture, sheet->board_x_mm + board->tags[i].col * square_mm + rim_mm,
                sheet->board_y_mm + board->tags[i].row * square_mm + rim_mm, tag_mm);
    }
    cairo_set_source_rgb(cr, 0, 0, 0);
    cairo_fill(cr);
    if (board->blank_radius_m > 0) {
        const double x = sheet->board_x_mm + sheet->board_width_mm / 2;
        const double y = sheet->board_y_mm + sheet->board_height_mm / 2;
        cairo_arc(cr, x, y, 1000 * board->blank_radius_m, 0, 2 * acos(-1.0));
        cairo_set_source_rgb(cr, 1, 1, 1);
        cairo_fill(cr);
    }
    return SHEEN_OK;
}

static void say(cairo_t *cr, double x, double y, const char *text)
{
    cairo_move_to(cr, x, y);
    cairo_show_text(cr, text);
}

// A scale along the axis from (x, y) on, with a mark each millimetre away from the board.
static void draw_ruler(cairo_t *cr, double x, double y, double room_mm, bool down)
{
    const int length_mm = (int)fmin(RULER_MAX_MM, floor(room_mm / RULER_STEP_MM) * RULER_STEP_MM);
    cairo_set_line_width(cr, LINE_MM);
    for (int i = 0; i <= length_mm; i++) {
        const double tick = i % 10 == 0 ? 4 : i % 5 == 0 ? 3 : 2;
        cairo_move_to(cr, x + (down ? 0 : i), y + (down ? i : 0));
        cairo_rel_line_to(cr, down ? tick : 0, down ? 0 : tick);
    }
    cairo_move_to(cr, x, y);
    cairo_rel_line_to(cr, down ? 0 : length_mm, down ? length_mm : 0);
    cairo_stroke(cr);
    for (int i = 0; i <= length_mm; i += RULER_STEP_MM) {
        char text[16];
        snprintf(text, sizeof text, "%d", i);
        say(cr, x + (down ? 4.5 : i - 1), y + (down ? i + 1 : 7), text);
    }
}

static void draw_margins(cairo_t *cr, const sheen_board *board, const sheen_sheet *sheet)
{
    char text[256];
    const double below = sheet->board_y_mm + sheet->board_height_mm + RIM_MM;
    cairo_select_font_face(cr, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cr, TEXT_MM);
    cairo_set_source_rgb(cr, 0, 0, 0);
    draw_ruler(cr, sheet->board_x_mm, below, sheet->board_width_mm, false);
    draw_ruler(cr, sheet->board_x_mm + sheet->board_width_mm + RIM_MM, sheet->board_y_mm,
               sheet->board_height_mm, true);
    snprintf(text, sizeof text, "%s%s%d x %d squares of %g mm, %s %d to %d, tags of %g mm", board->name,
             board->name[0] ? ": " : "", board->n_cols, board->n_rows, 1000 * board->square_m, board->family,
             board->tags[0].id, board->tags[board->n_tags - 1].id, 1000 * board->tag_side_m);
    say(cr, sheet->board_x_mm, below + 12, text);
    snprintf(text, sizeof text,
             "Print at 100 %%. Measure both rulers; then the %d squares across: %g mm, or tell "
             "sheen board --measured-mm.",
             board->n_cols, sheet->board_width_mm);
    say(cr, sheet->board_x_mm, below + 16, text);
}

static cairo_surface_t *open_surface(const sheen_sheet *sheet, sheen_sheet_format format, sheen_bytes *out)
{
    const double width = sheet->width_mm * POINTS_PER_MM, height = sheet->height_mm * POINTS_PER_MM;
    return format == SHEEN_SHEET_PDF ? cairo_pdf_surface_create_for_stream(append, out, width, height)
                                     : cairo_svg_surface_create_for_stream(append, out, width, height);
}

sheen_status sheen_sheet_print(const sheen_board *boards, size_t n, const sheen_sheet *sheet,
                               sheen_sheet_format format, const char *path, sheen_err *err)
{
    sheen_bytes out = {0};
    if (!n || (format == SHEEN_SHEET_SVG && n > 1))
        return sheen_fail(err, SHEEN_EARG, "%zu boards do not make one picture", n);
    cairo_surface_t *surface = open_surface(sheet, format, &out);
    cairo_t *cr = cairo_create(surface);
    sheen_status s = SHEEN_OK;
    for (size_t i = 0; i < n && !s; i++) {
        cairo_identity_matrix(cr);
        cairo_scale(cr, POINTS_PER_MM, POINTS_PER_MM);
        cairo_set_source_rgb(cr, 1, 1, 1);
        cairo_paint(cr); // a picture without paper would be shown on any colour
        s = draw_board(cr, &boards[i], sheet, err);
        if (!s) {
            draw_margins(cr, &boards[i], sheet);
            cairo_show_page(cr);
        }
    }
    const cairo_status_t drawn = cairo_status(cr);
    cairo_destroy(cr);
    cairo_surface_finish(surface);
    const cairo_status_t finished = cairo_surface_status(surface);
    cairo_surface_destroy(surface);
    if (!s && (drawn || finished || !out.data))
        s = sheen_fail(err, SHEEN_EIO, "cannot draw '%s': %s", path,
                       cairo_status_to_string(drawn ? drawn : finished));
    if (!s)
        s = sheen_file_write(path, out.data, out.size_bytes, err);
    free(out.data);
    return s;
}
