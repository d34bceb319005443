// SPDX-License-Identifier: Apache-2.0
// report_plot.c - plots as SVG: axes with round numbers, points, lines, arrows, bars, coloured cells.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/report.h"

enum { WIDTH_PX = 440, MAX_TICKS = 12 };

static const double LEFT_PX = 58, RIGHT_PX = 64, TOP_PX = 26, BOTTOM_PX = 42, TALL = 0.62, TALLEST = 1.6;

// From dark blue over green to yellow: lightness rises all the way, so that it also reads in grey.
static const double scale_rgb[][3] = {{68, 20, 95},   {62, 74, 137},  {44, 113, 142},
                                      {38, 160, 136}, {109, 206, 88}, {248, 226, 50}};

static void scale_colour(char out[32], double value)
{
    const int n = (int)(sizeof scale_rgb / sizeof *scale_rgb) - 1;
    const double t = fmin(1, fmax(0, value)) * n;
    const int i = t >= n ? n - 1 : (int)t;
    int rgb[3];
    for (int k = 0; k < 3; k++)
        rgb[k] = (int)lround(scale_rgb[i][k] + (t - i) * (scale_rgb[i + 1][k] - scale_rgb[i][k]));
    snprintf(out, 32, "rgb(%d,%d,%d)", rgb[0], rgb[1], rgb[2]);
}

static double x_at(const sheen_plot *p, double x)
{
    return p->left + (x - p->x_min) / (p->x_max - p->x_min) * (p->right - p->left);
}

static double y_at(const sheen_plot *p, double y)
{
    const double t = (y - p->y_min) / (p->y_max - p->y_min);
    return p->y_down ? p->top + t * (p->bottom - p->top) : p->bottom - t * (p->bottom - p->top);
}

static bool inside(const sheen_plot *p, double x, double y)
{
    return x >= p->x_min && x <= p->x_max && y >= p->y_min && y <= p->y_max;
}

// A step of 1, 2 or 5 times a power of ten that cuts `range` into about `wanted` parts.
static double round_step(double range, int wanted)
{
    const double raw = range / wanted, power = pow(10, floor(log10(raw))), lead = raw / power;
    return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

static void text(sheen_report *r, double x, double y, const char *anchor, const char *words)
{
    sheen_report_raw(r, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", x, y, anchor);
    sheen_report_escaped(r, words);
    sheen_report_raw(r, "</text>\n");
}

static void draw_ticks(sheen_report *r, const sheen_plot *p, bool across)
{
    const double low = across ? p->x_min : p->y_min, high = across ? p->x_max : p->y_max;
    const double step = round_step(high - low, across ? 6 : 5);
    const double first = ceil(low / step - 1e-9);
    for (int i = 0; i < MAX_TICKS; i++) {
        const double value = (first + i) * step;
        if (value > high + 1e-9 * step)
            break;
        char label[32];
        snprintf(label, sizeof label, "%.4g", fabs(value) < 1e-9 * step ? 0 : value);
        if (across) {
            const double x = x_at(p, value);
            sheen_report_raw(r, "<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", x,
                             p->top, x, p->bottom);
            text(r, x, p->bottom + 14, "middle", label);
        } else {
            const double y = y_at(p, value);
            sheen_report_raw(r, "<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>",
                             p->left, y, p->right, y);
            text(r, p->left - 5, y + 4, "end", label);
        }
    }
}

void sheen_plot_begin(sheen_report *r, sheen_plot *p)
{
    const double width = p->width_px > 0 ? p->width_px : WIDTH_PX;
    if (!(p->x_max > p->x_min) || !isfinite(p->x_max - p->x_min))
        p->x_max = p->x_min + 1;
    if (!(p->y_max > p->y_min) || !isfinite(p->y_max - p->y_min))
        p->y_max = p->y_min + 1;
    const double inner = width - LEFT_PX - RIGHT_PX;
    const double ratio = p->same_scale ? (p->y_max - p->y_min) / (p->x_max - p->x_min) : TALL;
    p->left = LEFT_PX;
    p->right = LEFT_PX + inner;
    p->top = TOP_PX;
    p->bottom = TOP_PX + inner * fmin(TALLEST, ratio);
    if (p->same_scale && ratio > TALLEST)
        p->right = p->left + inner * TALLEST / ratio;
    sheen_report_flow(r);
    sheen_report_raw(r, "<figure><svg width=\"%.0f\" viewBox=\"0 0 %.0f %.0f\">\n", width, width,
                     p->bottom + BOTTOM_PX);
    if (p->title)
        text(r, (p->left + p->right) / 2, 16, "middle", p->title);
    draw_ticks(r, p, true);
    draw_ticks(r, p, false);
    sheen_report_raw(
        r, "<rect class=\"axis\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\"/>\n",
        p->left, p->top, p->right - p->left, p->bottom - p->top);
    if (p->x_label)
        text(r, (p->left + p->right) / 2, p->bottom + 32, "middle", p->x_label);
    if (p->y_label) {
        sheen_report_raw(r, "<g transform=\"translate(14 %.1f) rotate(-90)\">", (p->top + p->bottom) / 2);
        text(r, 0, 0, "middle", p->y_label);
        sheen_report_raw(r, "</g>\n");
    }
}

void sheen_plot_end(sheen_report *r, sheen_plot *p)
{
    (void)p;
    sheen_report_raw(r, "</svg></figure>\n");
}

static const char *colour_or(const char *colour)
{
    return colour ? colour : "var(--mark)";
}

void sheen_plot_points(sheen_report *r, const sheen_plot *p, const double *xy, size_t n, const char *colour,
                       double radius_px)
{
    sheen_report_raw(r, "<g fill=\"%s\">", colour_or(colour));
    for (size_t i = 0; i < n; i++)
        if (inside(p, xy[2 * i], xy[2 * i + 1]))
            sheen_report_raw(r, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\"/>", x_at(p, xy[2 * i]),
                             y_at(p, xy[2 * i + 1]), radius_px);
    sheen_report_raw(r, "</g>\n");
}

void sheen_plot_point(sheen_report *r, const sheen_plot *p, double x, double y, double value, bool wheel,
                      double radius_px)
{
    char colour[32];
    if (!inside(p, x, y) || !isfinite(value))
        return;
    if (wheel)
        snprintf(colour, sizeof colour, "hsl(%.0f 75%% 50%%)", 360 * (value - floor(value)));
    else
        scale_colour(colour, value);
    sheen_report_raw(r, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"%s\"/>", x_at(p, x), y_at(p, y),
                     radius_px, colour);
}

void sheen_plot_line(sheen_report *r, const sheen_plot *p, const double *xy, size_t n, const char *colour)
{
    bool open = false;
    for (size_t i = 0; i < n; i++) {
        const bool in = inside(p, xy[2 * i], xy[2 * i + 1]);
        if (in && !open)
            sheen_report_raw(r, "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"1.6\" points=\"",
                             colour_or(colour));
        if (in)
            sheen_report_raw(r, "%.1f,%.1f ", x_at(p, xy[2 * i]), y_at(p, xy[2 * i + 1]));
        if (open && !in)
            sheen_report_raw(r, "\"/>\n");
        open = in;
    }
    if (open)
        sheen_report_raw(r, "\"/>\n");
}

void sheen_plot_arrow(sheen_report *r, const sheen_plot *p, const double from[2], const double to[2],
                      const char *colour)
{
    const double x1 = x_at(p, from[0]), y1 = y_at(p, from[1]), x2 = x_at(p, to[0]), y2 = y_at(p, to[1]);
    const double length = hypot(x2 - x1, y2 - y1);
    if (!isfinite(length) || !inside(p, from[0], from[1]))
        return;
    sheen_report_raw(r, "<path fill=\"none\" stroke=\"%s\" d=\"M%.1f %.1fL%.1f %.1f", colour_or(colour), x1,
                     y1, x2, y2);
    if (length > 2) {
        const double head = fmin(4, length / 2), ux = (x2 - x1) / length, uy = (y2 - y1) / length;
        sheen_report_raw(r, "M%.1f %.1fL%.1f %.1fL%.1f %.1f", x2 - head * (ux + uy / 2),
                         y2 - head * (uy - ux / 2), x2, y2, x2 - head * (ux - uy / 2),
                         y2 - head * (uy + ux / 2));
    }
    sheen_report_raw(r, "\"/>\n");
}

void sheen_plot_label(sheen_report *r, const sheen_plot *p, double x, double y, const char *words)
{
    text(r, x_at(p, x) + 4, y_at(p, y) - 3, "start", words);
}

void sheen_plot_bars(sheen_report *r, const sheen_plot *p, const double *values, size_t n, const char *colour)
{
    const double step = (p->right - p->left) / (double)n;
    sheen_report_raw(r, "<g fill=\"%s\">", colour_or(colour));
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(values[i]))
            continue;
        const double y = y_at(p, fmin(p->y_max, fmax(p->y_min, values[i])));
        sheen_report_raw(r, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>",
                         p->left + (double)i * step + 0.3, y, fmax(0.5, step - 0.6), fmax(0, p->bottom - y));
    }
    sheen_report_raw(r, "</g>\n");
}

