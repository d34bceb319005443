// SPDX-License-Identifier: Apache-2.0
// evaluate_report.c - an evaluation as a table and as JSON.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fit/evaluate_session.h"

char *sheen_evaluation_table(const sheen_evaluation *e)
{
    enum { SIZE = 4096 };
    char *text = malloc(SIZE);
    if (!text)
        return NULL;
    size_t n = (size_t)snprintf(
        text, SIZE,
        "| dB | object, sRGB | object, linear | highlights, sRGB | highlights, linear "
        "| ORB PSNR-H | ORB PSNR-L | ORB SSIM |\n|---|---|---|---|---|---|---|---|\n");
    for (int m = 0; m < SHEEN_EVALUATION_METHODS; m++) {
        const sheen_score s = sheen_evaluation_mean(e, m);
        const char *bold = m ? "" : "**";
        n += (size_t)snprintf(
            text + n, SIZE - n, "| %s%s%s | %s%.2f%s | %.2f | %.2f | %s%.2f%s | %.2f | %.2f | %.4f |\n", bold,
            sheen_evaluation_method_name(m), bold, bold, s.object.srgb_db, bold, s.object.linear_db,
            s.highlights.srgb_db, bold, s.highlights.linear_db, bold, s.orb.hdr_db, s.orb.ldr_db, s.orb.ssim);
    }
    return text;
}

static void write_score(sheen_json_writer *w, const char *key, const sheen_score *s)
{
    sheen_json_open(w, key, '{');
    sheen_json_put_number(w, "object_srgb_db", s->object.srgb_db);
    sheen_json_put_number(w, "object_linear_db", s->object.linear_db);
    sheen_json_put_number(w, "highlights_srgb_db", s->highlights.srgb_db);
    sheen_json_put_number(w, "highlights_linear_db", s->highlights.linear_db);
    sheen_json_put_number(w, "frame_srgb_db", s->frame.srgb_db);
    sheen_json_put_number(w, "orb_psnr_h_db", s->orb.hdr_db);
    sheen_json_put_number(w, "orb_psnr_l_db", s->orb.ldr_db);
    sheen_json_put_number(w, "orb_ssim", s->orb.ssim);
    sheen_json_put_number(w, "hole_share", s->hole_share);
    sheen_json_put_int(w, "object_pixels", (long long)s->object.n_pixels);
    sheen_json_put_int(w, "highlight_pixels", (long long)s->highlights.n_pixels);
    sheen_json_close(w);
}

void sheen_evaluation_write(const sheen_evaluation *e, sheen_json_writer *w)
{
    sheen_json_put_string(w, "highlights", e->highlights_known ? "given" : "found in the photographs");
    sheen_json_open(w, "mean", '{');
    for (int m = 0; m < SHEEN_EVALUATION_METHODS; m++) {
        const sheen_score mean = sheen_evaluation_mean(e, m);
        write_score(w, sheen_evaluation_method_name(m), &mean);
    }
    sheen_json_close(w);
    sheen_json_open(w, "views", '{');
    for (size_t i = 0; i < e->n_views; i++) {
        sheen_json_open(w, e->names[i], '{');
        for (int m = 0; m < SHEEN_EVALUATION_METHODS; m++)
            write_score(w, sheen_evaluation_method_name(m), &e->scores[i][m]);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}
