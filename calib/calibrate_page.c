// SPDX-License-Identifier: Apache-2.0
// calibrate_page.c - writes the report: what an expert asks of a calibration, in the order in which it is asked.
#include "calib/calibrate_page.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/report.h"

enum { WORST = 3, BINS = 41, MAX_POINTS = 6000, PICTURE_PX = 440 };

static const double DEG = 57.29577951308232;
static const double ARROW_PX = 20; // length on the plot, in picture px of a thousand, of one sigma of noise

static sheen_plot image_plot(const sheen_calibration *c, const char *title)
{
    return (sheen_plot){.title = title,
                        .x_label = "x, px",
                        .y_label = "y, px",
                        .x_min = -0.5,
                        .x_max = c->camera.width_px - 0.5,
                        .y_min = -0.5,
                        .y_max = c->camera.height_px - 0.5,
                        .y_down = true,
                        .same_scale = true};
}

static double length(const sheen_calibration_corner *corner)
{
    return hypot(corner->residual_px[0], corner->residual_px[1]);
}

// Plots stay small: of very many corners every n-th is shown.
static size_t stride(const sheen_calibration *c)
{
    return 1 + (size_t)c->n_corners / MAX_POINTS;
}

static void write_vignetting(sheen_report *r, const sheen_vignetting *v)
{
    if (v->measured)
        sheen_report_row(
            r,
            "light at the edge|%.1f +- %.1f %% of the centre's|%.0f %% of the way to the corners, from the "
            "board's white in %d frames, if the codes are what their transfer says",
            100 * v->light, 100 * v->sigma, 100 * v->reach, v->n_frames);
    else
        sheen_report_row(r, "light at the edge|not measured|%s", v->reason);
}

static void write_summary(sheen_report *r, const sheen_calibration *c)
{
    double worst = 0;
    for (int i = 0; i < c->n_corners; i++)
        worst = fmax(worst, length(&c->corners[i]));
    const double *k = c->camera.intrinsics;
    sheen_report_section(r, "Figures");
    sheen_report_table(r, "what|value|remark");
    sheen_report_row(r, "lens model|%s|%d parameters", c->camera.lensmodel, c->camera.n_intrinsics);
    sheen_report_row(r, "focal length|%.2f x %.2f px|image %d x %d px", k[0], k[1], c->camera.width_px,
                     c->camera.height_px);
    sheen_report_row(r, "principal point|%.2f, %.2f px|the middle is %.1f, %.1f", k[2], k[3],
                     (c->camera.width_px - 1) / 2.0, (c->camera.height_px - 1) / 2.0);
    sheen_report_row(r, "frames used|%d of %zu|", c->n_used, c->n_frames);
    sheen_report_row(r, "corners|%d|", c->n_corners);
    const double share = 100.0 * c->n_outliers / fmax(1, c->n_corners);
    sheen_report_row(r, "outliers|%d (%.1f %%)|%s", c->n_outliers, share,
                     share > 3 ? "more than 3 %: look at the frames that have them" : "up to 3 % is usual");
    sheen_report_row(r,
                     "reprojection error|%.3f px|rms an axis, over inliers; the largest residual is %.2f px",
                     c->rms_px, worst);
    sheen_report_row(r, "noise of a corner|%.3f px|an axis; the error with the fitted parameters counted off",
                     c->noise_px);
    sheen_report_row(
        r, "pattern in the residuals|%.2f|mean residual by region over what noise makes of it; 1 is none",
        c->pattern);
    sheen_report_row(r, "board's bend|%.2f, %.2f mm|its middle out of its edges, along x and y",
                     1e3 * c->warp_m[0], 1e3 * c->warp_m[1]);
    sheen_report_row(r, "working distance|%.3f m|median distance of the board", c->distance_m);
    sheen_report_row(r, "tilt|%.0f deg|largest angle between two boards", c->tilt_rad * DEG);
    sheen_report_row(r, "coverage|%.0f %%|of a grid of 6 x 4 cells", 100 * c->coverage);
    sheen_report_row(r, "uncertainty|%.3f px, %.3f px|at that distance: image centre, worst cell",
                     c->sigma_centre_px, c->sigma_worst_px);
    sheen_report_row(r, "valid region|%.0f %%|of the image is certain to %g px", 100 * c->valid_share,
                     SHEEN_VALID_SIGMA_PX);
    if (c->has_halves)
        sheen_report_row(
            r, "halves of the frames|%.3f px|rms difference of their cameras; %.2f times the predicted one",
            c->halves.moved_rms_px, c->normalised_error);
    write_vignetting(r, &c->vignetting);
}

