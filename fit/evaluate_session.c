// SPDX-License-Identifier: Apache-2.0
// evaluate_session.c - gathers model and held-out pictures, scores them, writes evaluation/.
#include "fit/evaluate_session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/pose3.h"
#include "base/pose_file.h"
#include "fit/comparison.h"

#define UNFINISHED ".evaluation.new"

static const char model_file[] = SHEEN_SESSION_MODEL "/model.json";
static const char result_file[] = SHEEN_SESSION_EVALUATION "/evaluation.json";

static const char *const stamp_files[] = {
    model_file,     SHEEN_SESSION_CAMERA, SHEEN_SESSION_POSES, SHEEN_SESSION_REGISTRATION,
    "frames:input", "frames:test",        "highlights:test",   NULL};

typedef struct stage {
    const sheen_session *s;
    const sheen_evaluate_session_options *o;
    sheen_model model;
    sheen_photos inputs, tests;
    sheen_image *highlights; // [tests.count]
    sheen_comparison comparison;
    double rt_board_obj[6];
    sheen_evaluation *out;
} stage;

// A mask <dir>/highlights/<name>.png; an empty image where there is none.
static sheen_status load_highlights(sheen_image *out, const char *dir, const sheen_photo *photo,
                                    sheen_err *err)
{
    char name[160], path[SHEEN_PATH_MAX];
    snprintf(name, sizeof name, SHEEN_SESSION_HIGHLIGHTS "/%s.png", photo->name);
    sheen_status s = sheen_path_join(path, dir, name, err);
    if (s || !sheen_file_exists(path))
        return s;
    uint8_t *data;
    size_t size_bytes;
    if ((s = sheen_file_read(&data, &size_bytes, path, (size_t)256 << 20, err)))
        return s;
    s = sheen_mask_parse(out, data, size_bytes, photo->image.width_px, photo->image.height_px, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read '%s'", path) : SHEEN_OK;
}

static sheen_status load_all_highlights(stage *st, const char *dir, sheen_err *err)
{
    st->highlights = calloc(st->tests.count + 1, sizeof *st->highlights);
    if (!st->highlights)
        return sheen_fail_memory(err, 24.0 * (double)st->tests.count, "highlight masks");
    sheen_status s = SHEEN_OK;
    for (size_t i = 0; i < st->tests.count && !s; i++)
        s = load_highlights(&st->highlights[i], dir, &st->tests.photos[i], err);
    return s;
}

// The picture of a view: the file that the pose file names, or <name> with one of the extensions, in the folder.
static sheen_status find_picture(char path[SHEEN_PATH_MAX], const char *dir, const sheen_view *view,
                                 sheen_err *err)
{
    static const char *const extensions[] = {"png", "exr", "jpg", "jpeg", "tif", "tiff"};
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++) {
        char name[160];
        snprintf(name, sizeof name, "%s.%s", view->name, extensions[i]);
        const sheen_status s = sheen_path_join(path, dir, name, err);
        if (s || sheen_file_exists(path))
            return s;
    }
    return sheen_fail(err, SHEEN_EIO, "no picture of view '%s' in '%s'", view->name, dir);
}

static sheen_status load_outside_photo(stage *st, sheen_photo *photo, const sheen_view *view, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_raster raster = {0};
    sheen_status s = find_picture(path, st->o->against_dir, view, err);
    if (s || (s = sheen_raster_load(&raster, path, err)))
        return s;
    s = sheen_image_from_raster(&photo->image, &raster, st->o->transfer, err);
    sheen_raster_release(&raster);
    if (s)
        return s;
    if (photo->image.width_px != st->tests.cam.width_px || photo->image.height_px != st->tests.cam.height_px)
        return sheen_fail(err, SHEEN_EFORMAT, "'%s' is %d x %d px, its camera %d x %d", path,
                          photo->image.width_px, photo->image.height_px, st->tests.cam.width_px,
                          st->tests.cam.height_px);
    snprintf(photo->name, sizeof photo->name, "%.63s", view->name);
    sheen_rt_compose(photo->rt_cam_obj, view->rt_cam_world, st->rt_board_obj);
    sheen_model_place(photo->rt_world_obj, &st->model, photo->rt_cam_obj);
    return SHEEN_OK;
}

