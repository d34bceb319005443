// SPDX-License-Identifier: Apache-2.0
// cmd_calibrate.c - sheen calibrate: the camera's lens from pictures of the board.
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/camera_export.h"
#include "base/file.h"
#include "base/image_file.h"
#include "calib/calibrate_page.h"
#include "calib/calibrate_session.h"
#include "calib/lens_model.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/live.h"
#include "cli/pictures.h"
#include "cli/stages.h"

typedef struct calibrate_args {
    const char *board, *output, *report;
    double max_rms_px; // NaN: no limit
    bool live;
    int size_px[2]; // 0 x 0: not given
    sheen_live_options live_options;
    sheen_calibrate_options o;
} calibrate_args;

// What would only fail after the work is done.
static sheen_status check_names(const calibrate_args *a, sheen_err *err)
{
    const sheen_lens_model *lens;
    sheen_camera_format format;
    const bool automatic = a->o.lensmodel && !strcmp(a->o.lensmodel, "auto");
    const sheen_status s = automatic ? SHEEN_OK : sheen_lens_model_find(&lens, a->o.lensmodel, err);
    const bool ours = !a->output || !strcasecmp(sheen_path_extension(a->output), "cameramodel");
    return s || ours ? s : sheen_camera_format_of(&format, a->output, err);
}

