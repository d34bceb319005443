// SPDX-License-Identifier: Apache-2.0
// cmd_export.c - sheen export: a session's model in a form for others; the file's name says which.
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/export.h"
#include "render/stand_still.h"

typedef struct target {
    const char *ending; // of the output's name
    sheen_status (*make)(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                         const sheen_cli_view *v, sheen_err *err);
} target;

static const target targets[] = {
    {"html", sheen_export_page}, {"htm", sheen_export_page}, {"glb", sheen_export_gltf},
    {"obj", sheen_export_obj},   {"ply", sheen_export_ply},  {"json", sheen_export_transforms},
};

static const target *target_of(const char *output)
{
    static const target colmap = {"", sheen_export_colmap};
    const char *ending = sheen_path_extension(output), *base = sheen_path_base(output);
    if (!*base || !strcmp(base, "colmap"))
        return &colmap;
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++)
        if (strcasecmp(ending, targets[i].ending) == 0)
            return &targets[i];
    return NULL;
}

static sheen_status parse(sheen_cli *cli, sheen_export_args *a, sheen_err *err)
{
    *a = (sheen_export_args){.max_loss_db = 0.3, .max_size_kb = 1000, .quantizer = -1};
    const sheen_option options[] = {
        {"output", 'o', SHEEN_OPTION_TEXT, &a->output, "FILE", "what is made; its ending says in which form",
         0, 0},
        {"title", 0, SHEEN_OPTION_TEXT, &a->title, "TEXT", "of a page (default: the session's name)", 0, 0},
        {"max-size", 0, SHEEN_OPTION_NUMBER, &a->max_size_kb, "KB",
         "a page's texture is as fine as fits (default: 1000)", 200, 1e6},
        {"texels", 0, SHEEN_OPTION_INT, &a->texels_per_edge, "N",
         "a page's texels a triangle's edge (default: all)", SHEEN_TEXTURE_MIN_EDGE, SHEEN_TEXTURE_MAX_EDGE},
        {"quantizer", 0, SHEEN_OPTION_INT, &a->quantizer, "N",
         "of a page's texture, 0 (finest) to 63, whatever the\nsize becomes", 0, 63},
        {"photographs", 0, SHEEN_OPTION_INT, &a->n_photographs, "N",
         "a page: put N photographs into it, to compare with", 0, 64},
        {"lights", 0, SHEEN_OPTION_INT, &a->n_lights, "N",
         "glTF: put the N strongest lights into the file, too", 0, 16},
        {"max-loss", 0, SHEEN_OPTION_NUMBER, &a->max_loss_db, "DB",
         "exit with 3 where packing loses more on the\nphotographs (default: 0.3)", 0.001, 20},
        {"threads", 0, SHEEN_OPTION_INT, &a->n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    const sheen_status s = sheen_cli_parse(cli, options, 1, 1, err);
    if (s || cli->wants_help)
        return s;
    if (!a->output)
        return sheen_cli_usage(cli, err, "say where it goes: -o FILE.html");
    return SHEEN_OK;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    sheen_export_args a;
    sheen_session s;
    sheen_cli_view v;
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    const target *made = target_of(a.output);
    if (!made)
        return sheen_cli_usage(
            cli, err, "'%.100s' should end in .html, .glb, .obj, .ply or .json, or be a folder colmap/",
            a.output);
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_cli_view_open(&v, &s, err);
    if (!st) {
        if (made->make != sheen_export_page) // no format of others has light on the diffuse part
            st = sheen_model_stand_still(&v.model, 0, err);
        if (!st)
            st = made->make(cli, &a, &s, &v, err);
        sheen_cli_view_close(&v);
    }
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_export = {
    .name = "export",
    .synopsis = "SESSION -o FILE [options]",
    .summary = "the model for others: a web page, glTF, OBJ, PLY, COLMAP",
    .about = "Wants a fitted model in the session. The ending of FILE says in which form it is written:\n"
             "  .html    a page that holds mesh, texture, lights and viewer, works from a disk or a mail "
             "attachment,\n"
             "           and asks no server for anything; what its packing loses is measured and said\n"
             "  .glb     glTF 2.0, with a panorama of the light and a reference picture beside it\n"
             "  .obj     the surface without highlights, with .mtl and .png beside it\n"
             "  .ply     the mesh with a colour a vertex\n"
             "  .json    transforms.json, with the photographs in images/ beside it\n"
             "  colmap/  a COLMAP text model: sparse/0 and images/\n",
    .example = "  sheen export penguin.session -o penguin.html\n"
               "  sheen export penguin.session -o penguin.glb\n",
    .run = run,
};