static void write_coverage(sheen_report *r, const sheen_calibration *c)
{
    double cells[SHEEN_COVERAGE_ROWS][SHEEN_COVERAGE_COLS], most = 1;
    double *xy = malloc(2 * ((size_t)c->n_corners + 1) * sizeof *xy);
    for (int row = 0; row < SHEEN_COVERAGE_ROWS; row++)
        for (int col = 0; col < SHEEN_COVERAGE_COLS; col++) {
            cells[row][col] = c->cells[row][col];
            most = fmax(most, cells[row][col]);
        }
    sheen_report_section(r, "Where the corners are");
    sheen_report_text(
        r, "The lens is known where corners were seen. Empty cells at the edges are where the board should "
           "go next.");
    sheen_plot p = image_plot(c, "corners, all frames");
    sheen_plot_begin(r, &p);
    size_t n = 0, n_out = 0;
    for (size_t i = 0; xy && i < (size_t)c->n_corners; i += stride(c))
        if (!c->corners[i].outlier)
            memcpy(xy + 2 * n++, c->corners[i].q_px, 2 * sizeof *xy);
    if (xy)
        sheen_plot_points(r, &p, xy, n, NULL, 1);
    for (size_t i = 0; xy && i < (size_t)c->n_corners; i++)
        if (c->corners[i].outlier)
            memcpy(xy + 2 * n_out++, c->corners[i].q_px, 2 * sizeof *xy);
    if (xy)
        sheen_plot_points(r, &p, xy, n_out, "#d33", 2.2);
    sheen_plot_end(r, &p);
    p = image_plot(c, "corners in each cell");
    sheen_plot_begin(r, &p);
    sheen_plot_cells(r, &p, cells[0], (const int[2]){SHEEN_COVERAGE_COLS, SHEEN_COVERAGE_ROWS},
                     (const double[2]){0, most}, 0);
    sheen_plot_end(r, &p);
    if (n_out)
        sheen_report_text(r, "Outliers are red.");
    free(xy);
}

static void write_uncertainty(sheen_report *r, const sheen_calibration *c)
{
    double most = 0;
    for (int i = 0; i < SHEEN_SIGMA_ROWS * SHEEN_SIGMA_COLS; i++) {
        const double sigma = c->sigma_px[i / SHEEN_SIGMA_COLS][i % SHEEN_SIGMA_COLS];
        most = sigma > most && isfinite(sigma) ? sigma : most;
    }
    most = fmin(most, 10 * fmax(c->sigma_centre_px, 0.01));
    sheen_report_section(r, "How certain a projection is");
    sheen_report_text(
        r,
        "One standard deviation, in the worst direction, of the pixel at which a point %.2f m away is "
        "seen, given the noise found in the corners. Outlined: where it is at most %g px.",
        c->distance_m, SHEEN_VALID_SIGMA_PX);
    sheen_plot p = image_plot(c, "uncertainty, px");
    p.width_px = 620;
    sheen_plot_begin(r, &p);
    sheen_plot_cells(r, &p, c->sigma_px[0], (const int[2]){SHEEN_SIGMA_COLS, SHEEN_SIGMA_ROWS},
                     (const double[2]){0, most}, -1);
    sheen_plot_line(r, &p, c->region_px[0], (size_t)c->n_region, "#fff");
    sheen_plot_end(r, &p);
}

static void plot_points(sheen_report *r, const sheen_calibration *c, bool by_direction)
{
    const double turn = 6.283185307179586;
    sheen_plot p = image_plot(c, by_direction ? "direction of residuals (hue)" : "size of residuals");
    sheen_plot_begin(r, &p);
    for (size_t i = 0; i < (size_t)c->n_corners; i += stride(c)) {
        const sheen_calibration_corner *corner = &c->corners[i];
        const double value = by_direction ? atan2(corner->residual_px[1], corner->residual_px[0]) / turn
                                          : length(corner) / (4 * fmax(c->noise_px, 1e-6));
        if (!corner->outlier)
            sheen_plot_point(r, &p, corner->q_px[0], corner->q_px[1], value, by_direction, 1.8);
    }
    sheen_plot_end(r, &p);
}