static sheen_status parse(sheen_cli *cli, calibrate_args *a, sheen_err *err)
{
    *a = (calibrate_args){.max_rms_px = (double)NAN, .live_options = {.accuracy_px = 0.1, .max_frames = 60}};
    const sheen_option options[] = {
        {"board", 0, SHEEN_OPTION_TEXT, &a->board, "FILE",
         "board.json; with picture files, which have no session", 0, 0},
        {"output", 'o', SHEEN_OPTION_TEXT, &a->output, "FILE",
         "the camera, by its ending: .cameramodel (mrcal; the default\nwith picture files), .opencv.yaml, "
         ".ros.yaml, .kalibr.yaml,\n.colmap.txt",
         0, 0},
        {"model", 0, SHEEN_OPTION_TEXT, &a->o.lensmodel, "NAME",
         "opencv4, opencv5, opencv8 (default), cahvor, splined, or\nauto: what predicts frames best that it "
         "was not made from",
         0, 0},
        {"report", 0, SHEEN_OPTION_TEXT, &a->report, "FILE.html",
         "figures, plots and what to do next, on one page", 0, 0},
        {"max-rms-px", 0, SHEEN_OPTION_NUMBER, &a->max_rms_px, "X",
         "exit with 3 where the reprojection error is larger", 0, 1e6},
        {"size", 0, SHEEN_OPTION_SIZE, a->size_px, "WIDTHxHEIGHT",
         "of the pictures, with a table of corners (.vnl)", 16, SHEEN_IMAGE_MAX_SIDE_PX},
        {"live", 0, SHEEN_OPTION_FLAG, &a->live, NULL,
         "from a camera: takes a frame whenever the board is still\nand sharp, and says where to hold it "
         "next",
         0, 0},
        {"device", 0, SHEEN_OPTION_TEXT, &a->live_options.device, "URI",
         "with --live: the camera, as for sheen capture", 0, 0},
        {"accuracy-px", 0, SHEEN_OPTION_NUMBER, &a->live_options.accuracy_px, "X",
         "with --live: stop when the lens is certain to this\neverywhere (default: 0.1)", 0.001, 10},
        {"max-frames", 0, SHEEN_OPTION_INT, &a->live_options.max_frames, "N",
         "with --live: stop after so many (default: 60)", 5, 200},
        {"threads", 0, SHEEN_OPTION_INT, &a->o.n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    const sheen_status s = sheen_cli_parse(cli, options, 1, SIZE_MAX, err);
    if (s || cli->wants_help)
        return s;
    if (a->live != (a->live_options.device != NULL))
        return sheen_cli_usage(cli, err, "--live and --device URI go together");
    if (a->live && cli->n_args > 1)
        return sheen_cli_usage(cli, err, "--live wants one session");
    return sheen_cli_option_status(cli, check_names(a, err));
}

void sheen_cli_say_calibration(sheen_cli *cli, const sheen_calibration *c)
{
    sheen_cli_say(cli, "%s, %d x %d px, from %d of %zu frames, %d corners (%d outliers)", c->camera.lensmodel,
                  c->camera.width_px, c->camera.height_px, c->n_used, c->n_frames, c->n_corners,
                  c->n_outliers);
    for (size_t i = 0; i < c->n_frames; i++)
        if (!c->frames[i].used)
            sheen_cli_say(cli, "  not used: %s: %s", c->frames[i].name, c->frames[i].reason);
    sheen_cli_say(
        cli, "reprojection error %.3f px rms an axis (worst frame %s: %.3f), corners in %.0f %% of the image",
        c->rms_px, c->frames[c->i_worst].name, c->frames[c->i_worst].rms_px, 100 * c->coverage);
    for (int i = 0; i < c->n_candidates; i++)
        sheen_cli_say(cli, "  %-8s predicts frames that it was not made from to %.4f px",
                      c->candidates[i].name, c->candidates[i].held_out_px);
    if (c->has_halves)
        sheen_cli_say(
            cli,
            "even and odd frames apart give cameras that differ by %.3f px rms where the board was, "
            "%.2f times what their uncertainty predicts",
            c->halves.moved_rms_px, c->normalised_error);
    sheen_cli_say(cli, "%s", c->verdict);
    sheen_calibration_write(&cli->out, c);
}

static bool is_session(const char *path)
{
    char manifest[SHEEN_PATH_MAX];
    return !sheen_path_join(manifest, path, SHEEN_SESSION_MANIFEST, NULL) && sheen_file_exists(manifest);
}

// A table of corners that another detector found.
static sheen_status calibrate_table(sheen_cli *cli, const calibrate_args *a, sheen_calibration *c,
                                    sheen_err *err)
{
    if (cli->n_args > 1)
        return sheen_cli_usage(cli, err, "'%s' is a table of corners: give that alone", cli->args[0]);
    if (!a->size_px[0])
        return sheen_cli_usage(cli, err, "how large were the pictures? Give --size WIDTHxHEIGHT");
    return sheen_calibrate_table(c, cli->args[0], a->size_px, a->board, &a->o, err);
}

// By its ending: mrcal's format with all that it was made from, or another program's.
static sheen_status write_camera(const sheen_calibration *c, const char *path, sheen_err *err)
{
    sheen_camera_format format;
    if (!strcasecmp(sheen_path_extension(path), "cameramodel"))
        return sheen_calibration_save_camera(c, path, err);
    const sheen_status s = sheen_camera_format_of(&format, path, err);
    return s ? s : sheen_camera_export(&c->camera, format, path, err);
}

static sheen_status calibrate_pictures(sheen_cli *cli, const calibrate_args *a, sheen_calibration *c,
                                       sheen_cli_picture_list *list, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    if (!sheen_file_exists(cli->args[0]) && !sheen_dir_exists(cli->args[0]))
        s = sheen_fail(err, SHEEN_EIO, "there is no session and no picture file '%s'", cli->args[0]);
    else if (!a->board)
        s = sheen_cli_usage(cli, err, "which board do the pictures show? Give --board FILE");
    if (!s && !strcasecmp(sheen_path_extension(cli->args[0]), "vnl"))
        return calibrate_table(cli, a, c, err);
    if (!s)
        s = sheen_cli_pictures(list, cli->args, cli->n_args, err);
    const char **paths = s ? NULL : calloc(list->n + 1, sizeof *paths);
    if (!s && !paths)
        s = sheen_fail_memory(err, (double)list->n * sizeof *paths, "a list of pictures");
    for (size_t i = 0; i < list->n && !s; i++)
        paths[i] = list->paths[i];
    if (!s)
        s = sheen_calibrate_files(c, paths, list->n, a->board, &a->o, err);
    free(paths);
    return s;
}

// Takes the frames, into a session that is made where there is none.
static sheen_status take_live(sheen_cli *cli, const calibrate_args *a, sheen_err *err)
{
    sheen_cli_session s = {0};
    char path[SHEEN_PATH_MAX];
    size_t n_taken = 0;
    sheen_status st = sheen_cli_session_create(&s, cli->args[0], SHEEN_MOVING_CAMERA, err);
    if (!st && a->board) {
        st = sheen_session_path(path, &s.session, SHEEN_SESSION_CALIBRATION_BOARD, err);
        if (!st)
            st = sheen_file_copy(path, a->board, err);
    }
    if (!st)
        st = sheen_cli_live(cli, &s.session, &a->live_options, &n_taken, err);
    sheen_cli_session_close(&s, st != SHEEN_OK);
    return st;
}

// Where the frames' pictures are: a session, or picture files in the order of the calibration's frames.
typedef struct picture_source {
    const sheen_calibration *calibration;
    const char *session_path;
    const sheen_cli_picture_list *list; // NULL: the session
} picture_source;

static sheen_status read_picture(void *self, size_t i_frame, sheen_raster *out, sheen_err *err)
{
    const picture_source *source = self;
    if (source->list)
        return i_frame < source->list->n ? sheen_raster_load(out, source->list->paths[i_frame], err)
                                         : sheen_fail(err, SHEEN_EDATA, "the frame has no picture");
    sheen_session s;
    sheen_status st = sheen_session_open(&s, source->session_path, err);
    if (st)
        return st;
    const sheen_frame_info *frame = sheen_session_find(&s, source->calibration->frames[i_frame].name);
    st = frame ? sheen_session_raster(out, &s, frame, err)
               : sheen_fail(err, SHEEN_EDATA, "the frame is no longer in the session");
    sheen_session_release(&s);
    return st;
}

static sheen_status write_report(const sheen_cli *cli, const char *path, const sheen_calibration *c,
                                 const sheen_cli_picture_list *list, sheen_err *err)
{
    picture_source source = {.calibration = c, .session_path = cli->args[0], .list = list};
    const sheen_frame_pictures pictures = {.read = read_picture, .self = &source};
    char title[SHEEN_PATH_MAX + 32];
    snprintf(title, sizeof title, "Calibration of %s", cli->args[0]);
    return sheen_calibration_page(c, &pictures, title, path, err);
}

static sheen_status calibrate_session(sheen_cli *cli, const calibrate_args *a, sheen_calibration *c,
                                      sheen_err *err)
{
    sheen_session s;
    if (cli->n_args > 1)
        return sheen_cli_usage(cli, err, "'%s' is a session: give that alone, or picture files",
                               cli->args[0]);
    if (a->board && !a->live)
        return sheen_cli_usage(cli, err,
                               "'--board' goes with picture files; a session has its own: sheen import %s "
                               "--board FILE",
                               cli->args[0]);
    sheen_status st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_calibrate_session(c, &s, &a->o, err);
    sheen_session_release(&s);
    return st;
}

// Writes and says what was found.
static sheen_status deliver(sheen_cli *cli, const calibrate_args *a, const sheen_calibration *c,
                            const sheen_cli_picture_list *list, sheen_err *err)
{
    const char *output = a->output ? a->output : list ? "camera.cameramodel" : NULL;
    sheen_status st = output ? write_camera(c, output, err) : SHEEN_OK;
    if (!st && a->report)
        st = write_report(cli, a->report, c, list, err);
    sheen_cli_clear_bar(cli);
    if (st)
        return st;
    sheen_cli_say_calibration(cli, c);
    cli->limit_missed = !c->good; // the limits of the verdict
    if (c->rms_px > a->max_rms_px) {
        sheen_cli_warn(cli, "the reprojection error of %.3f px is above the limit of %g px", c->rms_px,
                       a->max_rms_px);
        cli->limit_missed = true;
    }
    return SHEEN_OK;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    calibrate_args a;
    sheen_calibration c = {0};
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    a.o.progress = sheen_cli_progress(cli);
    if (a.live)
        st = take_live(cli, &a, err);
    sheen_cli_picture_list list = {0};
    const bool in_session = is_session(cli->args[0]);
    if (!st && in_session)
        st = calibrate_session(cli, &a, &c, err);
    else if (!st)
        st = calibrate_pictures(cli, &a, &c, &list, err);
    if (!st)
        st = deliver(cli, &a, &c, in_session ? NULL : &list, err);
    sheen_cli_pictures_release(&list);
    sheen_calibration_release(&c);
    return st;
}
const sheen_command sheen_cmd_calibrate = {
    .name = "calibrate",
    .synopsis = "SESSION | FILE... | FOLDER | CORNERS.vnl [--board FILE] [options]",
    .summary = "the camera's lens from pictures of the board",
    .about =
        "From a session's calibration frames (its input frames where it has none) the camera goes into the\n"
        "session; from picture files into a .cameramodel, which mrcal's tools open. The report in the\n"
        "session's calibration.json holds the same figures for each frame.\n",
    .example = "  sheen import penguin.session board/*.jpg --role calibration --board board.json\n"
               "  sheen calibrate penguin.session --max-rms-px 0.3 --report calibration.html\n"
               "  sheen calibrate camera.session --live --device v4l2:/dev/video0 --board board.json\n",
    .run = run,
};