// Pictures and poses from outside; those of the pose file that have no picture are an error. The file's own camera, or the session's.
static sheen_status load_outside(stage *st, sheen_err *err)
{
    sheen_pose_file poses = {0};
    sheen_status s = sheen_registration_load(st->rt_board_obj, st->s, err);
    if (s || (s = sheen_pose_file_load(&poses, st->o->poses_path, err)))
        return s;
    st->tests.cam = poses.n_cameras ? poses.cameras[0] : st->inputs.cam;
    st->tests.photos = calloc(poses.n_views + 1, sizeof *st->tests.photos);
    if (!st->tests.photos)
        s = sheen_fail_memory(err, 300.0 * (double)poses.n_views, "photographs");
    for (size_t i = 0; i < poses.n_views && !s; i++) {
        st->tests.count = i + 1;
        s = load_outside_photo(st, &st->tests.photos[i], &poses.views[i], err);
    }
    sheen_pose_file_release(&poses);
    return s;
}

static sheen_status run(stage *st, sheen_err *err)
{
    const sheen_evaluate_options o = {.n_threads = st->o->fit.n_threads,
                                      .progress = st->o->fit.progress,
                                      .picture = sheen_comparison_add,
                                      .picture_self = &st->comparison};
    sheen_evaluation e = {0};
    sheen_status s = sheen_evaluate(&e, &st->model, &st->inputs, &st->tests, st->highlights, &o, err);
    if (!s && (s = st->comparison.status) && err)
        *err = st->comparison.err;
    if (!s)
        s = sheen_evaluation_append(st->out, &e, err);
    sheen_evaluation_release(&e);
    return s;
}

static sheen_status evaluate_given(stage *st, sheen_err *err)
{
    sheen_status s = sheen_model_load(&st->model, st->s, err);
    if (s || (s = sheen_photos_load(&st->inputs, st->s, SHEEN_ROLE_INPUT, &st->o->fit.progress, err)))
        return s;
    if (st->o->against_dir)
        s = load_outside(st, err);
    else
        s = sheen_photos_load(&st->tests, st->s, SHEEN_ROLE_TEST, &st->o->fit.progress, err);
    if (!s)
        s = load_all_highlights(st, st->o->against_dir ? st->o->against_dir : st->s->path, err);
    return s ? s : run(st, err);
}

// Splits all photographs: those of the fold are tests, the others inputs. Both lists borrow their images.
static sheen_status split(stage *st, const sheen_photos *all, int fold, sheen_err *err)
{
    const size_t size_bytes = all->count * sizeof *all->photos;
    st->inputs = st->tests = *all;
    st->inputs.count = st->tests.count = 0;
    st->inputs.photos = malloc(size_bytes);
    st->tests.photos = malloc(size_bytes);
    if (!st->inputs.photos || !st->tests.photos)
        return sheen_fail_memory(err, 2.0 * (double)size_bytes, "photographs");
    for (size_t i = 0; i < all->count; i++) {
        sheen_photos *to = i % (size_t)st->o->n_folds == (size_t)fold ? &st->tests : &st->inputs;
        to->photos[to->count++] = all->photos[i];
    }
    return SHEEN_OK;
}

static sheen_status evaluate_fold(stage *st, const sheen_photos *all, sheen_mesh *mesh, int fold,
                                  sheen_err *err)
{
    sheen_paper_fit fit = {0};
    sheen_status s = split(st, all, fold, err);
    if (s || (s = load_all_highlights(st, st->s->path, err)))
        goto done;
    if ((s = sheen_fit_make(&fit, st->o->method, st->s->moving, mesh, &st->inputs, &st->o->fit, err)))
        goto done;
    st->model = fit.model;
    st->model.mesh = *mesh; // lent
    s = run(st, err);

done:
    sheen_paper_fit_release(&fit);
    sheen_model_init(&st->model);
    for (size_t i = 0; st->highlights && i < st->tests.count; i++)
        sheen_image_release(&st->highlights[i]);
    free(st->highlights);
    free(st->inputs.photos);
    free(st->tests.photos);
    st->highlights = NULL;
    st->inputs = st->tests = (sheen_photos){0};
    return s;
}

