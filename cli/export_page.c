// SPDX-License-Identifier: Apache-2.0
// export_page.c - a model as one web page: the texture as fine as the size permits, and what that lost.
#include "cli/export.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/vec.h"
#include "cli/export_loss.h"
#include "cli/page_photos.h"
#include "cli/viewer_html.h"
#include "render/pack_avif.h"
#include "render/simpler_model.h"

// The finest and the coarsest code that is tried; what is coarser than that is worse than fewer texels.
enum { FINEST = 4, COARSEST = 44, LEAST_TRIANGLES = 1000 };

// A finished page, with the parts that it is made of.
typedef struct made_page {
    sheen_page page;
    char *text;
    size_t size_bytes;
    int texels_per_edge, quantizer;
} made_page;

typedef struct exporting {
    const sheen_export_args *args;
    const sheen_progress *progress;
    const sheen_model *model;
    sheen_model
        simpler; // of fewer triangles than the model, where its mesh alone would fill a page; else none
    double moved_m, moved_px; // by that; pixels of a photograph
    sheen_page_view view;
    char title[256];
    char *more; // first view and photographs, JSON
    size_t more_bytes;
    int n_tried;
} exporting;

static void made_page_release(made_page *p)
{
    sheen_page_release(&p->page);
    free(p->text);
    *p = (made_page){.text = NULL};
}

static sheen_status make_page(made_page *out, exporting *e, const sheen_model *model, int quantizer,
                              sheen_err *err)
{
    const sheen_page_options options = {.quantizer = quantizer, .n_threads = e->args->n_threads};
    const sheen_page_words words = {.title = e->title, .sources = "", .more_json = e->more};
    *out = (made_page){.texels_per_edge = model->texture.texels_per_edge, .quantizer = quantizer};
    sheen_status s = sheen_progress_step(e->progress, "sizes tried", e->n_tried++, 0, err);
    if (!s)
        s = sheen_page_pack(&out->page, model, &e->view, &options, err);
    if (!s)
        s = sheen_page_html(&out->text, &out->size_bytes, &out->page, sheen_viewer_html, &words, err);
    if (s)
        made_page_release(out);
    return s;
}

