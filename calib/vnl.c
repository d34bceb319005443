// SPDX-License-Identifier: Apache-2.0
// vnl.c - reads and writes tables of board corners.
#include "calib/vnl.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/scan.h"

enum { MAX_FILE_BYTES = 256 << 20, MAX_ROW_BYTES = 256, MAX_SIDE = 1000 };

static const char header[] = "# filename x y level\n";

void sheen_vnl_release(sheen_vnl *vnl)
{
    for (size_t i = 0; i < vnl->n_frames; i++)
        free(vnl->frames[i].corners);
    free(vnl->frames);
    *vnl = (sheen_vnl){0};
}

static const sheen_saddle *saddle_at(const sheen_board_view *view, int row, int col)
{
    for (size_t i = 0; i < view->n_saddles; i++)
        if (view->saddles[i].row == row && view->saddles[i].col == col)
            return &view->saddles[i];
    return NULL;
}

// The rows of one view; returns the number of bytes.
static size_t write_view(char *text, const sheen_board *board, const sheen_board_view *view)
{
    if (!view->n_saddles)
        return (size_t)snprintf(text, MAX_ROW_BYTES, "%s - - -\n", view->file);
    size_t used = 0;
    for (int row = 1; row < board->n_rows; row++)
        for (int col = 1; col < board->n_cols; col++) {
            const sheen_saddle *c = saddle_at(view, row, col);
            const int n = c ? snprintf(text + used, MAX_ROW_BYTES, "%s %.10g %.10g 0\n", view->file,
                                       c->q_px[0], c->q_px[1])
                            : snprintf(text + used, MAX_ROW_BYTES, "%s - - -\n", view->file);
            used += (size_t)n;
        }
    return used;
}

sheen_status sheen_vnl_save(const char *path, const sheen_board *board, const sheen_board_view *views,
                            size_t n, sheen_err *err)
{
    const size_t n_corners = (size_t)(board->n_rows - 1) * (size_t)(board->n_cols - 1);
    const size_t capacity_bytes = sizeof header + n * (n_corners + 1) * MAX_ROW_BYTES;
    char *text = malloc(capacity_bytes);
    if (!text)
        return sheen_fail_memory(err, (double)capacity_bytes, "a table of corners");
    size_t used = sizeof header - 1;
    memcpy(text, header, used);
    for (size_t i = 0; i < n; i++)
        used += write_view(text + used, board, &views[i]);
    const sheen_status s = sheen_file_write(path, text, used, err);
    free(text);
    return s;
}

typedef struct table {
    sheen_vnl *out;
    size_t n_corners, capacity;
    size_t n_rows; // of the frame that is being read
    bool blank;    // that frame's rows so far are all "- - -"
    bool has_header;
} table;

// Checks the frame that has ended.
static sheen_status end_frame(table *t, sheen_err *err)
{
    if (!t->n_rows || !t->out->frames)
        return SHEEN_OK;
    const sheen_vnl_frame *frame = &t->out->frames[t->out->n_frames - 1];
    if (t->n_rows != t->n_corners && !(t->n_rows == 1 && t->blank))
        return sheen_fail(err, SHEEN_EFORMAT,
                          "frame '%.100s' has %zu rows, not one for each of %d x %d corners", frame->file,
                          t->n_rows, t->out->n_cols, t->out->n_rows);
    return SHEEN_OK;
}

static sheen_status begin_frame(table *t, const sheen_word *file, sheen_err *err)
{
    sheen_vnl *out = t->out;
    if (memchr(file->text, 0, file->length))
        return sheen_fail(err, SHEEN_EFORMAT, "not a table of corners: it is not a text");
    if (file->length >= sizeof out->frames->file)
        return sheen_fail(err, SHEEN_EFORMAT, "a file name is longer than %zu bytes",
                          sizeof out->frames->file - 1);
    if (!out->frames || out->n_frames == t->capacity) {
        const size_t capacity = t->capacity ? 2 * t->capacity : 16;
        sheen_vnl_frame *frames = realloc(out->frames, capacity * sizeof *frames);
        if (!frames)
            return sheen_fail_memory(err, (double)(capacity * sizeof *frames), "a table of corners");
        out->frames = frames;
        t->capacity = capacity;
    }
    sheen_vnl_frame *frame = &out->frames[out->n_frames++];
    *frame = (sheen_vnl_frame){0};
    memcpy(frame->file, file->text, file->length);
    t->n_rows = 0;
    t->blank = true;
    return SHEEN_OK;
}