// Mean residual of each coverage cell as an arrow, its rms as the colour.
static void plot_regions(sheen_report *r, const sheen_calibration *c)
{
    enum { N = SHEEN_COVERAGE_ROWS * SHEEN_COVERAGE_COLS };
    double rms[N], most = 0;
    sheen_plot p = image_plot(c, "rms by region; arrows: mean");
    for (int i = 0; i < N; i++) {
        rms[i] = c->regions[i].n ? c->regions[i].rms_px : (double)NAN;
        most = rms[i] > most ? rms[i] : most;
    }
    sheen_plot_begin(r, &p);
    sheen_plot_cells(r, &p, rms, (const int[2]){SHEEN_COVERAGE_COLS, SHEEN_COVERAGE_ROWS},
                     (const double[2]){0, most}, 3);
    const double scale = ARROW_PX * c->camera.width_px / 1000 / fmax(c->noise_px, 1e-6) * 4;
    for (int i = 0; i < N; i++) {
        const double from[2] = {(i % SHEEN_COVERAGE_COLS + 0.5) / SHEEN_COVERAGE_COLS * c->camera.width_px,
                                (i / SHEEN_COVERAGE_COLS + 0.72) / SHEEN_COVERAGE_ROWS * c->camera.height_px};
        const double to[2] = {from[0] + scale * c->regions[i].mean_px[0],
                              from[1] + scale * c->regions[i].mean_px[1]};
        if (c->regions[i].n)
            sheen_plot_arrow(r, &p, from, to, "#fff");
    }
    sheen_plot_end(r, &p);
}

static void plot_histogram(sheen_report *r, const sheen_calibration *c)
{
    double bins[BINS] = {0}, curve[2 * 101], most = 0;
    const double reach = 4.5 * fmax(c->rms_px, 1e-6);
    int n = 0;
    for (int i = 0; i < c->n_corners; i++)
        for (int k = 0; k < 2 && !c->corners[i].outlier; k++, n++) {
            const int bin = (int)floor((c->corners[i].residual_px[k] / reach + 1) / 2 * BINS);
            if (bin >= 0 && bin < BINS)
                bins[bin]++;
        }
    for (int i = 0; i < BINS; i++)
        most = fmax(most, bins[i]);
    sheen_plot p = {.title = "residuals against a normal distribution",
                    .x_label = "residual along an axis, px",
                    .y_label = "corners",
                    .x_min = -reach,
                    .x_max = reach,
                    .y_max = 1.1 * most};
    for (int i = 0; i <= 100; i++) {
        const double x = -reach + 2 * reach * i / 100, t = x / c->rms_px;
        curve[2 * i] = x;
        curve[2 * i + 1] = n * (2 * reach / BINS) / (c->rms_px * sqrt(6.283185307179586)) * exp(-t * t / 2);
    }
    sheen_plot_begin(r, &p);
    sheen_plot_bars(r, &p, bins, BINS, NULL);
    sheen_plot_line(r, &p, curve, 101, "#d33");
    sheen_plot_end(r, &p);
}

static void write_residuals(sheen_report *r, const sheen_calibration *c)
{
    sheen_report_section(r, "Residuals");
    sheen_report_text(
        r, "Neighbours of one colour in the second plot, or long arrows in the third, are what the lens "
           "model cannot follow, or a board that moved or bent during a frame.");
    plot_points(r, c, false);
    plot_points(r, c, true);
    plot_regions(r, c);
    plot_histogram(r, c);
}

static void write_validation(sheen_report *r, const sheen_calibration *c)
{
    sheen_report_section(r, "Cross-validation");
    if (c->has_halves) {
        sheen_report_text(
            r,
            "One camera from the even frames and one from the odd: how they differ, and how that "
            "compares with their uncertainties: %.2f times what these predict (0.8 to 1.25 in the mean "
            "of many calibrations; beyond 2 the frames disagree by more than noise).",
            c->normalised_error);
        sheen_report_table(r, "difference|rms, px|largest, px");
        sheen_report_row(r, "as they are|%.3f|%.3f", c->halves.raw_rms_px, c->halves.raw_max_px);
        sheen_report_row(r, "after the best turn|%.3f|%.3f", c->halves.turned_rms_px,
                         c->halves.turned_max_px);
        sheen_report_row(r, "after the best turn and move, at the working distance|%.3f|%.3f",
                         c->halves.moved_rms_px, c->halves.moved_max_px);
    } else
        sheen_report_text(r, "Too few frames to make a camera from each half: take %d or more.",
                          2 * (int)SHEEN_CALIBRATE_MIN_FRAMES);
    if (!c->n_candidates)
        return;
    sheen_report_text(r, "Lens models, each solved with one half of the frames, on the other half:");
    sheen_report_table(r, "model|held-out error, px rms");
    for (int i = 0; i < c->n_candidates; i++)
        sheen_report_row(r, "%s|%.4f", c->candidates[i].name, c->candidates[i].held_out_px);
}

