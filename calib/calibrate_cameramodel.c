// SPDX-License-Identifier: Apache-2.0
// calibrate_cameramodel.c - .cameramodel with everything that the camera was made from.
//
// mrcal's tools show uncertainty, residuals and geometry of a model that carries the arguments of the solve at its
// optimum ("optimization_inputs"): an .npz, base 85, as a Python bytes literal. Names and shapes are those of
// mrcal.optimize() of mrcal 2.2.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "calib/calibrate_seed.h"
#include "calib/calibrate_session.h"
#include "calib/npz.h"

// What the frames that were used say, in mrcal's arrays.
typedef struct arrays {
    size_t n_frames;
    double *rt_ref_frame, *observations; // [n][6], [n][rows][cols][3]
    int32_t *indices;                    // [n][3]: frame, camera, extrinsics (-1: the reference)
    const char **names;
} arrays;

static void arrays_release(arrays *a)
{
    free(a->rt_ref_frame);
    free(a->observations);
    free(a->indices);
    free(a->names);
}

static sheen_status arrays_fill(arrays *a, const sheen_calibration *c, sheen_err *err)
{
    const size_t n_cols = (size_t)c->board_cols - 1, n_rows = (size_t)c->board_rows - 1;
    const size_t n = (size_t)c->n_used, n_numbers = 3 * n * n_cols * n_rows;
    int *place = malloc((c->n_frames + 1) * sizeof *place); // of a frame among those used
    a->rt_ref_frame = calloc(6 * n + 1, sizeof *a->rt_ref_frame);
    a->observations = calloc(n_numbers + 1, sizeof *a->observations);
    a->indices = calloc(3 * n + 1, sizeof *a->indices);
    a->names = calloc(n + 1, sizeof *a->names);
    if (!place || !a->rt_ref_frame || !a->observations || !a->indices || !a->names) {
        free(place);
        return sheen_fail_memory(err, (double)n_numbers * sizeof(double), "a camera's file");
    }
    const sheen_board grid = {.n_cols = c->board_cols, .n_rows = c->board_rows, .square_m = c->square_m};
    double rt_board_grid[6];
    sheen_rt_board_grid(rt_board_grid, &grid);
    for (size_t i = 0; i < c->n_frames; i++) {
        place[i] = (int)a->n_frames;
        if (!c->frames[i].used)
            continue;
        sheen_rt_compose(a->rt_ref_frame + 6 * a->n_frames, c->frames[i].rt_cam_board, rt_board_grid);
        a->indices[3 * a->n_frames] = (int32_t)a->n_frames;
        a->indices[3 * a->n_frames + 2] = -1;
        a->names[a->n_frames++] = c->frames[i].name;
    }
    for (size_t i = 0; i < n_numbers; i++)
        a->observations[i] = -1; // not seen
    for (int i = 0; i < c->n_corners; i++) {
        const sheen_calibration_corner *corner = &c->corners[i];
        double *to = a->observations +
                     3 * (((size_t)place[corner->i_frame] * n_rows + (size_t)corner->row - 1) * n_cols +
                          (size_t)corner->col - 1);
        memcpy(to, corner->q_px, sizeof corner->q_px);
        to[2] = corner->outlier ? -1 : 1;
    }
    free(place);
    return SHEEN_OK;
}

static void pack(sheen_npz *z, const sheen_calibration *c, const arrays *a)
{
    const size_t n = a->n_frames, n_cols = (size_t)c->board_cols - 1, n_rows = (size_t)c->board_rows - 1;
    const bool splined = strstr(c->camera.lensmodel, "SPLINED") != NULL;
    const double warp_grid_m[2] = {-c->warp_m[0], -c->warp_m[1]}; // mrcal's z goes into the paper
    const int32_t size_px[2] = {c->camera.width_px, c->camera.height_px};
    sheen_npz_numbers(z, "intrinsics", c->camera.intrinsics, 2,
                      (const size_t[]){1, (size_t)c->camera.n_intrinsics});
    sheen_npz_text(z, "extrinsics_rt_fromref", "");
    sheen_npz_numbers(z, "frames_rt_toref", a->rt_ref_frame, 2, (const size_t[]){n, 6});
    sheen_npz_text(z, "points", "");
    sheen_npz_numbers(z, "observations_board", a->observations, 4, (const size_t[]){n, n_rows, n_cols, 3});
    sheen_npz_integers(z, "indices_frame_camintrinsics_camextrinsics", a->indices, 2, (const size_t[]){n, 3});
    sheen_npz_text(z, "observations_point", "");
    sheen_npz_text(z, "indices_point_camintrinsics_camextrinsics", "");
    sheen_npz_text(z, "lensmodel", c->camera.lensmodel);
    sheen_npz_integers(z, "imagersizes", size_px, 2, (const size_t[]){1, 2});
    sheen_npz_numbers(z, "calobject_warp", warp_grid_m, 1, (const size_t[]){2});
    sheen_npz_numbers(z, "calibration_object_spacing", &c->square_m, 0, NULL);
    sheen_npz_bool(z, "do_optimize_intrinsics_core", !splined);
    sheen_npz_bool(z, "do_optimize_intrinsics_distortions", true);
    sheen_npz_bool(z, "do_optimize_extrinsics", true); // there are none; mrcal wants it for uncertainty
    sheen_npz_bool(z, "do_optimize_frames", true);
    sheen_npz_bool(z, "do_optimize_calobject_warp", true);
    sheen_npz_bool(z, "do_apply_outlier_rejection", false);
    sheen_npz_bool(z, "do_apply_regularization", true);
    sheen_npz_bool(z, "verbose", false);
    sheen_npz_texts(z, "imagepaths", a->names, n);
}

sheen_status sheen_calibration_save_camera(const sheen_calibration *c, const char *path, sheen_err *err)
{
    arrays a = {0};
    sheen_npz z = {0};
    char *inputs = NULL;
    sheen_status s = arrays_fill(&a, c, err);
    if (!s) {
        pack(&z, c, &a);
        const sheen_bytes *npz = sheen_npz_finish(&z);
        inputs = npz ? sheen_base85(npz->data, npz->size_bytes) : NULL;
        if (!inputs)
            s = sheen_fail_memory(err, (double)z.file.size_bytes, "a camera's file");
    }
    const sheen_camera_extras extras = {.region_px = c->region_px[0],
                                        .n_region = (size_t)c->n_region,
                                        .note = c->verdict,
                                        .optimization_inputs = inputs};
    if (!s)
        s = sheen_camera_save_with(&c->camera, &extras, path, err);
    free(inputs);
    sheen_npz_release(&z);
    arrays_release(&a);
    return s;
}
