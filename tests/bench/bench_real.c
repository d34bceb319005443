// SPDX-License-Identifier: Apache-2.0
// bench_real.c - real photographs by others, each left out of a fit in turn and predicted: sheen beside the baselines.
//
//     bench_real FOLDER [--method NAME] [--without NAME,...] [--folds K] [--size SHARE] [--from NAME] [--to NAME]
//                       [--pictures DIR] [--exposures given|agreed]
//
// FOLDER holds cameras.json (per photograph: name, width, height, K, R_world_to_cam, t_world_to_cam; OpenCV axes, pixel corners at
// 0), images/, one .ply mesh in the cameras' frame, and may hold masks in a folder masks_*/ of any size. Every photograph is resampled to
// one pinhole camera. World's z is up: the mean normal of the surface that faces about where the cameras' tops point; its plane
// z = 0, which may be mirrored, lies under the mesh. --folds K leaves every K-th out (default: each). --from, --to: photographs by name.
// --exposures agreed: all photographs, those left out too, are first divided by the gains with which they agree on the surface (fit/align.h): the
// exposure of an automatic camera is nothing that a model of the object could predict. All methods get the same photographs, and
// surface that none of those shows is filled in the baselines as it is in the model.
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/json.h"
#include "base/mesh.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "fit/comparison.h"
#include "fit/evaluate_session.h"
#include "tests/support.h"

typedef struct arguments {
    const char *dir, *from, *to, *pictures;
    sheen_fit_method method;
    int n_folds, agreed;
    sheen_extensions without;
    double size;
} arguments;

typedef struct capture {
    char masks[600];
    sheen_mesh mesh;
    sheen_photos photos;
} capture;

// A file or folder of `dir` whose name begins and ends so.
static int find_entry(char path[600], const char *dir, const char *begin, const char *end)
{
    DIR *d = opendir(dir);
    int found = 0;
    for (struct dirent *e; d && !found && (e = readdir(d));) {
        const size_t n = strlen(e->d_name), n_end = strlen(end);
        if (strncmp(e->d_name, begin, strlen(begin)) != 0 || n < n_end ||
            strcmp(e->d_name + n - n_end, end) != 0)
            continue;
        snprintf(path, 600, "%.300s/%.255s", dir, e->d_name);
        found = 1;
    }
    if (d)
        closedir(d);
    return found;
}

// Mean of 3 x 3 samples of a pixel of `cam` in a picture with the intrinsics fxycxy; outside it is black.
static void resample(sheen_image *out, const sheen_image *in, const sheen_camera *cam,
                     const double in_fxycxy[4])
{
    sheen_err err;
    const double *K = cam->intrinsics;
    assert_ok(sheen_image_init(out, cam->width_px, cam->height_px, in->n_channels, &err), err);
    for (int y = 0; y < out->height_px; y++)
        for (int x = 0; x < out->width_px; x++)
            for (int k = 0; k < 9; k++) {
                const double sx = x + (k % 3 - 1) / 3.0, sy = y + ((double)(k / 3) - 1) / 3.0;
                const double u = (sx - K[2]) / K[0] * in_fxycxy[0] + in_fxycxy[2],
                             v = (sy - K[3]) / K[1] * in_fxycxy[1] + in_fxycxy[3];
                float value[3] = {0, 0, 0};
                sheen_image_bilinear(value, in, u, v);
                for (int c = 0; c < in->n_channels; c++)
                    sheen_image_at(out, x, y)[c] += value[c] / 9;
            }
}

static int load_picture(sheen_image *out, const char *path)
{
    sheen_raster raster;
    sheen_err err;
    if (sheen_raster_load(&raster, path, NULL))
        return 0;
    assert_ok(sheen_image_from_raster(out, &raster, SHEEN_TRANSFER_SRGB, &err), err);
    sheen_raster_release(&raster);
    return 1;
}