// The finest page of this texture within the size, by bisection; the coarsest where none is.
static sheen_status choose_quantizer(made_page *best, exporting *e, const sheen_model *model, sheen_err *err)
{
    if (e->args->quantizer >= 0)
        return make_page(best, e, model, e->args->quantizer, err);
    const double most_bytes = 1e3 * e->args->max_size_kb;
    int beyond = FINEST - 1, fits = COARSEST;
    sheen_status s = make_page(best, e, model, COARSEST, err);
    if (s || (double)best->size_bytes > most_bytes)
        return s;
    while (!s && fits - beyond > 1) {
        made_page next;
        const int middle = beyond < FINEST ? FINEST : (fits + beyond) / 2;
        s = make_page(&next, e, model, middle, err);
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

// A mesh that would fill most of a page by itself is simplified until it takes an eighth of it, and its new normal map as much.
static sheen_status simplify(exporting *e, sheen_err *err)
{
    static const double most_share = 0.6, wanted_share = 0.12, least_bytes = 5; // a triangle, in base64
    const double most_bytes = 1e3 * e->args->max_size_kb, n = (double)e->model->mesh.n_triangles;
    made_page whole;
    if (e->args->quantizer >= 0 || n * least_bytes < most_share * most_bytes)
        return SHEEN_OK;
    const sheen_status s = make_page(&whole, e, e->model, COARSEST, err);
    if (s)
        return s;
    const double geometry_bytes = 4.0 / 3 * (double)whole.page.geometry_bytes;
    made_page_release(&whole);
    if (geometry_bytes <= most_share * most_bytes)
        return SHEEN_OK;
    const size_t n_wanted = (size_t)(n * wanted_share * most_bytes / geometry_bytes);
    return sheen_simpler_model_make(
        &e->simpler, e->model, n_wanted > LEAST_TRIANGLES ? n_wanted : LEAST_TRIANGLES, &e->moved_m, err);
}

static const sheen_model *shown_model(const exporting *e)
{
    return e->simpler.mesh.n_triangles ? &e->simpler : e->model;
}

// As many texels as still fit at the coarsest code.
static sheen_status choose(made_page *best, exporting *e, sheen_err *err)
{
    const sheen_model *model = shown_model(e);
    const sheen_texture *whole = &model->texture;
    int texels = e->args->texels_per_edge ? e->args->texels_per_edge : whole->texels_per_edge;
    for (;;) {
        sheen_model packed = *model;
        sheen_status s = sheen_texture_resample(&packed.texture, whole, texels, err);
        if (s)
            return s;
        s = choose_quantizer(best, e, &packed, err);
        sheen_texture_release(&packed.texture);
        if (s || e->args->texels_per_edge || e->args->quantizer >= 0 || texels == SHEEN_TEXTURE_MIN_EDGE ||
            (double)best->size_bytes <= 1e3 * e->args->max_size_kb)
            return s;
        made_page_release(best);
        texels = texels * 2 / 3 > SHEEN_TEXTURE_MIN_EDGE ? texels * 2 / 3 : SHEEN_TEXTURE_MIN_EDGE;
    }
}

// Draws what the page's bytes hold, and compares.
static sheen_status measure(sheen_export_loss *loss, exporting *e, const sheen_session *session,
                            const sheen_page *page, sheen_err *err)
{
    sheen_export_views views;
    sheen_model shown;
    sheen_status s = sheen_export_views_open(&views, session, e->model, e->args->n_threads, e->progress, err);
    if (s)
        return s;
    const double *t_m = views.photos.photos[0].rt_cam_obj + 3;
    e->moved_px = e->moved_m * views.photos.cam.intrinsics[0] / sheen_norm(t_m);
    s = sheen_page_unpack(&shown, NULL, page, err);
    if (!s) {
        s = sheen_export_measure(loss, &views, &shown, err);
        sheen_model_release(&shown);
    }
    sheen_export_views_close(&views);
    return s;
}

static void say(sheen_cli *cli, const sheen_export_args *a, const exporting *e, const made_page *p,
                const sheen_export_loss *loss)
{
    const double loss_db = loss->full_db - loss->packed_db;
    const sheen_model *shown = shown_model(e);
    sheen_cli_clear_bar(cli);
    sheen_cli_say(cli, "%s: %.0f kB", a->output, (double)p->size_bytes / 1e3);
    if (shown == &e->simpler) {
        sheen_cli_say(cli,
                      "  simplified from %zu triangles to %zu: the surface moved by up to about %.2g mm, "
                      "%.1f px of a photograph",
                      e->model->mesh.n_triangles, shown->mesh.n_triangles, 1e3 * e->moved_m, e->moved_px);
        sheen_json_put_number(&cli->out, "moved_m", e->moved_m);
    }
    sheen_json_put_int(&cli->out, "triangles", (long long)shown->mesh.n_triangles);
    sheen_cli_say(cli,
                  "  mesh and lights %.0f kB, texture of %d texels an edge %.0f kB (quantizer %d), board "
                  "%.0f kB, before base64",
                  (double)p->page.geometry_bytes / 1e3, p->texels_per_edge,
                  (double)p->page.texture_bytes / 1e3, p->quantizer, (double)p->page.board_bytes / 1e3);
    sheen_cli_say(cli, "  on the photographs %.2f dB, the model itself %.2f dB: packing %s %.2f dB",
                  loss->packed_db, loss->full_db, loss_db >= 0 ? "lost" : "smoothed noise and gained",
                  fabs(loss_db));
    sheen_cli_say(cli, "  drawings of both agree to %.1f dB", loss->agreement_db);
    sheen_json_put_string(&cli->out, "made", a->output);
    sheen_json_put_int(&cli->out, "size_bytes", (long long)p->size_bytes);
    sheen_json_put_int(&cli->out, "geometry_bytes", (long long)p->page.geometry_bytes);
    sheen_json_put_int(&cli->out, "texture_bytes", (long long)p->page.texture_bytes);
    sheen_json_put_int(&cli->out, "board_bytes", (long long)p->page.board_bytes);
    sheen_json_put_int(&cli->out, "texels_per_edge", p->texels_per_edge);
    sheen_json_put_int(&cli->out, "quantizer", p->quantizer);
    sheen_json_put_number(&cli->out, "loss_db", loss_db);
    sheen_json_put_number(&cli->out, "photographs_db", loss->packed_db);
    sheen_json_put_number(&cli->out, "agreement_db", loss->agreement_db);
    if (loss_db > a->max_loss_db) {
        sheen_cli_warn(cli, "packing lost %.2f dB, more than the limit of %g dB", loss_db, a->max_loss_db);
        cli->limit_missed = true;
    }
    if (a->quantizer < 0 && (double)p->size_bytes > 1e3 * a->max_size_kb) {
        sheen_cli_warn(cli, "the page is larger than %g kB; a mesh of fewer triangles helps", a->max_size_kb);
        cli->limit_missed = true;
    }
}

void sheen_export_title(char title[256], const sheen_export_args *a, const sheen_session *s)
{
    snprintf(title, 256, "%.255s", a->title ? a->title : sheen_path_base(s->path));
    char *ending = a->title ? NULL : strstr(title, ".session");
    if (ending && ending != title)
        *ending = 0;
}

void sheen_export_page_view(sheen_page_view *out, const sheen_cli_view *v)
{
    out->focal_per_width = v->camera.intrinsics[0] / v->camera.width_px;
    memcpy(out->rt_board_obj, v->rt_board_obj, sizeof out->rt_board_obj);
}

static sheen_status tell_more(exporting *e, const sheen_session *s, const sheen_cli_view *v, sheen_err *err)
{
    enum { PHOTO_WIDTH_PX = 800 };
    sheen_page_photos photos;
    double look_deg[2];
    sheen_status st = sheen_export_first_view(look_deg, v, s, err);
    if (st || (st = sheen_page_photos_open(&photos, s, (size_t)e->args->n_photographs, err)))
        return st;
    st = sheen_page_more(&e->more, &photos, s, v, look_deg, true, PHOTO_WIDTH_PX, err);
    if (!st)
        e->more_bytes = strlen(e->more);
    sheen_page_photos_close(&photos);
    return st;
}

sheen_status sheen_export_page(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                               const sheen_cli_view *v, sheen_err *err)
{
    const sheen_progress progress = sheen_cli_progress(cli);
    exporting e = {.args = a, .progress = &progress, .model = &v->model};
    made_page best;
    sheen_export_loss loss;
    if (!sheen_viewer_html[0])
        return sheen_fail(
            err, SHEEN_EUNSUP,
            "this build has no viewer to put into a page; install nodejs and npm, and build again");
    sheen_export_title(e.title, a, s);
    sheen_export_page_view(&e.view, v);
    sheen_status st = tell_more(&e, s, v, err);
    if (!st)
        st = simplify(&e, err);
    if (!st)
        st = choose(&best, &e, err);
    if (st) {
        free(e.more);
        sheen_simpler_model_release(&e.simpler);
        return st;
    }
    st = measure(&loss, &e, s, &best.page, err);
    if (!st)
        st = sheen_file_write(a->output, best.text, best.size_bytes, err);
    if (!st)
        say(cli, a, &e, &best, &loss);
    if (!st && a->n_photographs)
        sheen_cli_say(cli, "  photographs %.0f kB", (double)e.more_bytes / 1e3);
    made_page_release(&best);
    sheen_simpler_model_release(&e.simpler);
    free(e.more);
    return st;
}
