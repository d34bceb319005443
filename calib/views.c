// SPDX-License-Identifier: Apache-2.0
// views.c - observes many frames in parallel, a few at a time, so that progress and cancelling stay in the
// caller's thread.
#include "calib/views.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/parallel.h"
#include "calib/saddles.h"

enum { FRAMES_PER_THREAD = 2 };

// Decodes frame i; called from several threads at once.
typedef struct reader {
    sheen_status (*read)(const struct reader *self, size_t i, sheen_raster *out, sheen_transfer *transfer,
                         sheen_err *err);
    const sheen_session *session;
    const sheen_frame_info *const *frames;
    const char *const *paths;
    const sheen_views_options *options;
} reader;

static sheen_status read_session(const reader *self, size_t i, sheen_raster *out, sheen_transfer *transfer,
                                 sheen_err *err)
{
    *transfer = self->frames[i]->transfer;
    return sheen_session_raster(out, self->session, self->frames[i], err);
}

static sheen_status read_path(const reader *self, size_t i, sheen_raster *out, sheen_transfer *transfer,
                              sheen_err *err)
{
    *transfer = SHEEN_TRANSFER_SRGB;
    return sheen_raster_load(out, self->paths[i], err);
}

typedef struct batch {
    const reader *reader;
    const sheen_board_set *boards;
    size_t first;
    sheen_board_view *views; // of all frames and boards
    sheen_err *errs;         // of this batch
} batch;

static sheen_status observe(sheen_board_view *views, const reader *r, size_t i, const sheen_board_set *boards,
                            sheen_err *err)
{
    sheen_tag_detector *detector = NULL;
    sheen_raster raster = {0};
    sheen_transfer transfer;
    uint8_t *grey = NULL;
    sheen_status s = r->read(r, i, &raster, &transfer, err);
    if (s)
        goto done;
    const size_t n_pixels = (size_t)raster.width_px * (size_t)raster.height_px;
    grey = malloc(n_pixels);
    if (!grey) {
        s = sheen_fail_memory(err, (double)n_pixels, "a grey picture");
        goto done;
    }
    sheen_raster_grey(grey, &raster, transfer);
    s = sheen_tag_detector_new(&detector, boards->boards[0].family, err);
    if (s)
        goto done;
    s = sheen_boards_observe(views, detector, grey, raster.width_px, raster.height_px, boards, err);
    for (size_t b = 0; b < boards->n_boards && !s; b++) // linear light was coded for the eye
        views[b].transfer = transfer == SHEEN_TRANSFER_LINEAR ? SHEEN_TRANSFER_SRGB : transfer;
    if (!s && r->options->look)
        s = r->options->look(r->options->self, views, grey, err);

done:
    sheen_tag_detector_free(&detector);
    free(grey);
    sheen_raster_release(&raster);
    return s;
}

static void observe_some(void *self, size_t begin, size_t end)
{
    const batch *b = self;
    for (size_t i = begin; i < end; i++)
        b->errs[i].code = observe(&b->views[(b->first + i) * b->boards->n_boards], b->reader, b->first + i,
                                  b->boards, &b->errs[i]);
}

static sheen_status observe_all(sheen_views *out, const reader *r, size_t n, const sheen_board_set *boards,
                                sheen_err *err)
{
    const int n_threads = r->options->n_threads;
    const sheen_progress *progress = r->options->progress;
    *out = (sheen_views){0};
    const size_t per_batch = FRAMES_PER_THREAD * (size_t)(n_threads > 0 ? n_threads : sheen_cpu_count());
    sheen_status s = SHEEN_OK;
    sheen_err *errs = calloc(per_batch, sizeof *errs);
    out->views = calloc(n ? n * boards->n_boards : 1, sizeof *out->views);
    out->n_views = n * boards->n_boards;
    if (!errs || !out->views) {
        free(errs);
        sheen_views_release(out);
        return sheen_fail_memory(err, (double)n * sizeof *out->views, "views of the board");
    }
    for (size_t first = 0; first < n && !s; first += per_batch) {
        const size_t count = n - first < per_batch ? n - first : per_batch;
        s = sheen_progress_step(progress, "board", (int)first, (int)n, err);
        if (s)
            break;
        batch b = {.reader = r, .boards = boards, .first = first, .views = out->views, .errs = errs};
        sheen_parallel_for(count, 1, n_threads, observe_some, &b);
        for (size_t i = 0; i < count && !s; i++)
            if (errs[i].code)
                s = sheen_fail(err, errs[i].code, "%s", errs[i].msg);
    }
    if (!s)
        s = sheen_progress_step(progress, "board", (int)n, (int)n, err);
    free(errs);
    if (s)
        sheen_views_release(out);
    return s;
}

void sheen_views_release(sheen_views *views)
{
    for (size_t i = 0; views->views && i < views->n_views; i++)
        sheen_board_view_release(&views->views[i]);
    free(views->views);
    *views = (sheen_views){0};
}

