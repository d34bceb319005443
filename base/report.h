// SPDX-License-Identifier: Apache-2.0
// report.h - a report for a person: one HTML file that needs nothing else, with plots as SVG.
//
//     sheen_report r = {0};
//     sheen_report_begin(&r, "Calibration", true, "good: corners fit to 0.05 px");
//     sheen_report_section(&r, "Residuals");
//     sheen_report_text(&r, "%d corners of %d frames", n, m);
//     sheen_plot p = {.title = "by angle", .x_label = "deg", .y_label = "px", .x_max = 90, .y_max = 1};
//     sheen_plot_begin(&r, &p);
//     sheen_plot_points(&r, &p, xy, n, NULL, 1.5);
//     sheen_plot_end(&r, &p);
//     s = sheen_report_save(&r, path, err);        // atomic; releases the report
//
// All text is escaped. Running out of memory is remembered and reported once, at the end. Numbers that are not
// finite are left out of plots and written as a dash in tables.
#ifndef SHEEN_BASE_REPORT_H
#define SHEEN_BASE_REPORT_H

#include <stdbool.h>
#include <stddef.h>

#include "base/image.h"
#include "base/status.h"
#include "base/text.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_report {
    sheen_text text;
    bool in_section, in_table, in_flow; // what is open
} sheen_report;

// ---- report.c: the page

// Starts the page with a title and a verdict of one sentence, marked as good or as asking for something.
void sheen_report_begin(sheen_report *r, const char *title, bool good, const char *verdict);
// A heading; ends the section before it.
void sheen_report_section(sheen_report *r, const char *heading);
// A paragraph.
void sheen_report_text(sheen_report *r, const char *fmt, ...) SHEEN_PRINTF(2, 3);
// A table: headings parted by '|', then rows likewise; whatever comes next ends it. The first cell of a row is its
// name, numbers stand right.
void sheen_report_table(sheen_report *r, const char *headings);
void sheen_report_row(sheen_report *r, const char *fmt, ...) SHEEN_PRINTF(2, 3);
// An 8-bit picture (1, 3 or 4 channels) as it is, embedded as a PNG, `width_px` wide on the page (0: its own width).
sheen_status sheen_report_picture(sheen_report *r, const sheen_raster *picture, int width_px,
                                  const char *caption, sheen_err *err);
// Ends the page, writes it, and releases the report.
sheen_status sheen_report_save(sheen_report *r, const char *path, sheen_err *err);
void sheen_report_release(sheen_report *r);
// Raw text, for report_plot.c.
void sheen_report_raw(sheen_report *r, const char *fmt, ...) SHEEN_PRINTF(2, 3);
void sheen_report_escaped(sheen_report *r, const char *text);
// Before a figure: plots and pictures that follow each other stand side by side where there is room.
void sheen_report_flow(sheen_report *r);

// ---- report_plot.c: plots

typedef struct sheen_plot {
    const char *title, *x_label, *y_label; // NULL: none
    double x_min, x_max, y_min, y_max;     // of the axes
    bool y_down;                           // as in a picture
    bool same_scale;                       // x and y of one scale: the plot's height follows
    int width_px;                          // 0: 440
    // Set by sheen_plot_begin: the axes' rectangle, in px.
    double left, top, right, bottom;
} sheen_plot;

// Colours are CSS ones ("#c33"); NULL is the usual one.
void sheen_plot_begin(sheen_report *r, sheen_plot *p);
void sheen_plot_end(sheen_report *r, sheen_plot *p);
// xy[2n]; points beyond the axes are left out.
void sheen_plot_points(sheen_report *r, const sheen_plot *p, const double *xy, size_t n, const char *colour,
                       double radius_px);
// One point in a colour of its own: value from 0 to 1 of the scale, or with `wheel` an angle in turns.
void sheen_plot_point(sheen_report *r, const sheen_plot *p, double x, double y, double value, bool wheel,
                      double radius_px);
void sheen_plot_line(sheen_report *r, const sheen_plot *p, const double *xy, size_t n, const char *colour);
void sheen_plot_arrow(sheen_report *r, const sheen_plot *p, const double from[2], const double to[2],
                      const char *colour);
void sheen_plot_label(sheen_report *r, const sheen_plot *p, double x, double y, const char *words);
// Upright bars from y = 0 (or y_min) of n bins from x_min to x_max.
void sheen_plot_bars(sheen_report *r, const sheen_plot *p, const double *values, size_t n,
                     const char *colour);
// values[n_rows][n_cols] as coloured cells over the axes' whole rectangle, from low to high, with a scale at the
// right; not finite ones stay empty. Each cell shows its value with so many decimals; -1: it does not.
void sheen_plot_cells(sheen_report *r, const sheen_plot *p, const double *values, const int size[2],
                      const double range[2], int decimals);

#ifdef __cplusplus
}
#endif
#endif
