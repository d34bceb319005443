// SPDX-License-Identifier: Apache-2.0
// calibrate_report.c - calibration.json: the summary of a calibration as other programs read it.
#include <math.h>

#include "base/json_write.h"
#include "calib/calibrate_session.h"

static void write_frame(sheen_json_writer *w, const sheen_calibration_frame *frame)
{
    sheen_json_open(w, NULL, '{');
    sheen_json_put_string(w, "name", frame->name);
    sheen_json_put_bool(w, "used", frame->used);
    if (!frame->used)
        sheen_json_put_string(w, "reason", frame->reason);
    sheen_json_put_int(w, "corners", frame->n_corners);
    if (frame->used) {
        sheen_json_put_int(w, "outliers", frame->n_outliers);
        sheen_json_put_number(w, "rms_px", frame->rms_px);
        sheen_json_put_numbers(w, "rt_cam_board", frame->rt_cam_board, 6);
    }
    sheen_json_close(w);
}

static void write_difference(sheen_json_writer *w, const char *key, const sheen_camera_difference *d)
{
    sheen_json_open(w, key, '{');
    sheen_json_put_number(w, "raw_rms_px", d->raw_rms_px);
    sheen_json_put_number(w, "raw_max_px", d->raw_max_px);
    sheen_json_put_number(w, "turned_rms_px", d->turned_rms_px);
    sheen_json_put_number(w, "turned_max_px", d->turned_max_px);
    sheen_json_put_number(w, "moved_rms_px", d->moved_rms_px);
    sheen_json_put_number(w, "moved_max_px", d->moved_max_px);
    sheen_json_close(w);
}

static void write_map(sheen_json_writer *w, const sheen_calibration *c)
{
    sheen_json_open(w, "sigma_map_px", '[');
    for (int row = 0; row < SHEEN_SIGMA_ROWS; row++)
        sheen_json_put_numbers(w, NULL, c->sigma_px[row], SHEEN_SIGMA_COLS);
    sheen_json_close(w);
    sheen_json_put_number(w, "valid_share", c->valid_share);
    sheen_json_open(w, "valid_region_px", '[');
    for (int i = 0; i < c->n_region; i++)
        sheen_json_put_numbers(w, NULL, c->region_px[i], 2);
    sheen_json_close(w);
}

static void write_candidates(sheen_json_writer *w, const sheen_calibration *c)
{
    if (!c->n_candidates)
        return;
    sheen_json_open(w, "models_tried", '[');
    for (int i = 0; i < c->n_candidates; i++) {
        sheen_json_open(w, NULL, '{');
        sheen_json_put_string(w, "model", c->candidates[i].name);
        sheen_json_put_number(w, "held_out_px", c->candidates[i].held_out_px);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

static void write_vignetting(sheen_json_writer *w, const sheen_vignetting *v)
{
    sheen_json_open(w, "vignetting", '{');
    sheen_json_put_bool(w, "measured", v->measured);
    if (!v->measured)
        sheen_json_put_string(w, "reason", v->reason);
    else {
        sheen_json_put_int(w, "frames", v->n_frames);
        sheen_json_put_numbers(w, "log_light_by_rho2_rho4", v->k, 2);
        sheen_json_put_number(w, "reach_rho", v->reach);
        sheen_json_put_number(w, "light_at_reach", v->light);
        sheen_json_put_number(w, "sigma", v->sigma);
    }
    sheen_json_close(w);
}

static void write_figures(sheen_json_writer *w, const sheen_calibration *c)
{
    sheen_json_put_string(w, "verdict", c->verdict);
    sheen_json_put_bool(w, "good", c->good);
    sheen_json_put_string(w, "lensmodel", c->camera.lensmodel);
    sheen_json_put_numbers(w, "intrinsics", c->camera.intrinsics, (size_t)c->camera.n_intrinsics);
    sheen_json_put_int(w, "width_px", c->camera.width_px);
    sheen_json_put_int(w, "height_px", c->camera.height_px);
    sheen_json_put_number(w, "rms_px", c->rms_px);
    sheen_json_put_number(w, "noise_px", c->noise_px);
    sheen_json_put_int(w, "frames_used", c->n_used);
    sheen_json_put_int(w, "corners", c->n_corners);
    sheen_json_put_int(w, "outliers", c->n_outliers);
    sheen_json_put_number(w, "outlier_share", c->n_corners ? (double)c->n_outliers / c->n_corners : 0);
    sheen_json_put_string(w, "worst_frame", c->frames[c->i_worst].name);
    sheen_json_put_number(w, "coverage", c->coverage);
    sheen_json_open(w, "coverage_cells", '[');
    for (int row = 0; row < SHEEN_COVERAGE_ROWS; row++) {
        double counts[SHEEN_COVERAGE_COLS];
        for (int col = 0; col < SHEEN_COVERAGE_COLS; col++)
            counts[col] = c->cells[row][col];
        sheen_json_put_numbers(w, NULL, counts, SHEEN_COVERAGE_COLS);
    }
    sheen_json_close(w);
    sheen_json_put_number(w, "pattern", c->pattern);
    sheen_json_put_numbers(w, "board_warp_m", c->warp_m, 2);
    sheen_json_put_number(w, "board_distance_m", c->distance_m);
    sheen_json_put_number(w, "board_tilt_rad", c->tilt_rad);
    sheen_json_put_number(w, "sigma_centre_px", c->sigma_centre_px);
    sheen_json_put_number(w, "sigma_worst_px", c->sigma_worst_px);
    write_map(w, c);
    if (c->has_halves) {
        write_difference(w, "halves", &c->halves);
        sheen_json_put_number(w, "normalised_error", c->normalised_error);
    }
    write_candidates(w, c);
    write_vignetting(w, &c->vignetting);
}

void sheen_calibration_write(sheen_json_writer *w, const sheen_calibration *c)
{
    write_figures(w, c);
    sheen_json_open(w, "frames", '[');
    for (size_t i = 0; i < c->n_frames; i++)
        write_frame(w, &c->frames[i]);
    sheen_json_close(w);
}

sheen_status sheen_calibration_save(const sheen_calibration *c, const sheen_session *s, const char *path,
                                    sheen_err *err)
{
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-calibration/1");
    sheen_calibration_write(&w, c);
    if (s) {
        const char *inputs[3];
        sheen_calibration_inputs(inputs, s);
        const sheen_status st = sheen_stamp_write(&w, s, inputs, err);
        if (st) {
            sheen_json_writer_release(&w);
            return st;
        }
    }
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}