static void draw_scale(sheen_report *r, const sheen_plot *p, const double range[2])
{
    enum { STEPS = 24 };
    const double height = (p->bottom - p->top) / STEPS, x = p->right + 10;
    char colour[32], label[32];
    for (int i = 0; i < STEPS; i++) {
        scale_colour(colour, (i + 0.5) / STEPS);
        sheen_report_raw(r, "<rect x=\"%.1f\" y=\"%.1f\" width=\"10\" height=\"%.1f\" fill=\"%s\"/>", x,
                         p->bottom - (i + 1) * height, height + 0.4, colour);
    }
    snprintf(label, sizeof label, "%.3g", range[1]);
    text(r, x + 13, p->top + 9, "start", label);
    snprintf(label, sizeof label, "%.3g", range[0]);
    text(r, x + 13, p->bottom, "start", label);
}

static void draw_cell(sheen_report *r, const double box[4], double value, double t, int decimals)
{
    char colour[32];
    scale_colour(colour, t);
    sheen_report_raw(r, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"%s\"/>\n", box[0],
                     box[1], box[2] + 0.3, box[3] + 0.3, colour);
    if (decimals >= 0)
        sheen_report_raw(
            r, "<text style=\"fill:%s\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.*f</text>\n",
            t > 0.6 ? "#000" : "#fff", box[0] + box[2] / 2, box[1] + box[3] / 2 + 4, decimals, value);
}

void sheen_plot_cells(sheen_report *r, const sheen_plot *p, const double *values, const int size[2],
                      const double range[2], int decimals)
{
    const double w = (p->right - p->left) / size[0], h = (p->bottom - p->top) / size[1];
    for (int row = 0; row < size[1]; row++)
        for (int col = 0; col < size[0]; col++) {
            const double value = values[row * size[0] + col];
            const double t = range[1] > range[0] ? (value - range[0]) / (range[1] - range[0]) : 0;
            const double y = p->y_down ? p->top + row * h : p->bottom - (row + 1) * h;
            if (isfinite(value))
                draw_cell(r, (const double[4]){p->left + col * w, y, w, h}, value, t, decimals);
        }
    draw_scale(r, p, range);
}
