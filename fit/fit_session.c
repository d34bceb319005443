// SPDX-License-Identifier: Apache-2.0
// fit_session.c - reads what the fit needs, fits, writes model/ beside its place and moves it there.
#include "fit/fit_session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/pictures.h"

#define UNFINISHED ".model.new"

typedef struct stage {
    const sheen_session *s;
    sheen_mesh mesh;
    sheen_photos photos;
    sheen_paper_fit fit;
    sheen_fit_summary *summary;
    sheen_status stamp_status;
    sheen_err *err;
} stage;

// Names of the files that a model depends on. The mesh is the one whose name differs between sessions.
static void input_files(const char *files[7], const sheen_session *s)
{
    const char *mesh = sheen_session_mesh_file(s);
    const char *const all[7] = {SHEEN_SESSION_CAMERA,
                                SHEEN_SESSION_POSES,
                                SHEEN_SESSION_REGISTRATION,
                                SHEEN_SESSION_MANIFEST,
                                "frames:input",
                                mesh ? mesh : SHEEN_SESSION_MESH,
                                NULL};
    memcpy(files, all, sizeof all);
}

static sheen_status load(stage *st, const sheen_progress *progress, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const char *mesh = sheen_session_mesh_file(st->s);
    if (!mesh)
        return sheen_fail(
            err, SHEEN_EDATA,
            "'%s' has no mesh of the object yet: 'sheen register %s MESH' finds where it stands "
            "('sheen import --mesh' takes one that is in the board's frame)",
            st->s->path, st->s->path);
    sheen_status s = sheen_session_path(path, st->s, mesh, err);
    if (s || (s = sheen_mesh_load(&st->mesh, path, err)))
        return s;
    return sheen_photos_load(&st->photos, st->s, SHEEN_ROLE_INPUT, progress, err);
}

static void summarize_align(sheen_fit_summary *out, const sheen_align_result *r)
{
    double least = HUGE_VAL, most = -HUGE_VAL;
    out->poses_refined = r->poses_kept;
    out->exposures_refined = r->gains_kept;
    for (size_t i = 0; i < r->n_views && r->views; i++) {
        const sheen_align_view *v = &r->views[i];
        const float gain[3] = {(float)v->gain[0], (float)v->gain[1], (float)v->gain[2]};
        const double ev = log2((double)sheen_luminance(gain));
        out->pose_moved_px += v->moved_px * v->moved_px / (double)r->n_views;
        out->pose_sigma_px += v->sigma_px * v->sigma_px / (double)r->n_views;
        least = fmin(least, ev);
        most = fmax(most, ev);
    }
    out->pose_moved_px = sqrt(out->pose_moved_px);
    out->pose_sigma_px = sqrt(out->pose_sigma_px);
    out->exposure_range_ev = most > least ? most - least : 0;
}

static sheen_status summarize(sheen_fit_summary *out, const sheen_paper_fit *f, sheen_err *err)
{
    *out = (sheen_fit_summary){.f0 = f->model.surroundings.present ? f->model.surroundings.f0 : (double)NAN,
                               .n_views = f->n_views,
                               .n_samples = f->n_samples,
                               .texels_per_edge = f->model.texture.texels_per_edge,
                               .n_nodes = f->geodesic.n_nodes,
                               .n_assigned = f->combined.n_assigned,
                               .n_left = f->refined.n_nodes_left,
                               .sigma0_rad = f->sigma0_rad,
                               .sigma_rad = f->refined.sigma_rad,
                               .k_s = f->refined.k_s,
                               .sigma_err = f->refined.sigma_err,
                               .objective = f->refined.objective,
                               .converged = f->refined.converged,
                               .n_turns = f->refined.n_turns};
    summarize_align(out, &f->align);
    snprintf(out->method, sizeof out->method, "%s", f->model.method);
    memcpy(out->light_rgb, f->model.light_rgb, sizeof out->light_rgb);
    const sheen_texture *t = &f->model.texture;
    const size_t n = t->n_triangles * sheen_texels_per_triangle(t->texels_per_edge);
    size_t n_seen = 0;
    for (size_t i = 0; i < n; i++)
        n_seen += t->n_views[i] > 0;
    out->seen_share = n ? (double)n_seen / (double)n : 0;
    for (size_t i = 0; i < f->geodesic.n_nodes; i++)
        out->n_reached += f->combined.n_reached[i] > 0;
    const size_t size_bytes = f->refined.n_turns * sizeof *out->turns;
    out->turns = malloc(size_bytes + 1);
    if (!out->turns)
        return sheen_fail_memory(err, (double)size_bytes, "the fit's history");
    memcpy(out->turns, f->refined.turns, size_bytes);
    return SHEEN_OK;
}

