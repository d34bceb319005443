// SPDX-License-Identifier: Apache-2.0
// model_surroundings.c - the members of model.json beyond the paper: shadows, and what is mirrored besides the lights.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"
#include "render/model_private.h"

#define BOARD_FILE "board.exr"

enum { MAX_BOARD_SIDE_PX = 4096 };

static int in_range(const double *x, size_t n, double most)
{
    for (size_t i = 0; i < n; i++)
        if (!(fabs(x[i]) <= most))
            return 0;
    return 1;
}

sheen_status sheen_model_check_surroundings(const sheen_surroundings *e, sheen_status code, sheen_err *err)
{
    if (!e->present)
        return SHEEN_OK;
    if (!(e->f0 >= 0 && e->f0 <= 1))
        return sheen_fail(err, code, "the reflectance 'f0' %g is out of range (0 to 1)", e->f0);
    if (!in_range(&e->ambient_rgb[0][0], 3 * SHEEN_AMBIENT_TERMS, 1e6) || !in_range(e->table_rgb, 3, 1e6))
        return sheen_fail(err, code, "the light of the surroundings is out of range");
    const double place[2] = {e->board_x0_m, e->board_y0_m};
    if (e->board.data && (!in_range(place, 2, 1e6) || !(e->board_pitch_m > 1e-7 && e->board_pitch_m < 1e3)))
        return sheen_fail(err, code, "the place of the board's picture is out of range");
    return SHEEN_OK;
}

void sheen_model_put_surroundings(sheen_json_writer *w, const sheen_model *m)
{
    const sheen_surroundings *e = &m->surroundings;
    sheen_json_put_bool(w, "shadows", m->shadows);
    if (!e->present)
        return;
    sheen_json_open(w, "surroundings", '{');
    sheen_json_put_number(w, "f0", e->f0);
    sheen_json_open(w, "ambient_rgb", '[');
    for (int k = 0; k < SHEEN_AMBIENT_TERMS; k++)
        sheen_json_put_numbers(w, NULL, e->ambient_rgb[k], 3);
    sheen_json_close(w);
    sheen_json_put_numbers(w, "table_rgb", e->table_rgb, 3);
    if (e->board.data) {
        sheen_json_open(w, "board", '{');
        sheen_json_put_string(w, "file", BOARD_FILE);
        sheen_json_put_number(w, "x0_m", e->board_x0_m);
        sheen_json_put_number(w, "y0_m", e->board_y0_m);
        sheen_json_put_number(w, "pitch_m", e->board_pitch_m);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

sheen_status sheen_model_save_board(const sheen_model *m, const char *dir, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (!m->surroundings.present || !m->surroundings.board.data)
        return SHEEN_OK;
    const sheen_status s = sheen_path_join(path, dir, BOARD_FILE, err);
    return s ? s : sheen_exr_write(path, &m->surroundings.board, NULL, true, err);
}

sheen_status sheen_model_get_surroundings(sheen_model *m, const sheen_json *root, sheen_err *err)
{
    sheen_surroundings *e = &m->surroundings;
    const sheen_json *in = sheen_json_get(root, "surroundings"), *board;
    bool shadows = false;
    sheen_status s;
    if (sheen_json_get(root, "shadows") && (s = sheen_json_bool(root, "shadows", &shadows, err)))
        return s;
    m->shadows = shadows;
    if (!in)
        return SHEEN_OK;
    e->present = 1;
    if ((s = sheen_json_number(in, "f0", &e->f0, err)) ||
        (s = sheen_json_numbers(in, "ambient_rgb", &e->ambient_rgb[0][0], 3 * SHEEN_AMBIENT_TERMS, err)) ||
        (s = sheen_json_numbers(in, "table_rgb", e->table_rgb, 3, err)))
        return s;
    if (!(board = sheen_json_get(in, "board")))
        return SHEEN_OK;
    if ((s = sheen_json_number(board, "x0_m", &e->board_x0_m, err)) ||
        (s = sheen_json_number(board, "y0_m", &e->board_y0_m, err)))
        return s;
    return sheen_json_number(board, "pitch_m", &e->board_pitch_m, err);
}

// The board's picture beside model.json, which names it only by its presence.
static sheen_status load_board(sheen_surroundings *e, const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    int width_px, height_px;
    sheen_raster raster = {0};
    sheen_status s = sheen_file_read(&data, &size_bytes, path, (size_t)256 << 20, err);
    if (s)
        return s;
    s = sheen_raster_probe(&width_px, &height_px, data, size_bytes, err);
    if (!s && (width_px > MAX_BOARD_SIDE_PX || height_px > MAX_BOARD_SIDE_PX))
        s = sheen_fail(err, SHEEN_EFORMAT, "a picture of %d x %d px is too large", width_px, height_px);
    if (!s && !(s = sheen_exr_parse(&raster, data, size_bytes, err)))
        s = sheen_image_from_raster(&e->board, &raster, SHEEN_TRANSFER_LINEAR, err);
    sheen_raster_release(&raster);
    free(data);
    return s;
}

sheen_status sheen_model_load_surroundings(sheen_model *m, const char *dir, const sheen_json *root,
                                           sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    if (!sheen_json_get(sheen_json_get(root, "surroundings"), "board"))
        return SHEEN_OK;
    sheen_status s = sheen_path_join(path, dir, BOARD_FILE, err);
    if (s || !(s = load_board(&m->surroundings, path, err)))
        return s ? s : sheen_model_check_surroundings(&m->surroundings, SHEEN_EFORMAT, err);
    return sheen_wrap(err, s, "cannot read the board's picture '%s'", path);
}
