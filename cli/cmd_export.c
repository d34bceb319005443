// SPDX-License-Identifier: Apache-2.0
// cmd_export.c - sheen export: the model for people who do not have sheen; so far as one web page.
//
// A page's texture is as fine as its size permits: the most texels a triangle's edge with which the whole file stays
// within the limit. What that loses is measured on the bytes that were written, by drawing them from the
// photographs' viewpoints.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "cli/cli.h"
#include "cli/commands.h"
#include "cli/export_loss.h"
#include "cli/stages.h"
#include "cli/viewer_html.h"
#include "render/page.h"

typedef struct export_args {
    const char *output, *title;
    double max_loss_db, max_size_kb;
    int texels_per_edge, n_threads;
} export_args;

// A finished page, with the parts that it is made of.
typedef struct made_page {
    sheen_page page;
    char *text;
    size_t size_bytes;
    int texels_per_edge;
} made_page;

typedef struct exporting {
    const export_args *args;
    const sheen_progress *progress;
    const sheen_model *model;
    sheen_page_view view;
    char title[256];
    int n_tried;
} exporting;

static sheen_status parse(sheen_cli *cli, export_args *a, sheen_err *err)
{
    *a = (export_args){.max_loss_db = 0.3, .max_size_kb = 1000};
    const sheen_option options[] = {
        {"output", 'o', SHEEN_OPTION_TEXT, &a->output, "FILE", "the page, .html", 0, 0},
        {"title", 0, SHEEN_OPTION_TEXT, &a->title, "TEXT", "of the page (default: the session's name)", 0, 0},
        {"max-size", 0, SHEEN_OPTION_NUMBER, &a->max_size_kb, "KB",
         "the texture is as fine as fits (default: 1000)", 200, 1e6},
        {"texels", 0, SHEEN_OPTION_INT, &a->texels_per_edge, "N",
         "texels a triangle's edge, whatever the size becomes", SHEEN_TEXTURE_MIN_EDGE,
         SHEEN_TEXTURE_MAX_EDGE},
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
    const char *ending = sheen_path_extension(a->output);
    if (strcasecmp(ending, "html") != 0 && strcasecmp(ending, "htm") != 0)
        return sheen_cli_usage(cli, err, "'%.100s' should end in .html", a->output);
    return SHEEN_OK;
}

static void made_page_release(made_page *p)
{
    sheen_page_release(&p->page);
    free(p->text);
    *p = (made_page){.text = NULL};
}

static sheen_status make_page(made_page *out, exporting *e, int texels_per_edge, sheen_err *err)
{
    sheen_model packed = *e->model;
    *out = (made_page){.texels_per_edge = texels_per_edge};
    sheen_status s = sheen_progress_step(e->progress, "sizes tried", e->n_tried++, 0, err);
    if (s)
        return s;
    s = sheen_texture_resample(&packed.texture, &e->model->texture, texels_per_edge, err);
    if (s)
        return s;
    s = sheen_page_pack(&out->page, &packed, &e->view, err);
    sheen_texture_release(&packed.texture);
    if (!s)
        s = sheen_page_html(&out->text, &out->size_bytes, &out->page, sheen_viewer_html, e->title, err);
    if (s)
        made_page_release(out);
    return s;
}

// The finest page within the size, by bisection; the coarsest where none is.
static sheen_status choose(made_page *best, exporting *e, sheen_err *err)
{
    if (e->args->texels_per_edge)
        return make_page(best, e, e->args->texels_per_edge, err);
    const double most_bytes = 1e3 * e->args->max_size_kb;
    int fits = SHEEN_TEXTURE_MIN_EDGE, beyond = e->model->texture.texels_per_edge + 1;
    sheen_status s = make_page(best, e, fits, err);
    while (!s && beyond - fits > 1) {
        made_page next;
        const int middle = (fits + beyond) / 2;
        s = make_page(&next, e, middle, err);
        if (s)
            break;
        if ((double)next.size_bytes <= most_bytes) {
            made_page_release(best);
            *best = next;
            fits = middle;
        } else {
            made_page_release(&next);
            beyond = middle;
        }
    }
    if (s)
        made_page_release(best);
    return s;
}

// Draws what the page's bytes hold, and compares.
static sheen_status measure(sheen_export_loss *loss, const exporting *e, const sheen_session *session,
                            const sheen_page *page, sheen_err *err)
{
    sheen_export_views views;
    sheen_model shown;
    sheen_status s = sheen_export_views_open(&views, session, e->model, e->args->n_threads, e->progress, err);
    if (s)
        return s;
    s = sheen_page_unpack(&shown, NULL, page, err);
    if (!s) {
        s = sheen_export_measure(loss, &views, &shown, err);
        sheen_model_release(&shown);
    }
    sheen_export_views_close(&views);
    return s;
}

static void say(sheen_cli *cli, const export_args *a, const made_page *p, const sheen_export_loss *loss)
{
    const double loss_db = loss->full_db - loss->packed_db;
    sheen_cli_clear_bar(cli);
    sheen_cli_say(cli, "%s: %.0f kB", a->output, (double)p->size_bytes / 1e3);
    sheen_cli_say(cli, "  mesh and lights %.0f kB, texture of %d texels an edge %.0f kB, before base64",
                  (double)p->page.geometry_bytes / 1e3, p->texels_per_edge,
                  (double)p->page.texture_bytes / 1e3);
    sheen_cli_say(cli, "  on the photographs %.2f dB, the model itself %.2f dB: packing %s %.2f dB",
                  loss->packed_db, loss->full_db, loss_db >= 0 ? "lost" : "smoothed noise and gained",
                  fabs(loss_db));
    sheen_cli_say(cli, "  drawings of both agree to %.1f dB", loss->agreement_db);
    sheen_json_put_string(&cli->out, "made", a->output);
    sheen_json_put_int(&cli->out, "size_bytes", (long long)p->size_bytes);
    sheen_json_put_int(&cli->out, "geometry_bytes", (long long)p->page.geometry_bytes);
    sheen_json_put_int(&cli->out, "texture_bytes", (long long)p->page.texture_bytes);
    sheen_json_put_int(&cli->out, "texels_per_edge", p->texels_per_edge);
    sheen_json_put_number(&cli->out, "loss_db", loss_db);
    sheen_json_put_number(&cli->out, "photographs_db", loss->packed_db);
    sheen_json_put_number(&cli->out, "agreement_db", loss->agreement_db);
    if (loss_db > a->max_loss_db) {
        sheen_cli_warn(cli, "packing lost %.2f dB, more than the limit of %g dB", loss_db, a->max_loss_db);
        cli->limit_missed = true;
    }
    if (!a->texels_per_edge && (double)p->size_bytes > 1e3 * a->max_size_kb) {
        sheen_cli_warn(cli, "the page is larger than %g kB; a mesh of fewer triangles helps", a->max_size_kb);
        cli->limit_missed = true;
    }
}

// The given title, or the session's folder without the ending that our examples give it.
static void set_title(char title[256], const export_args *a, const sheen_session *s)
{
    snprintf(title, 256, "%.255s", a->title ? a->title : sheen_path_base(s->path));
    char *ending = a->title ? NULL : strstr(title, ".session");
    if (ending && ending != title)
        *ending = 0;
}

static sheen_status export_page(sheen_cli *cli, const export_args *a, const sheen_session *s,
                                const sheen_cli_view *v, sheen_err *err)
{
    const sheen_progress progress = sheen_cli_progress(cli);
    exporting e = {.args = a, .progress = &progress, .model = &v->model};
    made_page best;
    sheen_export_loss loss;
    if (strcmp(v->model.method, "paper") != 0)
        sheen_cli_warn(cli, "a page shows texture and lights; what the method '%s' adds to them is left out",
                       v->model.method);
    set_title(e.title, a, s);
    e.view.focal_per_width = v->camera.intrinsics[0] / v->camera.width_px;
    memcpy(e.view.rt_board_obj, v->rt_board_obj, sizeof e.view.rt_board_obj);
    sheen_status st = choose(&best, &e, err);
    if (st)
        return st;
    st = measure(&loss, &e, s, &best.page, err);
    if (!st)
        st = sheen_file_write(a->output, best.text, best.size_bytes, err);
    if (!st)
        say(cli, a, &best, &loss);
    made_page_release(&best);
    return st;
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    export_args a;
    sheen_session s;
    sheen_cli_view v;
    sheen_status st = parse(cli, &a, err);
    if (st || cli->wants_help)
        return st;
    if (!sheen_viewer_html[0])
        return sheen_fail(
            err, SHEEN_EUNSUP,
            "this build has no viewer to put into a page; install nodejs and npm, and build again");
    st = sheen_session_open(&s, cli->args[0], err);
    if (st)
        return st;
    st = sheen_cli_view_open(&v, &s, err);
    if (!st) {
        st = export_page(cli, &a, &s, &v, err);
        sheen_cli_view_close(&v);
    }
    sheen_session_release(&s);
    return st;
}

const sheen_command sheen_cmd_export = {
    .name = "export",
    .synopsis = "SESSION -o FILE.html [options]",
    .summary = "the model for others: one web page that needs nothing else",
    .about =
        "Wants a fitted model in the session. The page holds mesh, texture, lights and viewer, works from a\n"
        "disk or a mail attachment, and asks no server for anything. Its texture is made as fine as\n"
        "--max-size permits; what that loses is measured on the photographs and said.\n",
    .example = "  sheen export penguin.session -o penguin.html\n",
    .run = run,
};