static void load_mask(sheen_photo *photo, const capture *c, const double fxycxy[4], const sheen_image *image)
{
    char path[1200];
    sheen_image mask, one;
    sheen_err err;
    snprintf(path, sizeof path, "%s/%s.png", c->masks, photo->name);
    if (!c->masks[0] || !load_picture(&mask, path))
        return;
    assert_ok(sheen_image_init(&one, mask.width_px, mask.height_px, 1, &err), err);
    for (size_t i = 0; i < (size_t)mask.width_px * (size_t)mask.height_px; i++)
        one.data[i] = mask.data[3 * i] > 0.5f ? 1 : 0;
    const double s = (double)mask.width_px / image->width_px;
    const double scaled[4] = {s * fxycxy[0], s * fxycxy[1], s * (fxycxy[2] + 0.5) - 0.5,
                              s * (fxycxy[3] + 0.5) - 0.5};
    resample(&photo->mask, &one, &c->photos.cam, scaled);
    sheen_image_release(&mask);
    sheen_image_release(&one);
}

static void load_photo(capture *c, const arguments *a, const sheen_json *view)
{
    const char *name;
    char path[1200];
    double K[9] = {0};
    sheen_Rt Rt;
    sheen_err err;
    sheen_image image;
    assert_ok(sheen_json_string(view, "name", &name, &err), err);
    if ((a->from && strcmp(name, a->from) < 0) || (a->to && strcmp(name, a->to) > 0))
        return;
    snprintf(path, sizeof path, "%s/images/%s", a->dir, name);
    if (!load_picture(&image, path)) {
        snprintf(path, sizeof path, "%s/images/%s.jpg", a->dir, name);
        if (!load_picture(&image, path))
            return; // a pose without its photograph
    }
    const sheen_json *k = sheen_json_get(view, "K"), *R = sheen_json_get(view, "R_world_to_cam");
    for (size_t i = 0; i < 9; i++) {
        K[i] = sheen_json_value_number(sheen_json_at(sheen_json_at(k, i / 3), i % 3), 0);
        Rt.R[i / 3][i % 3] = sheen_json_value_number(sheen_json_at(sheen_json_at(R, i / 3), i % 3), 0);
    }
    assert_ok(sheen_json_numbers(view, "t_world_to_cam", Rt.t, 3, &err), err);
    const double fxycxy[4] = {K[0], K[4], K[2] - 0.5, K[5] - 0.5};
    if (!c->photos.count) {
        const double s = a->size, w = floor(s * image.width_px), h = floor(s * image.height_px);
        const double own[4] = {s * fxycxy[0], s * fxycxy[0], 0.5 * (w - 1), 0.5 * (h - 1)};
        assert_ok(sheen_camera_opencv(&c->photos.cam, (int)w, (int)h, own, NULL, 0, &err), err);
    }
    sheen_photo *p = &c->photos.photos[c->photos.count++];
    snprintf(p->name, sizeof p->name, "%.63s", name);
    sheen_rt_from_Rt(p->rt_cam_obj, &Rt);
    resample(&p->image, &image, &c->photos.cam, fxycxy);
    load_mask(p, c, fxycxy, &image);
    sheen_image_release(&image);
}

// Mean of the surface's normals within 40 degrees of where the cameras' tops point, twice.
static void find_up(double up[3], const capture *c)
{
    up[0] = up[1] = up[2] = 0;
    for (size_t i = 0; i < c->photos.count; i++) {
        sheen_Rt Rt;
        sheen_Rt_from_rt(&Rt, c->photos.photos[i].rt_cam_obj);
        for (int k = 0; k < 3; k++)
            up[k] -= Rt.R[1][k];
    }
    sheen_normalize(up);
    for (int round = 0; round < 2; round++) {
        double sum[3] = {0, 0, 0};
        for (size_t t = 0; t < c->mesh.n_triangles; t++) {
            const uint32_t *v = c->mesh.triangles + 3 * t;
            float e[2][3], n[3];
            for (int k = 0; k < 2; k++)
                sheen_subf(e[k], c->mesh.p_obj + 3 * (size_t)v[k + 1], c->mesh.p_obj + 3 * (size_t)v[0]);
            sheen_crossf(n, e[0], e[1]);
            const double d[3] = {(double)n[0], (double)n[1], (double)n[2]}, length = sheen_norm(d);
            for (int k = 0; k < 3 && sheen_dot(d, up) > 0.77 * length; k++)
                sum[k] += d[k];
        }
        if (sheen_normalize(sum) > 0)
            memcpy(up, sum, sizeof sum);
    }
}

