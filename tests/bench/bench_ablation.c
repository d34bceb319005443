// SPDX-License-Identifier: Apache-2.0
// bench_ablation.c - each extension of the fit switched off in turn, on a session whose truth is known layer by layer.
//
//     bench_ablation SESSION SCENE.json TRUTH_DIR [BEGIN]
//
// BEGIN: only variants whose names begin so ("refined"). SESSION: with camera, poses, mesh and input frames. SCENE.json: the exact camera and poses. TRUTH_DIR: linear radiance of the test
// views, <view>.exr, and its parts on the object, <view>_diffuse.exr and <view>_glossy.exr. Columns: PSNR over the object (sRGB)
// and over highlights (linear, where the glossy part exceeds 0.15 of white) of the model; of the exact diffuse part under the model's
// specular one; of the model's diffuse part under the exact specular one; processor seconds of the fit.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/image_file.h"
#include "base/json.h"
#include "base/pose3.h"
#include "fit/method.h"
#include "fit/metrics.h"
#include "render/draw.h"
#include "tests/support.h"

typedef struct variant {
    const char *name;
    sheen_fit_method method;
    sheen_paper_options o;
} variant;

static const variant variants[] = {
    {"paper", SHEEN_FIT_PAPER, {0}},
    {"paper, 70 % of the views must agree", SHEEN_FIT_PAPER, {.consistency = 0.7}},
    {"paper, quartic loss", SHEEN_FIT_PAPER, {.loss = SHEEN_LOSS_QUARTIC}},
    {"refined", SHEEN_FIT_REFINED, {0}},
};

typedef struct truth {
    sheen_camera cam;
    double exposure;
    const sheen_json *views;
    const char *dir;
} truth;

typedef struct sums {
    double object[3], highlights[3]; // the model; exact diffuse; exact specular
    int n;
} sums;

static double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int load_layer(sheen_image *out, const truth *t, const char *view, const char *part)
{
    char path[700];
    sheen_raster raster;
    sheen_err err;
    snprintf(path, sizeof path, "%s/%s%s.exr", t->dir, view, part);
    if (sheen_raster_load(&raster, path, NULL))
        return 0;
    assert_ok(sheen_image_from_raster(out, &raster, SHEEN_TRANSFER_LINEAR, &err), err);
    sheen_raster_release(&raster);
    const size_t n = 3 * (size_t)out->width_px * (size_t)out->height_px;
    for (size_t i = 0; i < n; i++)
        out->data[i] *= (float)t->exposure;
    return 1;
}

static void take(sums *s, int column, const sheen_image *a, const sheen_image *b, const sheen_image *whole,
                 const uint8_t *select[2])
{
    sheen_image sum;
    sheen_err err;
    assert_ok(sheen_image_init(&sum, a->width_px, a->height_px, 3, &err), err);
    const size_t n = 3 * (size_t)a->width_px * (size_t)a->height_px;
    for (size_t i = 0; i < n; i++)
        sum.data[i] = a->data[i] + b->data[i];
    s->object[column] += sheen_psnr_of(&sum, whole, select[0]).srgb_db;
    s->highlights[column] += sheen_psnr_of(&sum, whole, select[1]).linear_db;
    sheen_image_release(&sum);
}

static void score_view(sums *s, const truth *t, const sheen_drawing *drawing, const sheen_json *view)
{
    const char *name, *role;
    sheen_Rt Rt;
    double rt[6];
    sheen_err err;
    sheen_image whole, D, S;
    sheen_layers l;
    assert_ok(sheen_json_string(view, "name", &name, &err), err);
    assert_ok(sheen_json_string(view, "role", &role, &err), err);
    if (strcmp(role, "test") != 0 || !load_layer(&whole, t, name, ""))
        return;
    assert_true(load_layer(&D, t, name, "_diffuse") && load_layer(&S, t, name, "_glossy"));
    assert_ok(sheen_json_numbers(view, "R", &Rt.R[0][0], 9, &err), err);
    assert_ok(sheen_json_numbers(view, "t", Rt.t, 3, &err), err);
    sheen_rt_from_Rt(rt, &Rt);
    assert_ok(sheen_draw(&l, drawing, &t->cam, rt, NULL, NULL, &err), err);
    const size_t n = (size_t)t->cam.width_px * (size_t)t->cam.height_px;
    uint8_t *object = calloc(n, 1), *lit = calloc(n, 1);
    assert_true(object && lit);
    for (size_t i = 0; i < n; i++) {
        object[i] = l.coverage.data[i] > 0.999f;
        lit[i] = object[i] && sheen_luminance(S.data + 3 * i) > 0.15f;
    }
    const uint8_t *select[2] = {object, lit};
    take(s, 0, &l.diffuse, &l.specular, &whole, select);
    take(s, 1, &D, &l.specular, &whole, select);
    take(s, 2, &l.diffuse, &S, &whole, select);
    s->n++;
    free(object);
    free(lit);
    sheen_layers_release(&l);
    sheen_image_release(&whole);
    sheen_image_release(&D);
    sheen_image_release(&S);
}

