// SPDX-License-Identifier: Apache-2.0
// cmd_import.c - sheen import: files that were made elsewhere into a session.
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "capture/import.h"
#include "cli/cli.h"

#include "cli/commands.h"

typedef struct import_args {
    sheen_import_options o;
    const char *transfer, *moving, *role;
} import_args;

static sheen_status parse(sheen_cli *cli, import_args *a, sheen_err *err)
{
    const sheen_option options[] = {
        {"role", 0, SHEEN_OPTION_TEXT, &a->role, "ROLE",
         "what the pictures are for: input (fitted; the default),\ncalibration (of the board alone), test "
         "(held out),\nbackground (without the object; docs/turntable.md)",
         0, 0},
        {"transfer", 0, SHEEN_OPTION_TEXT, &a->transfer, "CURVE",
         "how their numbers stand for light: srgb (default),\nlinear (default for floats), rec709, gamma22",
         0, 0},
        {"camera", 0, SHEEN_OPTION_TEXT, &a->o.camera, "FILE",
         "lens: .cameramodel, OpenCV or ROS yaml, COLMAP\ncameras.txt, transforms.json", 0, 0},
        {"poses", 0, SHEEN_OPTION_TEXT, &a->o.poses, "FILE",
         "poses: transforms.json, a COLMAP text model's folder,\nposes.json; matched by picture name", 0, 0},
        {"mesh", 0, SHEEN_OPTION_TEXT, &a->o.mesh, "FILE", "the object: .ply, .obj, .glb; metres", 0, 0},
        {"masks", 0, SHEEN_OPTION_TEXT, &a->o.masks, "DIR",
         "<picture name>.png for each picture, white: object", 0, 0},
        {"highlights", 0, SHEEN_OPTION_TEXT, &a->o.highlights, "DIR",
         "the same for pixels that are known to be highlights;\nused to score test pictures", 0, 0},
        {"board", 0, SHEEN_OPTION_TEXT, &a->o.board, "FILE",
         "board.json of the board that the object stands on", 0, 0},
        {"calibration-board", 0, SHEEN_OPTION_TEXT, &a->o.calibration_board, "FILE",
         "of the board in the calibration pictures, where it is\nanother one", 0, 0},
        {"moving", 0, SHEEN_OPTION_TEXT, &a->moving, "WHAT",
         "what moved between the pictures: camera or object", 0, 0},
        {0},
    };
    sheen_status s = sheen_cli_parse(cli, options, 1, SIZE_MAX, err);
    if (s || cli->wants_help)
        return s;
    if (a->role)
        s = sheen_role_from_name(&a->o.role, a->role, err);
    if (!s && a->transfer)
        s = sheen_transfer_from_name(&a->o.transfer, a->transfer, err);
    if (!s && a->moving)
        s = sheen_moving_from_name(&a->o.moving, a->moving, err);
    a->o.set_transfer = a->transfer != NULL;
    a->o.set_moving = a->moving != NULL;
    a->o.images = cli->args + 1;
    a->o.n_images = cli->n_args - 1;
    if (s)
        return sheen_cli_option_status(cli, s);
    if (!a->o.n_images && !a->o.camera && !a->o.poses && !a->o.mesh && !a->o.masks && !a->o.highlights &&
        !a->o.board && !a->o.calibration_board && !a->moving)
        return sheen_cli_usage(cli, err, "nothing to import was named");
    return SHEEN_OK;
}

static void report(sheen_cli *cli, const import_args *a, const sheen_session *s, const sheen_import_report *r)
{
    if (a->o.n_images)
        sheen_cli_say(cli, "%zu new %s frame%s%s", r->n_frames, sheen_role_name(a->o.role),
                      sheen_cli_plural(r->n_frames), r->n_present ? ", the others were there already" : "");
    if (a->o.camera || r->camera_from_poses)
        sheen_cli_say(cli, "camera taken from '%s'", a->o.camera ? a->o.camera : a->o.poses);
    if (a->o.poses)
        sheen_cli_say(cli, "poses: %zu frames have one, %zu have none", r->n_poses, r->n_unposed);
    if (a->o.masks)
        sheen_cli_say(cli, "%zu mask%s taken", r->n_masks, sheen_cli_plural(r->n_masks));
    if (a->o.highlights)
        sheen_cli_say(cli, "%zu mask%s of highlights taken", r->n_highlights,
                      sheen_cli_plural(r->n_highlights));
    if (a->o.mesh)
        sheen_cli_say(cli, "mesh taken from '%s'", a->o.mesh);
    const size_t n_background = sheen_session_count_role(s, SHEEN_ROLE_BACKGROUND);
    char background[40] = "";
    if (n_background)
        snprintf(background, sizeof background, ", %zu background", n_background);
    sheen_cli_say(cli, "'%s' has %zu input, %zu calibration, %zu test%s frames", s->path,
                  sheen_session_count_role(s, SHEEN_ROLE_INPUT),
                  sheen_session_count_role(s, SHEEN_ROLE_CALIBRATION),
                  sheen_session_count_role(s, SHEEN_ROLE_TEST), background);
    sheen_json_put_string(&cli->out, "session", s->path);
    sheen_json_put_int(&cli->out, "new_frames", (long long)r->n_frames);
    sheen_json_put_int(&cli->out, "present_frames", (long long)r->n_present);
    sheen_json_put_int(&cli->out, "masks", (long long)r->n_masks);
    sheen_json_put_int(&cli->out, "highlights", (long long)r->n_highlights);
    sheen_json_put_int(&cli->out, "posed_frames", (long long)r->n_poses);
    sheen_json_put_int(&cli->out, "unposed_frames", (long long)r->n_unposed);
    sheen_json_open(&cli->out, "frames", '{');
    for (int role = 0; role < SHEEN_ROLE_COUNT; role++)
        sheen_json_put_int(&cli->out, sheen_role_name((sheen_role)role),
                           (long long)sheen_session_count_role(s, (sheen_role)role));
    sheen_json_close(&cli->out);
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    import_args a = {0};
    sheen_cli_session s;
    sheen_import_report r;
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    a.o.progress = sheen_cli_progress(cli);
    st = sheen_cli_session_create(&s, cli->args[0], a.o.moving, err);
    if (!st)
        st = sheen_import(&s.session, &a.o, &r, err);
    sheen_cli_clear_bar(cli);
    if (!st)
        report(cli, &a, &s.session, &r);
    sheen_cli_session_close(&s, st != SHEEN_OK);
    return st;
}

const sheen_command sheen_cmd_import = {
    .name = "import",
    .synopsis = "SESSION [FILE...] [options]",
    .summary = "image files, camera, poses, mesh, board into a session",
    .about =
        "Makes the session where there is none. FILE is a PNG, JPEG, TIFF or EXR picture, or a folder of\n"
        "them. Every file is checked first: either all of them enter the session or none does.\n",
    .example = "  sheen import penguin.session photos/*.jpg --board board.json --mesh penguin.ply\n"
               "  sheen import penguin.session checks/*.jpg --role test\n",
    .run = run,
};