// The mesh in a world whose z is up and whose plane z = 0 its lowest hundredth lies under.
static void place_world(capture *c)
{
    double up[3], x[3], y[3];
    find_up(up, c);
    const double any[3] = {fabs(up[0]) < 0.7, fabs(up[0]) >= 0.7, 0};
    sheen_cross(x, any, up);
    sheen_normalize(x);
    sheen_cross(y, up, x);
    enum { BINS = 4096 };
    static size_t count[BINS];
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < c->mesh.n_vertices; i++) {
            const float *p = c->mesh.p_obj + 3 * i;
            const double z = up[0] * (double)p[0] + up[1] * (double)p[1] + up[2] * (double)p[2];
            if (pass)
                count[(size_t)((BINS - 1) * (z - least) / (most - least))]++;
            least = fmin(least, z);
            most = fmax(most, z);
        }
    size_t below = 0;
    int bin = 0;
    while (bin < BINS - 1 && (below += count[bin]) < c->mesh.n_vertices / 100)
        bin++;
    sheen_Rt Rt = {.t = {0, 0, -(least + (most - least) * bin / BINS)}};
    memcpy(Rt.R[0], x, sizeof x);
    memcpy(Rt.R[1], y, sizeof y);
    memcpy(Rt.R[2], up, sizeof up);
    sheen_rt_from_Rt(c->photos.rt_board_obj, &Rt);
    for (size_t i = 0; i < c->photos.count; i++)
        memcpy(c->photos.photos[i].rt_world_obj, c->photos.rt_board_obj, sizeof c->photos.rt_board_obj);
}

static void load(capture *c, const arguments *a)
{
    char path[700];
    sheen_json *root;
    sheen_err err;
    snprintf(path, sizeof path, "%s/cameras.json", a->dir);
    assert_ok(sheen_json_load(&root, path, &err), err);
    const sheen_json *views = sheen_json_get(root, "cameras");
    c->photos.photos = calloc(sheen_json_count(views) + 1, sizeof *c->photos.photos);
    assert_non_null(c->photos.photos);
    if (!find_entry(c->masks, a->dir, "masks", ""))
        c->masks[0] = 0;
    assert_true(find_entry(path, a->dir, "", ".ply"));
    assert_ok(sheen_mesh_load(&c->mesh, path, &err), err);
    for (size_t i = 0; i < sheen_json_count(views); i++)
        load_photo(c, a, sheen_json_at(views, i));
    sheen_json_free(&root);
    place_world(c);
}

static void agree_on_exposures(capture *c)
{
    sheen_scene *scene;
    sheen_align_result r;
    sheen_err err;
    const sheen_align_options o = {.gains = 1, .texels_per_edge = 3};
    sheen_image *taken = calloc(c->photos.count + 1, sizeof *taken);
    assert_non_null(taken);
    assert_ok(sheen_scene_new(&scene, &c->mesh, &err), err);
    assert_ok(sheen_align_photos(&r, &c->photos, &c->mesh, scene, &o, &err), err);
    assert_ok(sheen_align_divide(taken, &c->photos, &r, &err), err);
    for (size_t i = 0; i < c->photos.count; i++) {
        printf("%-24s exposed by %+.2f EV (green)\n", c->photos.photos[i].name, log2(r.views[i].gain[1]));
        sheen_image_release(&taken[i]);
    }
    free(taken);
    sheen_align_result_release(&r);
    sheen_scene_free(&scene);
}

