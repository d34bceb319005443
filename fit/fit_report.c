// SPDX-License-Identifier: Apache-2.0
// fit_report.c - puts the summary, the certainty, the scores and the pictures of model/ on one page.
#include "fit/fit_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/report.h"

static sheen_status put_picture(sheen_report *r, const sheen_session *s, const char *name,
                                const char *caption, int width_px, sheen_err *err)
{
    char file[160], path[SHEEN_PATH_MAX];
    sheen_raster raster;
    snprintf(file, sizeof file, SHEEN_SESSION_MODEL "/%s.png", name);
    sheen_status st = sheen_session_path(path, s, file, err);
    if (st || !sheen_file_exists(path))
        return st;
    if ((st = sheen_raster_load(&raster, path, err)))
        return st;
    st = sheen_report_picture(r, &raster, width_px, caption, err);
    sheen_raster_release(&raster);
    return st;
}

static void begin(sheen_report *r, const sheen_fit_summary *f)
{
    char verdict[400];
    const int good = f->converged && !f->certainty.n_sentences;
    snprintf(verdict, sizeof verdict, "%s",
             good                       ? "converged, and everything was determined"
             : f->certainty.n_sentences ? f->certainty.sentences[0]
                                        : "the turns ended before they converged");
    sheen_report_begin(r, "Fit", good, verdict);
}

static void put_figures(sheen_report *r, const sheen_fit_summary *f)
{
    sheen_report_section(r, "What was found");
    sheen_report_table(r, "|value|standard deviation");
    sheen_report_row(r, "method|%s|", f->method);
    sheen_report_row(r, "photographs|%zu|", f->n_views);
    sheen_report_row(r, "roughness sigma|%.4f rad|%.2g %%", f->sigma_rad, 100 * f->certainty.sigma_share);
    sheen_report_row(r, "k_S|%.4g|%.2g %%", f->k_s, 100 * f->certainty.k_s_share);
    if (!isnan(f->f0))
        sheen_report_row(r, "reflectance F0|%.3f|", f->f0);
    if (f->poses_refined)
        sheen_report_row(r, "poses moved by|%.2f px|%.2g px", f->pose_moved_px, f->pose_sigma_px);
    if (f->exposures_refined)
        sheen_report_row(r, "exposures differ by|%.2f EV|", f->exposure_range_ev);
    sheen_report_row(r, "lights at the end|%zu|", f->n_left);
    sheen_report_row(r, "surface seen|%.1f %%|", 100 * f->seen_share);
}

static void put_certainty(sheen_report *r, const sheen_certainty *c)
{
    sheen_report_section(r, "How sure it is");
    if (!c->n_sentences)
        sheen_report_text(
            r, "Every light was seen in two photographs or more, and the roughness is determined.");
    for (size_t i = 0; i < c->n_sentences; i++)
        sheen_report_text(r, "%s.", c->sentences[i]);
    sheen_report_table(r, "lamp (azimuth, elevation)|strength|sd|direction sd|photographs that show it");
    for (size_t i = 0; i < c->n_lamps && i < 16; i++) {
        const sheen_lamp_certainty *l = &c->lamps[i];
        const double az = atan2(l->v_world[1], l->v_world[0]) * 57.29577951308232;
        sheen_report_row(r, "%.0f, %.0f degrees|%.3g|%.2g %%|%.2g degrees|%zu", az < 0 ? az + 360 : az,
                         asin(fmax(-1, fmin(1, l->v_world[2]))) * 57.29577951308232, l->strength,
                         100 * l->strength_share, l->direction_rad * 57.29577951308232, l->n_views);
    }
    sheen_report_text(r, "Standard deviations from the Jacobian at the optimum and from how the residuals "
                         "scatter over the surface, "
                         "with the texture held fixed; what the model itself cannot say is not in them.");
    for (int k = 0; k < c->n_gloss; k++)
        if (c->gloss_share[k] > 0)
            sheen_report_text(r, "k_S of paint %d, against the most shining one: known to %.2g %%.", k + 1,
                              100 * c->gloss_share[k]);
}

