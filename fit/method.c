// SPDX-License-Identifier: Apache-2.0
// method.c - names of the methods, and the call that runs one.
#include "fit/method.h"

#include <stdlib.h>
#include <string.h>

#include "fit/refined.h"

static const char *const names[SHEEN_FIT_METHOD_COUNT] = {"refined", "paper"};

const char *sheen_fit_method_name(sheen_fit_method m)
{
    return names[m];
}

sheen_status sheen_fit_method_from_name(sheen_fit_method *out, const char *name, sheen_err *err)
{
    for (int i = 0; i < SHEEN_FIT_METHOD_COUNT; i++)
        if (!strcmp(name, names[i])) {
            *out = (sheen_fit_method)i;
            return SHEEN_OK;
        }
    return sheen_fail(err, SHEEN_EARG, "unknown method '%.40s': use 'refined' or 'paper'", name);
}

// Poses and exposures by what the photographs themselves agree on.
static sheen_status align(sheen_align_result *out, const sheen_mesh *mesh, sheen_photos *photos,
                          const sheen_paper_options *options, sheen_err *err)
{
    sheen_align_options o = {
        .poses = !options->keep_poses && sheen_extension_in(options->without, SHEEN_EXTENSION_POSES),
        .gains = !options->keep_exposures && sheen_extension_in(options->without, SHEEN_EXTENSION_EXPOSURES),
        .texels_per_edge = 2,
        .n_threads = options->n_threads,
        .progress = options->progress};
    while (o.texels_per_edge < 12 &&
           mesh->n_triangles * sheen_texels_per_triangle(o.texels_per_edge) < 150000)
        o.texels_per_edge++;
    *out = (sheen_align_result){0};
    if (!o.poses && !o.gains)
        return SHEEN_OK;
    sheen_stopwatch watch = sheen_stopwatch_now();
    sheen_scene *scene;
    sheen_status s = sheen_scene_new(&scene, mesh, err);
    if (!s)
        s = sheen_align_photos(out, photos, mesh, scene, &o, err);
    sheen_scene_free(&scene);
    sheen_progress_timed(&options->progress, "poses and exposures", &watch);
    return s;
}

// The paper's fit, and where its world is.
static sheen_status start(sheen_paper_fit *out, const sheen_mesh *mesh, const sheen_photos *photos,
                          sheen_moving moving, const sheen_paper_options *options, sheen_err *err)
{
    const sheen_status s = sheen_paper_fit_make(out, mesh, photos, options, err);
    if (s)
        return s;
    sheen_model *m = &out->model;
    const double *rt_world_obj = moving == SHEEN_MOVING_OBJECT ? photos->rt_board_obj
                                                               : photos->photos[0].rt_world_obj;
    m->moving = moving;
    memcpy(m->rt_world_cam, photos->rt_world_cam, sizeof m->rt_world_cam);
    memcpy(m->rt_world_obj, rt_world_obj, sizeof m->rt_world_obj);
    return SHEEN_OK;
}

static sheen_status fit_refined(sheen_paper_fit *out, const sheen_mesh *mesh, sheen_photos *photos,
                                sheen_moving moving, const sheen_paper_options *options, sheen_err *err)
{
    sheen_paper_options o = *options;
    // The minimum of an object that turned is its shaded side: no residuals of that.
    o.stop_after = moving == SHEEN_MOVING_OBJECT ? SHEEN_PAPER_TEXTURE : SHEEN_PAPER_HEMISPHERE;
    o.keep_texels = true;
    sheen_status s = start(out, mesh, photos, moving, &o, err);
    if (!s && (s = sheen_refined_fit(out, mesh, photos, options, err)))
        sheen_paper_fit_release(out);
    return s;
}

static sheen_status fit_aligned(sheen_paper_fit *out, const sheen_mesh *mesh, sheen_photos *photos,
                                const sheen_paper_options *options, sheen_err *err)
{
    sheen_align_result aligned;
    sheen_image *taken = NULL;
    *out = (sheen_paper_fit){0};
    sheen_status s = align(&aligned, mesh, photos, options, err);
    if (s)
        return s;
    if (aligned.gains_kept) {
        taken = calloc(photos->count, sizeof *taken);
        s = taken ? sheen_align_divide(taken, photos, &aligned, err)
                  : sheen_fail_memory(err, 24.0 * (double)photos->count, "pictures");
    }
    if (!s) {
        s = fit_refined(out, mesh, photos, SHEEN_MOVING_CAMERA, options, err);
        if (taken)
            sheen_align_give_back(photos, taken);
    }
    free(taken);
    if (s)
        sheen_align_result_release(&aligned);
    else
        out->align = aligned;
    return s;
}

sheen_status sheen_fit_make(sheen_paper_fit *out, sheen_fit_method method, sheen_moving moving,
                            const sheen_mesh *mesh, sheen_photos *photos, const sheen_paper_options *options,
                            sheen_err *err)
{
    if (method == SHEEN_FIT_PAPER)
        return start(out, mesh, photos, moving, options, err);
    // On a turntable the tags say where the object stood, and every exposure has its own light: nothing to agree on.
    return moving == SHEEN_MOVING_OBJECT ? fit_refined(out, mesh, photos, moving, options, err)
                                         : fit_aligned(out, mesh, photos, options, err);
}