sheen_status sheen_set_views_of_session(sheen_views *out, const sheen_session *s,
                                        const sheen_frame_info *const *frames, size_t n_frames,
                                        const sheen_board_set *boards, const sheen_views_options *options,
                                        sheen_err *err)
{
    const reader r = {.read = read_session, .session = s, .frames = frames, .options = options};
    const sheen_status status = observe_all(out, &r, n_frames, boards, err);
    for (size_t i = 0; !status && i < out->n_views; i++) {
        const sheen_frame_info *f = frames[i / boards->n_boards];
        snprintf(out->views[i].name, sizeof out->views[i].name, "%s", f->name);
        snprintf(out->views[i].file, sizeof out->views[i].file, "../" SHEEN_SESSION_FRAMES "/%s", f->file);
    }
    return status;
}

sheen_status sheen_views_of_session(sheen_views *out, const sheen_session *s,
                                    const sheen_frame_info *const *frames, size_t n_frames,
                                    const sheen_board *board, int n_threads, const sheen_progress *progress,
                                    sheen_err *err)
{
    sheen_board alone = *board; // a set of one, which is only read
    const sheen_board_set one = {.boards = &alone, .n_boards = 1};
    const sheen_views_options options = {.n_threads = n_threads, .progress = progress};
    return sheen_set_views_of_session(out, s, frames, n_frames, &one, &options, err);
}

// White space and '#' would end a name in a .vnl table.
static void plain_name(char *name)
{
    for (; *name; name++)
        if ((unsigned char)*name <= ' ' || *name == '#' || *name == 127)
            *name = '_';
}

sheen_status sheen_views_of_files(sheen_views *out, const char *const *paths, size_t n_paths,
                                  const sheen_board *board, int n_threads, const sheen_progress *progress,
                                  sheen_err *err)
{
    const sheen_views_options options = {.n_threads = n_threads, .progress = progress};
    const reader r = {.read = read_path, .paths = paths, .options = &options};
    sheen_board alone = *board;
    const sheen_board_set one = {.boards = &alone, .n_boards = 1};
    const sheen_status status = observe_all(out, &r, n_paths, &one, err);
    for (size_t i = 0; i < n_paths && !status; i++) {
        sheen_board_view *view = &out->views[i];
        const char *base = sheen_path_base(paths[i]);
        snprintf(view->file, sizeof view->file, "%.127s", base);
        const char *dot = strrchr(base, '.');
        const int length = dot && dot != base ? (int)(dot - base) : (int)strlen(base);
        snprintf(view->name, sizeof view->name, "%.*s", length < 63 ? length : 63, base);
        plain_name(view->file);
        plain_name(view->name);
    }
    return status;
}

static sheen_status take_rows(sheen_board_view *view, const sheen_vnl_frame *frame, const sheen_board *board,
                              sheen_err *err)
{
    view->saddles = calloc(frame->n_found + 1, sizeof *view->saddles);
    if (!view->saddles)
        return sheen_fail_memory(err, (double)frame->n_found * sizeof *view->saddles, "corners");
    for (size_t i = 0; i < board->n_corners && frame->corners; i++) {
        const double *q = frame->corners + 3 * i;
        if (!(q[2] > 0))
            continue;
        if (!(q[0] > -1 && q[1] > -1 && q[0] < view->width_px && q[1] < view->height_px))
            return sheen_fail(err, SHEEN_EDATA,
                              "frame '%s' has a corner at (%g, %g), beyond its %d x %d px: check --size",
                              view->name, q[0], q[1], view->width_px, view->height_px);
        sheen_saddle *saddle = &view->saddles[view->n_saddles++];
        *saddle = (sheen_saddle){
            .row = board->corners[i].row, .col = board->corners[i].col, .q_px = {q[0], q[1]}};
        memcpy(saddle->p_board, board->corners[i].p_board, sizeof saddle->p_board);
    }
    return SHEEN_OK;
}

sheen_status sheen_views_of_vnl(sheen_views *out, const sheen_vnl *vnl, const int size_px[2],
                                const sheen_board *board, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    *out = (sheen_views){.views = calloc(vnl->n_frames + 1, sizeof *out->views), .n_views = vnl->n_frames};
    if (!out->views)
        return sheen_fail_memory(err, (double)vnl->n_frames * sizeof *out->views, "views of the board");
    for (size_t i = 0; i < vnl->n_frames && !s; i++) {
        sheen_board_view *view = &out->views[i];
        view->width_px = size_px[0];
        view->height_px = size_px[1];
        snprintf(view->file, sizeof view->file, "%.127s", vnl->frames[i].file);
        snprintf(view->name, sizeof view->name, "%.63s", sheen_path_base(vnl->frames[i].file));
        s = take_rows(view, &vnl->frames[i], board, err);
    }
    if (s)
        sheen_views_release(out);
    return s;
}