static void put_turns(sheen_report *r, const sheen_fit_summary *f)
{
    double *xy = malloc((2 * f->n_turns + 2) * sizeof *xy), most = 0, least = HUGE_VAL;
    if (!xy || f->n_turns < 2) {
        free(xy);
        return;
    }
    for (size_t i = 0; i < f->n_turns; i++) {
        xy[2 * i] = (double)i + 1;
        xy[2 * i + 1] = f->turns[i].objective;
        most = fmax(most, f->turns[i].objective);
        least = fmin(least, f->turns[i].objective);
    }
    const double margin = 0.05 * (most - least) + 1e-9;
    sheen_plot p = {.title = "Objective E after each turn",
                    .x_label = "turn",
                    .y_label = "E",
                    .x_min = 1,
                    .x_max = (double)f->n_turns,
                    .y_min = least - margin,
                    .y_max = most + margin};
    sheen_report_section(r, "How it came about");
    sheen_plot_begin(r, &p);
    sheen_plot_line(r, &p, xy, f->n_turns, NULL);
    sheen_plot_points(r, &p, xy, f->n_turns, NULL, 2);
    sheen_plot_end(r, &p);
    free(xy);
}

static void put_scores(sheen_report *r, const sheen_evaluation *e)
{
    sheen_report_section(r, "On photographs that it has not seen");
    if (!e) {
        sheen_report_text(
            r, "The session has no test frames: import some with --role test, or see what 'sheen eval "
               "--holdout' says.");
        return;
    }
    sheen_report_table(r, "dB|object, sRGB|object, linear|highlights, linear");
    for (int m = 0; m < SHEEN_EVALUATION_METHODS; m++) {
        const sheen_score s = sheen_evaluation_mean(e, m);
        sheen_report_row(r, "%s|%.2f|%.2f|%.2f", sheen_evaluation_method_name(m), s.object.srgb_db,
                         s.object.linear_db, s.highlights.linear_db);
    }
}

static sheen_status put_residuals(sheen_report *r, const sheen_session *s, sheen_err *err)
{
    size_t n = 0;
    sheen_report_section(r, "Residual images: the photographs without their texture");
    for (size_t i = 0; i < s->n_frames && n < 12; i++) {
        char name[128];
        if (s->frames[i].role != SHEEN_ROLE_INPUT)
            continue;
        snprintf(name, sizeof name, "residual-%s", s->frames[i].name);
        const sheen_status st = put_picture(r, s, name, s->frames[i].name, 260, err);
        if (st)
            return st;
        n++;
    }
    return SHEEN_OK;
}

static sheen_status put_deviation(sheen_report *r, const sheen_session *s, sheen_err *err)
{
    return put_picture(
        r, s, "deviation",
        "how sure each place's colour is: standard deviation, 0.05 of white is white; what one "
        "photograph only saw is white too",
        480, err);
}

static sheen_status put_hemispheres(sheen_report *r, const sheen_session *s, sheen_err *err)
{
    sheen_status st;
    sheen_report_section(r, "The illumination hemisphere, before and after");
    if ((st = put_picture(r, s, "hemisphere-mask", "in how many photographs each direction was mirrored", 300,
                          err)) ||
        (st = put_picture(r, s, "hemisphere-combined", "what they agree on", 300, err)))
        return st;
    return put_picture(r, s, "hemisphere-refined", "the lights in the end", 300, err);
}

sheen_status sheen_fit_report_write(const char *path, const sheen_fit_report *report, sheen_err *err)
{
    sheen_report r = {0};
    sheen_status s;
    begin(&r, report->summary);
    put_figures(&r, report->summary);
    put_certainty(&r, &report->summary->certainty);
    if ((s = put_deviation(&r, report->session, err))) {
        sheen_report_release(&r);
        return s;
    }
    put_scores(&r, report->evaluation);
    if ((s = put_hemispheres(&r, report->session, err)) || (s = put_residuals(&r, report->session, err))) {
        sheen_report_release(&r);
        return s;
    }
    put_turns(&r, report->summary);
    if (report->n_timings) {
        sheen_report_section(&r, "Time");
        sheen_report_table(&r, "step|wall s|CPU s");
    }
    for (size_t i = 0; i < report->n_timings; i++)
        sheen_report_row(&r, "%s|%.2f|%.2f", report->timings[i].what, report->timings[i].wall_s,
                         report->timings[i].cpu_s);
    return sheen_report_save(&r, path, err);
}