// Half, third, ... of a picture, by means of blocks, in grey.
static sheen_status shrink(sheen_raster *out, const sheen_raster *in, sheen_err *err)
{
    const int k = (in->width_px + PICTURE_PX - 1) / PICTURE_PX;
    const int width = in->width_px / k, height = in->height_px / k;
    uint8_t *grey = malloc((size_t)in->width_px * (size_t)in->height_px);
    sheen_status s = grey ? sheen_raster_init(out, width, height, 1, 8, err)
                          : sheen_fail_memory(err, (double)in->width_px * in->height_px, "a picture");
    if (!s) {
        uint8_t *to = out->data;
        sheen_raster_grey(grey, in, SHEEN_TRANSFER_SRGB);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                int sum = 0;
                for (int i = 0; i < k * k; i++)
                    sum += grey[(size_t)(y * k + i / k) * (size_t)in->width_px + (size_t)(x * k + i % k)];
                to[(size_t)y * (size_t)width + (size_t)x] = (uint8_t)(sum / (k * k));
            }
    }
    free(grey);
    return s;
}

static sheen_status write_picture(sheen_report *r, const sheen_frame_pictures *pictures, size_t i,
                                  const char *caption, sheen_err *err)
{
    sheen_raster full = {0}, small = {0};
    if (!pictures || !pictures->read || pictures->read(pictures->self, i, &full, NULL))
        return SHEEN_OK;
    sheen_status s = shrink(&small, &full, err);
    if (!s)
        s = sheen_report_picture(r, &small, small.width_px, caption, err);
    sheen_raster_release(&small);
    sheen_raster_release(&full);
    return s;
}

static void plot_frame(sheen_report *r, const sheen_calibration *c, size_t i_frame)
{
    char title[160];
    const double scale = ARROW_PX * c->camera.width_px / 1000 / fmax(c->noise_px, 1e-6);
    snprintf(title, sizeof title, "%s: residuals, x %.0f", c->frames[i_frame].name, scale);
    sheen_plot p = image_plot(c, title);
    sheen_plot_begin(r, &p);
    for (int i = 0; i < c->n_corners; i++) {
        const sheen_calibration_corner *corner = &c->corners[i];
        const double *q = corner->q_px;
        if (corner->i_frame != (int)i_frame)
            continue;
        if (corner->outlier)
            sheen_plot_points(r, &p, q, 1, "#d33", 3);
        else
            sheen_plot_arrow(r, &p, q,
                             (const double[2]){q[0] + scale * corner->residual_px[0],
                                               q[1] + scale * corner->residual_px[1]},
                             NULL);
    }
    sheen_plot_end(r, &p);
}

// How bad a frame is: unused ones are not ranked.
static double badness(const sheen_calibration_frame *f)
{
    return f->used ? f->rms_px * (1 + (double)f->n_outliers / fmax(1, f->n_corners)) : -1;
}

static sheen_status write_frames(sheen_report *r, const sheen_calibration *c,
                                 const sheen_frame_pictures *pictures, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    double above = INFINITY;
    sheen_report_section(r, "The worst frames");
    for (int rank = 0; rank < WORST && rank < c->n_used && !s; rank++) {
        size_t worst = 0;
        double most = -1;
        for (size_t i = 0; i < c->n_frames; i++)
            if (badness(&c->frames[i]) < above && badness(&c->frames[i]) > most) {
                most = badness(&c->frames[i]);
                worst = i;
            }
        if (most < 0)
            break;
        above = most;
        char caption[200];
        snprintf(caption, sizeof caption, "%s: %.3f px rms, %d of %d corners are outliers",
                 c->frames[worst].name, c->frames[worst].rms_px, c->frames[worst].n_outliers,
                 c->frames[worst].n_corners);
        s = write_picture(r, pictures, worst, caption, err);
        plot_frame(r, c, worst);
    }
    sheen_report_section(r, "Every frame");
    sheen_report_table(r, "frame|corners|outliers|rms, px|distance, m|remark");
    for (size_t i = 0; i < c->n_frames; i++) {
        const sheen_calibration_frame *f = &c->frames[i];
        const double *t = f->rt_cam_board + 3;
        if (f->used)
            sheen_report_row(r, "%s|%d|%d|%.3f|%.3f|", f->name, f->n_corners, f->n_outliers, f->rms_px,
                             sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]));
        else
            sheen_report_row(r, "%s|%d||||not used: %s", f->name, f->n_corners, f->reason);
    }
    return s;
}

sheen_status sheen_calibration_page(const sheen_calibration *c, const sheen_frame_pictures *pictures,
                                    const char *title, const char *path, sheen_err *err)
{
    sheen_report r = {0};
    sheen_report_begin(&r, title, c->good, c->verdict);
    write_summary(&r, c);
    write_coverage(&r, c);
    write_uncertainty(&r, c);
    write_residuals(&r, c);
    write_validation(&r, c);
    const sheen_status s = write_frames(&r, c, pictures, err);
    if (s) {
        sheen_report_release(&r);
        return s;
    }
    return sheen_report_save(&r, path, err);
}