static sheen_status evaluate_folds(stage *st, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_photos all = {0};
    sheen_mesh mesh = {0};
    const char *file = sheen_session_mesh_file(st->s);
    if (!file)
        return sheen_fail(err, SHEEN_EDATA, "'%s' has no mesh of the object yet", st->s->path);
    sheen_status s = sheen_session_path(path, st->s, file, err);
    if (s || (s = sheen_mesh_load(&mesh, path, err)) ||
        (s = sheen_photos_load(&all, st->s, SHEEN_ROLE_INPUT, &st->o->fit.progress, err)))
        goto done;
    if ((size_t)st->o->n_folds > all.count || st->o->n_folds < 2)
        s = sheen_fail(err, SHEEN_EARG, "cannot leave out every %d. of %zu photographs: use 2 to %zu",
                       st->o->n_folds, all.count, all.count);
    for (int fold = 0; fold < st->o->n_folds && !s; fold++)
        s = evaluate_fold(st, &all, &mesh, fold, err);

done:
    sheen_photos_release(&all);
    sheen_mesh_release(&mesh);
    return s;
}

static sheen_status write_results(const stage *st, const char *dir, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-evaluation/1");
    sheen_json_put_string(&w, "on",
                          st->o->n_folds       ? "left-out input frames"
                          : st->o->against_dir ? "other pictures"
                                               : "test frames");
    sheen_evaluation_write(st->out, &w);
    sheen_status s = SHEEN_OK;
    if (!st->o->n_folds && !st->o->against_dir)
        s = sheen_stamp_write(&w, st->s, stamp_files, err);
    sheen_json_close(&w);
    if (s || (s = sheen_path_join(path, dir, "evaluation.json", err))) {
        sheen_json_writer_release(&w);
        return s;
    }
    if ((s = sheen_json_save(&w, path, err)) || (s = sheen_path_join(path, dir, "evaluation.md", err)))
        return s;
    char *table = sheen_evaluation_table(st->out);
    if (!table)
        return sheen_fail_memory(err, 4096, "a table");
    s = sheen_file_write(path, table, strlen(table), err);
    free(table);
    return s;
}

sheen_status sheen_evaluate_session(sheen_evaluation *out, const sheen_session *s,
                                    const sheen_evaluate_session_options *options, sheen_err *err)
{
    *out = (sheen_evaluation){0};
    char unfinished[SHEEN_PATH_MAX], finished[SHEEN_PATH_MAX];
    stage st = {.s = s, .o = options, .out = out};
    sheen_model_init(&st.model);
    sheen_status status;
    if ((status = sheen_session_path(unfinished, s, UNFINISHED, err)) ||
        (status = sheen_session_path(finished, s, SHEEN_SESSION_EVALUATION, err)) ||
        (status = sheen_dir_remove(unfinished, err)) || (status = sheen_dir_make(unfinished, err)))
        return status;
    st.comparison.dir = unfinished;
    status = options->n_folds ? evaluate_folds(&st, err) : evaluate_given(&st, err);
    if (!status && !(status = write_results(&st, unfinished, err)))
        status = sheen_dir_replace(finished, unfinished, err);
    if (status) {
        sheen_dir_remove(unfinished, NULL);
        sheen_evaluation_release(out);
    }
    for (size_t i = 0; st.highlights && i < st.tests.count; i++)
        sheen_image_release(&st.highlights[i]);
    free(st.highlights);
    sheen_photos_release(&st.inputs);
    sheen_photos_release(&st.tests);
    sheen_model_release(&st.model);
    sheen_comparison_release(&st.comparison);
    return status;
}

bool sheen_evaluation_is_current(const sheen_session *s)
{
    char path[SHEEN_PATH_MAX];
    sheen_json *root = NULL;
    if (sheen_session_path(path, s, result_file, NULL) || !sheen_file_exists(path) ||
        sheen_json_load(&root, path, NULL))
        return false;
    const bool current = sheen_stamp_is_current(root, s, stamp_files);
    sheen_json_free(&root);
    return current;
}