static void run_fold(sheen_evaluation *all, const capture *c, const arguments *a, int fold)
{
    const sheen_paper_options o = {.without = a->without};
    sheen_comparison comparison = {.dir = a->pictures};
    const sheen_evaluate_options eo = {.picture = a->pictures ? sheen_comparison_add : NULL,
                                       .picture_self = &comparison};
    sheen_photos inputs = c->photos, tests = c->photos;
    sheen_paper_fit f;
    sheen_evaluation e;
    sheen_err err;
    inputs.photos = malloc((c->photos.count + 1) * sizeof *inputs.photos);
    tests.photos = malloc((c->photos.count + 1) * sizeof *tests.photos);
    assert_true(inputs.photos && tests.photos);
    inputs.count = tests.count = 0;
    for (size_t i = 0; i < c->photos.count; i++) {
        sheen_photos *to = (int)(i % (size_t)a->n_folds) == fold ? &tests : &inputs;
        to->photos[to->count++] = c->photos.photos[i];
    }
    const sheen_stopwatch start = sheen_stopwatch_now();
    const sheen_status s = sheen_fit_make(&f, a->method, SHEEN_MOVING_CAMERA, &c->mesh, &inputs, &o, &err);
    const sheen_stopwatch end = sheen_stopwatch_now();
    if (s) {
        printf("without %s: %s\n", tests.photos[0].name, err.msg);
    } else {
        sheen_model model = f.model;
        model.mesh = c->mesh; // lent
        assert_ok(sheen_evaluate(&e, &model, &inputs, &tests, NULL, &eo, &err), err);
        printf("without %-24s object %.2f dB, median texture %.2f; %zu lamps, sigma %.3f, F0 %.3f, %s poses; "
               "%.0f s, %.0f CPU s\n",
               tests.photos[0].name, sheen_evaluation_mean(&e, 0).object.srgb_db,
               sheen_evaluation_mean(&e, 1 + SHEEN_BASELINE_MEDIAN).object.srgb_db, f.model.n_lamps,
               f.model.sigma_rad, f.model.surroundings.present ? f.model.surroundings.f0 : 0,
               f.align.poses_kept ? "aligned" : "given", end.wall_s - start.wall_s, end.cpu_s - start.cpu_s);
        fflush(stdout);
        assert_ok(sheen_evaluation_append(all, &e, &err), err);
        sheen_evaluation_release(&e);
        sheen_paper_fit_release(&f);
    }
    sheen_comparison_release(&comparison);
    free(inputs.photos);
    free(tests.photos);
}

int main(int argc, char **argv)
{
    arguments a = {.size = 1};
    capture c = {0};
    sheen_evaluation all = {0};
    sheen_err err;
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (argv[i][0] != '-') {
            a.dir = argv[i];
            continue;
        }
        i++;
        if (!strcmp(argv[i - 1], "--method"))
            assert_ok(sheen_fit_method_from_name(&a.method, value, &err), err);
        else if (!strcmp(argv[i - 1], "--without"))
            assert_ok(sheen_extensions_parse(&a.without, value, &err), err);
        else if (!strcmp(argv[i - 1], "--folds"))
            a.n_folds = (int)strtol(value, NULL, 10);
        else if (!strcmp(argv[i - 1], "--size"))
            a.size = strtod(value, NULL);
        else if (!strcmp(argv[i - 1], "--from"))
            a.from = value;
        else if (!strcmp(argv[i - 1], "--to"))
            a.to = value;
        else if (!strcmp(argv[i - 1], "--exposures"))
            a.agreed = !strcmp(value, "agreed");
        else if (!strcmp(argv[i - 1], "--pictures"))
            a.pictures = value;
    }
    if (!a.dir) {
        printf("usage: bench_real FOLDER [options] (nothing to do without a folder)\n");
        return argc == 1 ? 0 : 2;
    }
    load(&c, &a);
    if (a.agreed)
        agree_on_exposures(&c);
    if (a.n_folds < 2 || (size_t)a.n_folds > c.photos.count)
        a.n_folds = (int)c.photos.count;
    printf("%zu photographs of %d x %d, %zu triangles, %d folds\n", c.photos.count, c.photos.cam.width_px,
           c.photos.cam.height_px, c.mesh.n_triangles, a.n_folds);
    for (int fold = 0; fold < a.n_folds; fold++)
        run_fold(&all, &c, &a, fold);
    char *table = sheen_evaluation_table(&all);
    printf("%s", table ? table : "");
    free(table);
    sheen_evaluation_release(&all);
    sheen_photos_release(&c.photos);
    sheen_mesh_release(&c.mesh);
    return 0;
}
