// SPDX-License-Identifier: Apache-2.0
// cmd_register.c - sheen register: a mesh into the session, at a known place on the board.
#include <math.h>
#include <stdlib.h>

#include "capture/import.h"
#include "cli/cli.h"
#include "cli/commands.h"

// Six numbers with commas between them.
static bool read_rt(double rt[6], const char *text)
{
    for (int i = 0; i < 6; i++) {
        char *end;
        rt[i] = strtod(text, &end);
        if (end == text || !isfinite(rt[i]) || *end != (i < 5 ? ',' : 0))
            return false;
        text = end + 1;
    }
    return true;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    const char *rt = NULL;
    double rt_board_obj[6] = {0};
    const sheen_option options[] = {
        {"rt", 0, SHEEN_OPTION_TEXT, &rt, "R,R,R,T,T,T",
         "rt_board_obj: Rodrigues rotation (radians), then\ntranslation (metres), from the mesh's frame to "
         "the\nboard's "
         "(default: the two are the same)",
         0, 0},
        {0},
    };
    sheen_import_report report;
    sheen_session s;
    sheen_status st = sheen_cli_parse(cli, options, 2, 2, err);
    if (st || cli->wants_help)
        return st;
    if (rt && !read_rt(rt_board_obj, rt))
        return sheen_cli_usage(cli, err, "'--rt' wants six numbers such as 0,0,1.57,0.01,0,0, not '%.60s'",
                               rt);
    const sheen_import_options o = {
        .mesh = cli->args[1], .rt_board_obj = rt_board_obj, .progress = sheen_cli_progress(cli)};
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_import(&s, &o, &report, err);
    if (!st) {
        sheen_cli_say(cli, "'%s' has the mesh '%s'", s.path, cli->args[1]);
        sheen_json_put_string(&cli->out, "mesh", sheen_session_mesh_file(&s));
        sheen_json_put_numbers(&cli->out, "rt_board_obj", rt_board_obj, 6);
    }
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_register = {
    .name = "register",
    .synopsis = "SESSION MESH [--rt R,R,R,T,T,T]",
    .summary = "a mesh into the session, at a known place on the board",
    .about = "Replaces the session's mesh and says where it stands.\n",
    .example = "  sheen register penguin.session penguin.ply --rt 0,0,1.5708,0.02,0,0\n",
    .run = run,
};
