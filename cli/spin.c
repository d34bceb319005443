// SPDX-License-Identifier: Apache-2.0
// spin.c - stills once about the object, as shops show them: numbered files, an index, a page that turns them.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "cli/picture.h"

static const char page_head[] =
    "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>\n"
    "<title>360 degrees</title>\n"
    "<style>body{margin:0;display:grid;place-items:center;height:100vh}img{max-width:100vw;max-height:100vh;"
    "touch-action:none;cursor:grab}</style>\n"
    "<img id=view tabindex=0 alt='the object; drag, or use the arrow keys, to turn it' draggable=false>\n"
    "<script>\n";
static const char page_tail[] =
    "const view = document.getElementById('view'), pictures = files.map(name => {\n"
    "    const picture = new Image();\n"
    "    picture.src = name;\n"
    "    return picture;\n"
    "});\n"
    "let at = 0;\n"
    "function turn(steps) {\n"
    "    at = (at + steps % files.length + files.length) % files.length;\n"
    "    view.src = pictures[Math.round(at) % files.length].src;\n"
    "}\n"
    "view.onpointerdown = event => view.setPointerCapture(event.pointerId);\n"
    "view.onpointermove = event => {\n"
    "    if (event.buttons) turn(-event.movementX / view.width * files.length / 2);\n"
    "};\n"
    "onkeydown = event => turn(event.key === 'ArrowLeft' ? -1 : event.key === 'ArrowRight' ? 1 : 0);\n"
    "turn(0);\n"
    "</script>\n";

static void still_name(char name[32], const sheen_cli_spin *spin, int i)
{
    snprintf(name, 32, "%03d.%s", i, spin->format);
}

static sheen_status save_index(const char *dir, const sheen_cli_spin *spin, const sheen_camera *cam,
                               sheen_err *err)
{
    char path[SHEEN_PATH_MAX], name[32];
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-spin/1");
    sheen_json_put_int(&w, "width_px", cam->width_px);
    sheen_json_put_int(&w, "height_px", cam->height_px);
    sheen_json_put_number(&w, "elevation_deg", spin->elevation_deg);
    sheen_json_open(&w, "frames", '[');
    for (int i = 0; i < spin->count; i++) {
        still_name(name, spin, i);
        sheen_json_open(&w, NULL, '{');
        sheen_json_put_string(&w, "file", name);
        sheen_json_put_number(&w, "azimuth_deg", 360.0 * i / spin->count);
        sheen_json_close(&w);
    }
    sheen_json_close(&w);
    sheen_json_close(&w);
    sheen_status st = sheen_path_join(path, dir, "index.json", err);
    if (!st)
        return sheen_json_save(&w, path, err);
    sheen_json_writer_release(&w);
    return st;
}

static sheen_status save_page(const char *dir, const sheen_cli_spin *spin, sheen_err *err)
{
    char path[SHEEN_PATH_MAX], name[32];
    const size_t room = sizeof page_head + sizeof page_tail + 64 + 40 * (size_t)spin->count;
    char *text = malloc(room);
    if (!text)
        return sheen_fail_memory(err, (double)room, "a page");
    int n = snprintf(text, room, "%sconst files = [", page_head);
    for (int i = 0; i < spin->count; i++) {
        still_name(name, spin, i);
        n += snprintf(text + n, room - (size_t)n, "%s'%s'", i ? "," : "", name);
    }
    n += snprintf(text + n, room - (size_t)n, "];\n%s", page_tail);
    sheen_status st = sheen_path_join(path, dir, "index.html", err);
    if (!st)
        st = sheen_file_write(path, text, (size_t)n, err);
    free(text);
    return st;
}

sheen_status sheen_cli_spin_save(const sheen_cli_view *v, const char *dir, const sheen_cli_spin *spin,
                                 const sheen_progress *progress, sheen_err *err)
{
    char path[SHEEN_PATH_MAX], name[32];
    sheen_camera cam;
    sheen_status st = sheen_cli_view_pinhole(&cam, v, spin->size_px, err);
    if (!st)
        st = sheen_dir_make(dir, err);
    for (int i = 0; !st && i < spin->count; i++) {
        const double look[3] = {360.0 * i / spin->count, spin->elevation_deg, spin->distance_m};
        double rt_cam_obj[6];
        still_name(name, spin, i);
        st = sheen_progress_step(progress, "stills", i, spin->count, err);
        if (!st)
            st = sheen_path_join(path, dir, name, err);
        if (!st)
            st = sheen_cli_view_pose(rt_cam_obj, v, &cam, look, err);
        if (!st)
            st = sheen_cli_picture_save(&spin->picture, v, &cam, rt_cam_obj, path, err);
    }
    if (!st)
        st = save_index(dir, spin, &cam, err);
    if (!st && !strcmp(spin->format, "png"))
        st = save_page(dir, spin, err);
    return st ? st : sheen_progress_step(progress, "stills", spin->count, spin->count, err);
}
