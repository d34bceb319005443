// SPDX-License-Identifier: Apache-2.0
// cmd_calibrate.c - sheen calibrate: the camera's lens from pictures of the board.
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "base/image_file.h"
#include "calib/calibrate_page.h"
#include "calib/calibrate_session.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/stages.h"

typedef struct calibrate_args {
    const char *board, *output, *report;
    double max_rms_px; // NaN: no limit
    sheen_calibrate_options o;
} calibrate_args;

static sheen_status parse(sheen_cli *cli, calibrate_args *a, sheen_err *err)
{
    *a = (calibrate_args){.max_rms_px = (double)NAN};
    const sheen_option options[] = {
        {"board", 0, SHEEN_OPTION_TEXT, &a->board, "FILE",
         "board.json; with picture files, which have no session", 0, 0},
        {"output", 'o', SHEEN_OPTION_TEXT, &a->output, "FILE",
         "the camera as a .cameramodel (default with picture\nfiles: camera.cameramodel)", 0, 0},
        {"model", 0, SHEEN_OPTION_TEXT, &a->o.lensmodel, "NAME",
         "opencv4, opencv5, opencv8 (default), cahvor, splined, or\nauto: what predicts frames best that it "
         "was not made from",
         0, 0},
        {"report", 0, SHEEN_OPTION_TEXT, &a->report, "FILE.html",
         "figures, plots and what to do next, on one page", 0, 0},
        {"max-rms-px", 0, SHEEN_OPTION_NUMBER, &a->max_rms_px, "X",
         "exit with 3 where the reprojection error is larger", 0, 1e6},
        {"threads", 0, SHEEN_OPTION_INT, &a->o.n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    return sheen_cli_parse(cli, options, 1, SIZE_MAX, err);
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

// Where the frames' pictures are: a session, or picture files in the order of the calibration's frames.
typedef struct picture_source {
    const sheen_calibration *calibration;
    const char *session_path; // NULL: files
    const char *const *paths;
} picture_source;

static sheen_status read_picture(void *self, size_t i_frame, sheen_raster *out, sheen_err *err)
{
    const picture_source *source = self;
    if (!source->session_path)
        return sheen_raster_load(out, source->paths[i_frame], err);
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
                                 bool in_session, sheen_err *err)
{
    picture_source source = {
        .calibration = c, .session_path = in_session ? cli->args[0] : NULL, .paths = cli->args};
    const sheen_frame_pictures pictures = {.read = read_picture, .self = &source};
    char title[SHEEN_PATH_MAX + 32];
    snprintf(title, sizeof title, "Calibration of %s", in_session ? cli->args[0] : "picture files");
    return sheen_calibration_page(c, &pictures, title, path, err);
}

static sheen_status calibrate_session(sheen_cli *cli, const calibrate_args *a, sheen_calibration *c,
                                      sheen_err *err)
{
    sheen_session s;
    if (cli->n_args > 1)
        return sheen_cli_usage(cli, err, "'%s' is a session: give that alone, or picture files",
                               cli->args[0]);
    if (a->board)
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

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    calibrate_args a;
    sheen_calibration c = {0};
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    a.o.progress = sheen_cli_progress(cli);
    const bool in_session = sheen_dir_exists(cli->args[0]);
    if (in_session)
        st = calibrate_session(cli, &a, &c, err);
    else if (!sheen_file_exists(cli->args[0]))
        st = sheen_fail(err, SHEEN_EIO, "there is no session and no picture file '%s'", cli->args[0]);
    else if (!a.board)
        st = sheen_cli_usage(cli, err, "which board do the pictures show? Give --board FILE");
    else
        st = sheen_calibrate_files(&c, cli->args, cli->n_args, a.board, &a.o, err);
    if (st)
        return st;
    const char *output = a.output ? a.output : in_session ? NULL : "camera.cameramodel";
    if (output)
        st = sheen_calibration_save_camera(&c, output, err);
    if (!st && a.report)
        st = write_report(cli, a.report, &c, in_session, err);
    sheen_cli_clear_bar(cli);
    if (!st)
        sheen_cli_say_calibration(cli, &c);
    if (!st && c.rms_px > a.max_rms_px) {
        sheen_cli_warn(cli, "the reprojection error of %.3f px is above the limit of %g px", c.rms_px,
                       a.max_rms_px);
        cli->limit_missed = true;
    }
    sheen_calibration_release(&c);
    return st;
}

const sheen_command sheen_cmd_calibrate = {
    .name = "calibrate",
    .synopsis = "SESSION | FILE... --board FILE [options]",
    .summary = "the camera's lens from pictures of the board",
    .about =
        "From a session's calibration frames (its input frames where it has none) the camera goes into the\n"
        "session; from picture files into a .cameramodel, which mrcal's tools open. The report in the\n"
        "session's calibration.json holds the same figures for each frame.\n",
    .example = "  sheen import penguin.session board/*.jpg --role calibration --board board.json\n"
               "  sheen calibrate penguin.session --max-rms-px 0.3\n",
    .run = run,
};