void sheen_fit_summary_release(sheen_fit_summary *f)
{
    free(f->turns);
    sheen_certainty_release(&f->certainty);
    f->turns = NULL;
    f->n_turns = 0;
}

// What was changed in each photograph, in their order by name.
static void write_align(sheen_json_writer *w, const sheen_align_result *r)
{
    if (!r->poses_kept && !r->gains_kept)
        return;
    sheen_json_open(w, "photographs", '[');
    for (size_t i = 0; i < r->n_views; i++) {
        const sheen_align_view *v = &r->views[i];
        sheen_json_open(w, NULL, '{');
        if (r->poses_kept) {
            sheen_json_put_number(w, "moved_px", v->moved_px);
            sheen_json_put_number(w, "sigma_px", v->sigma_px);
        }
        if (r->gains_kept)
            sheen_json_put_numbers(w, "gain", v->gain, 3);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

static void write_certainty(sheen_json_writer *w, const sheen_certainty *c)
{
    sheen_json_open(w, "certainty", '{');
    sheen_json_put_number(w, "sigma_share", c->sigma_share);
    sheen_json_put_number(w, "k_s_share", c->k_s_share);
    if (c->n_gloss)
        sheen_json_put_numbers(w, "gloss_share", c->gloss_share, (size_t)c->n_gloss);
    sheen_json_put_number(w, "unseen_share", c->unseen_share);
    sheen_json_put_number(w, "once_share", c->once_share);
    sheen_json_open(w, "lamps", '[');
    for (size_t i = 0; i < c->n_lamps; i++) {
        const sheen_lamp_certainty *l = &c->lamps[i];
        sheen_json_open(w, NULL, '{');
        sheen_json_put_numbers(w, "v_world", l->v_world, 3);
        sheen_json_put_number(w, "strength", l->strength);
        sheen_json_put_int(w, "n_views", (long long)l->n_views);
        sheen_json_put_number(w, "strength_share", l->strength_share);
        sheen_json_put_number(w, "direction_rad", l->direction_rad);
        sheen_json_close(w);
    }
    sheen_json_close(w);
    if (c->advised) {
        const double advice_deg[2] = {c->advice_azimuth_deg, c->advice_elevation_deg};
        sheen_json_put_numbers(w, "next_viewpoint_deg", advice_deg, 2);
    }
    sheen_json_open(w, "not_determined", '[');
    for (size_t i = 0; i < c->n_sentences; i++)
        sheen_json_put_string(w, NULL, c->sentences[i]);
    sheen_json_close(w);
    sheen_json_close(w);
}

// Members of model.json that tell how it came about.
static void write_report(void *self, sheen_json_writer *w)
{
    stage *st = self;
    const sheen_fit_summary *r = st->summary;
    const char *files[7];
    input_files(files, st->s);
    sheen_json_open(w, "fit", '{');
    sheen_json_put_int(w, "n_views", (long long)r->n_views);
    sheen_json_put_int(w, "n_samples", (long long)r->n_samples);
    sheen_json_put_number(w, "texels_seen_share", r->seen_share);
    sheen_json_put_int(w, "n_nodes_reached", (long long)r->n_reached);
    sheen_json_put_int(w, "n_nodes_assigned", (long long)r->n_assigned);
    sheen_json_put_int(w, "n_nodes_left", (long long)r->n_left);
    sheen_json_put_number(w, "threshold_lin", st->fit.threshold_lin);
    sheen_json_put_number(w, "sigma0_rad", r->sigma0_rad);
    sheen_json_put_number(w, "sigma_err", r->sigma_err);
    sheen_json_put_number(w, "objective", r->objective);
    sheen_json_put_bool(w, "converged", r->converged);
    write_align(w, &st->fit.align);
    write_certainty(w, &r->certainty);
    sheen_json_open(w, "turns", '[');
    for (size_t i = 0; i < r->n_turns; i++) {
        const sheen_refine_turn *t = &r->turns[i];
        const double row[4] = {t->sigma_rad, t->k_s, t->objective, (double)t->n_nodes_left};
        sheen_json_put_numbers(w, NULL, row, 4);
    }
    sheen_json_close(w);
    sheen_json_close(w);
    st->stamp_status = sheen_stamp_write(w, st->s, files, st->err);
}

static sheen_status save(stage *st, sheen_err *err)
{
    char unfinished[SHEEN_PATH_MAX], finished[SHEEN_PATH_MAX];
    sheen_status s;
    if ((s = sheen_session_path(unfinished, st->s, UNFINISHED, err)) ||
        (s = sheen_session_path(finished, st->s, SHEEN_SESSION_MODEL, err)) ||
        (s = sheen_dir_remove(unfinished, err)) || (s = sheen_dir_make(unfinished, err)))
        return s;
    st->err = err;
    if ((s = sheen_model_save(&st->fit.model, st->s, unfinished, write_report, st, err)) ||
        (s = st->stamp_status) || (s = sheen_fit_pictures(&st->fit, &st->photos, unfinished, err)) ||
        (s = sheen_dir_replace(finished, unfinished, err))) {
        sheen_dir_remove(unfinished, NULL);
        return s;
    }
    return SHEEN_OK;
}

sheen_status sheen_fit_session(sheen_fit_summary *out, const sheen_session *s, sheen_fit_method method,
                               const sheen_paper_options *options, sheen_err *err)
{
    *out = (sheen_fit_summary){0};
    stage st = {.s = s, .summary = out};
    sheen_stopwatch watch = sheen_stopwatch_now();
    sheen_status status = load(&st, &options->progress, err);
    if (status)
        goto done;
    sheen_progress_timed(&options->progress, "reading photographs", &watch);
    if ((status = sheen_fit_make(&st.fit, method, s->moving, &st.mesh, &st.photos, options, err)))
        goto done;
    st.fit.model.mesh = st.mesh; // the model owns it from here on
    st.mesh = (sheen_mesh){0};
    if ((status = summarize(out, &st.fit, err)))
        goto done;
    out->n_dark = st.photos.n_dark;
    memcpy(out->dark_name, st.photos.dark_name, sizeof out->dark_name);
    watch = sheen_stopwatch_now();
    if ((status = sheen_certainty_find(&out->certainty, &st.fit, &st.fit.model.mesh, &st.photos, s->moving,
                                       err))) {
        sheen_fit_summary_release(out);
        goto done;
    }
    sheen_progress_timed(&options->progress, "how sure it is", &watch);
    if ((status = save(&st, err)))
        sheen_fit_summary_release(out);
    sheen_progress_timed(&options->progress, "writing the model", &watch);

done:
    sheen_paper_fit_release(&st.fit);
    sheen_photos_release(&st.photos);
    sheen_mesh_release(&st.mesh);
    return status;
}

bool sheen_fit_is_current(const sheen_session *s)
{
    char path[SHEEN_PATH_MAX];
    const char *files[7];
    sheen_json *root = NULL;
    input_files(files, s);
    if (sheen_session_path(path, s, SHEEN_SESSION_MODEL "/model.json", NULL) || !sheen_file_exists(path) ||
        sheen_json_load(&root, path, NULL))
        return false;
    const bool current = sheen_stamp_is_current(root, s, files);
    sheen_json_free(&root);
    return current;
}