// A corner's numbers; weight 0 for "- - -", level "-" or a negative one.
static sheen_status read_corner(double corner[3], bool *blank, sheen_scan *row, sheen_err *err)
{
    sheen_word x, y, level = {0};
    if (!sheen_scan_word(row, &x) || !sheen_scan_word(row, &y))
        return sheen_fail(err, SHEEN_EFORMAT, "line %zu has fewer columns than 'filename x y'", row->line);
    const bool has_level = sheen_scan_word(row, &level);
    memset(corner, 0, 3 * sizeof *corner);
    *blank = sheen_word_is(&x, "-") && sheen_word_is(&y, "-");
    if (*blank)
        return SHEEN_OK;
    double value = 0;
    if (!sheen_word_number(&x, &corner[0]) || !sheen_word_number(&y, &corner[1]) ||
        (has_level && !sheen_word_is(&level, "-") && !sheen_word_number(&level, &value)))
        return sheen_fail(err, SHEEN_EFORMAT, "line %zu holds something that is not a number", row->line);
    const bool seen = value >= 0 && value < 30 && !(has_level && sheen_word_is(&level, "-"));
    corner[2] = seen ? exp2(-value) : 0;
    return SHEEN_OK;
}

static sheen_status read_row(table *t, sheen_scan *row, sheen_err *err)
{
    sheen_word file;
    if (!sheen_scan_word(row, &file))
        return SHEEN_OK; // a blank line
    sheen_vnl *out = t->out;
    sheen_vnl_frame *frame = out->n_frames ? &out->frames[out->n_frames - 1] : NULL;
    if (!frame || !sheen_word_is(&file, frame->file)) {
        sheen_status s = end_frame(t, err);
        if (!s)
            s = begin_frame(t, &file, err);
        if (s || !out->frames)
            return s;
        frame = &out->frames[out->n_frames - 1];
    }
    if (t->n_rows == t->n_corners)
        return sheen_fail(err, SHEEN_EFORMAT, "line %zu: frame '%.100s' has more rows than %d x %d corners",
                          row->line, frame->file, out->n_cols, out->n_rows);
    double corner[3] = {0};
    bool blank = false;
    const sheen_status s = read_corner(corner, &blank, row, err);
    if (s)
        return s;
    if (!blank && !frame->corners) { // memory comes with the first corner, so that it is bounded by the file
        frame->corners = calloc(t->n_corners, sizeof corner);
        if (!frame->corners)
            return sheen_fail_memory(err, (double)t->n_corners * sizeof corner, "a table of corners");
    }
    if (frame->corners)
        memcpy(frame->corners + 3 * t->n_rows, corner, sizeof corner);
    frame->n_found += corner[2] > 0;
    t->blank = t->blank && blank;
    t->n_rows++;
    return SHEEN_OK;
}

// The legend: the first comment that is not "##" or "#!" names the columns.
static sheen_status read_comment(table *t, sheen_scan *line, sheen_err *err)
{
    if (t->has_header || line->end - line->at < 2 || line->at[1] == '#' || line->at[1] == '!')
        return SHEEN_OK;
    line->at++;
    static const char *const wanted[] = {"filename", "x", "y"};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        sheen_word word;
        if (!sheen_scan_word(line, &word) || !sheen_word_is(&word, wanted[i]))
            return sheen_fail(err, SHEEN_EFORMAT, "its columns are not 'filename x y level'");
    }
    t->has_header = true;
    return SHEEN_OK;
}

sheen_status sheen_vnl_parse(sheen_vnl *out, const void *data, size_t size_bytes, int n_cols, int n_rows,
                             sheen_err *err)
{
    *out = (sheen_vnl){.n_cols = n_cols, .n_rows = n_rows};
    if (n_cols < 1 || n_rows < 1 || n_cols > MAX_SIDE || n_rows > MAX_SIDE)
        return sheen_fail(err, SHEEN_EARG, "a grid of %d x %d corners is out of range", n_cols, n_rows);
    table t = {.out = out, .n_corners = (size_t)n_cols * (size_t)n_rows};
    sheen_scan text = {.at = data, .end = (const char *)data + size_bytes}, line;
    sheen_status s = SHEEN_OK;
    while (!s && sheen_scan_line(&text, &line)) {
        if (line.at < line.end && *line.at == '#')
            s = read_comment(&t, &line, err);
        else if (!t.has_header && line.at < line.end)
            s = sheen_fail(err, SHEEN_EFORMAT, "not a table of corners: no line '# filename x y level'");
        else
            s = read_row(&t, &line, err);
    }
    if (!s)
        s = end_frame(&t, err);
    if (!s && !t.has_header)
        s = sheen_fail(err, SHEEN_EFORMAT, "not a table of corners: no line '# filename x y level'");
    if (s)
        sheen_vnl_release(out);
    return s;
}

sheen_status sheen_vnl_load(sheen_vnl *out, const char *path, int n_cols, int n_rows, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    *out = (sheen_vnl){0};
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_FILE_BYTES, err);
    if (s)
        return s;
    s = sheen_vnl_parse(out, data, size_bytes, n_cols, n_rows, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}