static void run(const truth *t, const sheen_session *session, const sheen_mesh *mesh, const variant *v)
{
    sheen_photos photos;
    sheen_paper_fit f;
    sheen_drawing *drawing;
    sheen_err err;
    sums s = {{0}, {0}, 0};
    assert_ok(sheen_photos_load(&photos, session, SHEEN_ROLE_INPUT, &v->o.progress, &err), err);
    const double from_s = cpu_s();
    assert_ok(sheen_fit_make(&f, v->method, session->moving, mesh, &photos, &v->o, &err), err);
    const double took_s = cpu_s() - from_s;
    sheen_model m = f.model;
    m.mesh = *mesh; // lent
    memcpy(m.rt_world_obj, photos.photos[0].rt_world_obj, sizeof m.rt_world_obj);
    assert_ok(sheen_drawing_new(&drawing, &m, &err), err);
    for (size_t i = 0; i < sheen_json_count(t->views); i++)
        score_view(&s, t, drawing, sheen_json_at(t->views, i));
    printf("| %-38s | %.2f / %.2f | %.2f / %.2f | %.2f / %.2f | %.1f |\n", v->name, s.object[0] / s.n,
           s.highlights[0] / s.n, s.object[1] / s.n, s.highlights[1] / s.n, s.object[2] / s.n,
           s.highlights[2] / s.n, took_s);
    fflush(stdout);
    sheen_drawing_free(&drawing);
    sheen_paper_fit_release(&f);
    sheen_photos_release(&photos);
}

static void read_camera(truth *t, const sheen_json *root)
{
    static const char *const names[4] = {"fx", "fy", "cx", "cy"};
    const sheen_json *c = sheen_json_get(root, "camera");
    double fxycxy[4], size[2];
    sheen_err err;
    for (int i = 0; i < 4; i++)
        assert_ok(sheen_json_number(c, names[i], &fxycxy[i], &err), err);
    assert_ok(sheen_json_number(c, "width", &size[0], &err), err);
    assert_ok(sheen_json_number(c, "height", &size[1], &err), err);
    assert_ok(sheen_camera_opencv(&t->cam, (int)size[0], (int)size[1], fxycxy, NULL, 0, &err), err);
    assert_ok(sheen_json_number(sheen_json_get(root, "exposure"), "main", &t->exposure, &err), err);
    t->views = sheen_json_get(root, "views");
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        printf("usage: bench_ablation SESSION SCENE.json TRUTH_DIR [BEGIN] (nothing to do without them)\n");
        return argc == 1 ? 0 : 2;
    }
    truth t = {.dir = argv[3]};
    sheen_json *root;
    sheen_session session;
    sheen_mesh mesh;
    char path[SHEEN_PATH_MAX];
    sheen_err err;
    assert_ok(sheen_session_open(&session, argv[1], &err), err);
    assert_ok(sheen_json_load(&root, argv[2], &err), err);
    read_camera(&t, root);
    assert_ok(sheen_session_path(path, &session, sheen_session_mesh_file(&session), &err), err);
    assert_ok(sheen_mesh_load(&mesh, path, &err), err);
    printf("| object sRGB / highlights linear, dB | model | exact diffuse | exact specular | CPU s "
           "|\n|---|---|---|---|---|\n");
    const char *begin = argc > 4 ? argv[4] : "";
    for (size_t i = 0; i < sizeof variants / sizeof *variants; i++)
        if (!strncmp(variants[i].name, begin, strlen(begin)))
            run(&t, &session, &mesh, &variants[i]);
    for (int i = 0; i < SHEEN_EXTENSION_COUNT; i++) {
        char name[60];
        snprintf(name, sizeof name, "refined, without %s", sheen_extension_name((sheen_extension)i));
        const variant v = {name, SHEEN_FIT_REFINED, {.without = 1u << i}};
        if (!strncmp(name, begin, strlen(begin)))
            run(&t, &session, &mesh, &v);
    }
    sheen_mesh_release(&mesh);
    sheen_json_free(&root);
    sheen_session_release(&session);
    return 0;
}
