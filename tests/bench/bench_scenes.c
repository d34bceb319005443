// SPDX-License-Identifier: Apache-2.0
// bench_scenes.c - every method on exact scenes, a row each: what is recovered, and how well held-out views are predicted.
//
//     bench_scenes [--method NAME] [--seeds FIRST-LAST] [--size SHARE] [--but WHAT,...] [--without NAME,...]
//                  [--brightness FACTOR] [--ablation] [--lamps] [--views N] [--turned HEIGHTS] [--relief MM] [--pictures DIR] [SCENE...]
//
// --but takes a difficulty out of the scenes: near, discs, coloured, ggx, k_s-map, pose, normals. --without leaves extensions
// (fit/extensions.h) out of the refined method; --ablation adds a row without each of them in turn. --brightness: of the lamps, 1 unless the scene has its own. --lamps lists the lamps
// found, each beside the true light nearest to it. --views asks for so many photographs to fit instead of 8; with --turned
// they are of an object that turns under its lights, seen by a camera at so many heights, one after the other. --relief: the shortest waves of embossed, instead of 3 mm.
//
// Columns: sigma's error; lights found of six; worst direction (minutes of arc), distance and strength of those; PSNR of the
// specular layer (linear) and of a black one; PSNR of the composite (sRGB), of the model's diffuse layer under the true
// specular one, and of the model's specular layer over the true diffuse one. Processor seconds of the fit end the row.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/image.h"
#include "base/image_file.h"
#include "base/vec.h"
#include "fit/method.h"
#include "tests/fit/exact_score.h"
#include "tests/support.h"

typedef struct arguments {
    const char *method, *pictures, *but;
    sheen_extensions without;
    int ablation, print_lamps, first, last;
    double size, brightness, relief_mm;
    int n_inputs, n_heights; // 0: as the scene has them
} arguments;

static double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void save(const arguments *a, const char *name, const sheen_image *image)
{
    char path[600];
    sheen_err err;
    snprintf(path, sizeof path, "%s/%s.png", a->pictures, name);
    assert_ok(sheen_png_write_srgb(path, image, &err), err);
}

// Root mean square over the photographs.
static double pose_error_px(const exact_scene *s, const sheen_photos *inputs)
{
    double sum = 0;
    for (size_t i = 0; i < inputs->count; i++)
        sum += pow(exact_pose_error_px(s, inputs->photos[i].rt_cam_obj, s->rt_cam_obj[i]), 2);
    return sqrt(sum / (double)inputs->count);
}

// The worst of all channels.
static double exposure_error_ev(const exact_scene *s, const sheen_align_result *align)
{
    double worst = 0;
    for (size_t i = 0; i < s->inputs.count; i++)
        for (int c = 0; c < 3; c++) {
            const double gain = align->views ? align->views[i].gain[c] : 1;
            worst = fmax(worst, fabs(log2(gain / s->gain[i][c])));
        }
    return worst;
}

static double degrees_between(const float a[3], const double b[3])
{
    const double x[3] = {(double)a[0], (double)a[1], (double)a[2]};
    double across[3];
    sheen_cross(across, x, b);
    return atan2(sheen_norm(across), sheen_dot(x, b)) * 180 / 3.14159265358979;
}

// Each lamp of the model beside the true light nearest to its direction (the middle of these scenes' objects is the lamps' origin).
static void print_lamps(const exact_scene *s, const sheen_model *m)
{
    for (size_t i = 0; i < m->n_lamps; i++) {
        const sheen_lamp *l = &m->lamps[i];
        int k = 0;
        for (int t = 1; t < EXACT_LIGHTS; t++)
            if (degrees_between(l->direction_world, s->lights[t].v_world) <
                degrees_between(l->direction_world, s->lights[k].v_world))
                k = t;
        printf(
            "%40s lamp %2zu: Y %.4f, %5.2f degrees wide, %.2f per m; %6.2f degrees from light %d of Y %.4f\n",
            "", i, (double)sheen_luminance(l->rgb), (double)l->radius_rad * 57.29578,
            (double)l->inverse_distance_per_m, degrees_between(l->direction_world, s->lights[k].v_world), k,
            0.2126 * s->lights[k].rgb[0] + 0.7152 * s->lights[k].rgb[1] + 0.0722 * s->lights[k].rgb[2]);
    }
}

static void fit_scene(const exact_scene *s, const char *label, sheen_fit_method method, const arguments *a,
                      sheen_extensions without)
{
    sheen_paper_fit f;
    sheen_err err;
    exact_score score;
    const sheen_paper_options o = {.without = without};
    // A method may correct poses: not in the scene itself
    sheen_photos inputs = s->inputs;
    inputs.photos = malloc(s->inputs.count * sizeof *inputs.photos);
    assert_non_null(inputs.photos);
    memcpy(inputs.photos, s->inputs.photos, inputs.count * sizeof *inputs.photos);
    const double start_s = cpu_s();
    const sheen_status status = sheen_fit_make(
        &f, method, s->o.n_heights ? SHEEN_MOVING_OBJECT : SHEEN_MOVING_CAMERA, &s->mesh, &inputs, &o, &err);
    if (status) {
        printf("%-22s %-9s %s\n", label, sheen_fit_method_name(method), err.msg);
        free(inputs.photos);
        return;
    }
    const double fit_s = cpu_s() - start_s;
    exact_score_model(&score, s, &f.model);
    exact_score_print(stdout, label, sheen_fit_method_name(method), &score);
    printf("%40s poses off by %.2f px, exposures by %.3f EV; %.1f %% clipped; %zu lights, %d glosses, %.1f "
           "CPU s\n",
           "", pose_error_px(s, &inputs), exposure_error_ev(s, &f.align), 100 * s->clipped_share,
           f.model.lights.count + f.model.n_lamps, f.model.gloss.n, fit_s);
    if (a->print_lamps)
        print_lamps(s, &f.model);
    free(inputs.photos);
    sheen_paper_fit_release(&f);
}

static int has_word(const char *list, const char *word)
{
    const size_t length = strlen(word);
    for (const char *at = list; at && *at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (strcspn(at, ",") == length && !strncmp(at, word, length))
            return 1;
    return 0;
}

static void ease(exact_options *o, const char *but)
{
    o->is_near = o->is_near && !has_word(but, "near");
    o->coloured = o->coloured && !has_word(but, "coloured");
    o->k_s_map = o->k_s_map && !has_word(but, "k_s-map");
    o->disc_deg = has_word(but, "discs") ? 0 : o->disc_deg;
    o->ggx_alpha = has_word(but, "ggx") ? 0 : o->ggx_alpha;
    o->pose_px = has_word(but, "pose") ? 0 : o->pose_px;
    o->normals_deg = has_word(but, "normals") ? 0 : o->normals_deg;
}

static void run_scene(const arguments *a, const char *name, int seed)
{
    exact_options o;
    exact_scene s;
    char label[80];
    if (!exact_scene_options(&o, name, (uint64_t)seed)) {
        printf("no scene '%s'\n", name);
        exit(2);
    }
    o.size = a->size;
    if (a->brightness > 0)
        o.brightness = a->brightness;
    o.relief_m = 1e-3 * a->relief_mm;
    o.n_inputs = (size_t)a->n_inputs;
    o.n_heights = (size_t)a->n_heights;
    ease(&o, a->but);
    snprintf(label, sizeof label, "%s %d", name, seed);
    exact_scene_make(&s, &o);
    if (a->pictures)
        save(a, label, &s.inputs.photos[0].image);
    for (int m = 0; m < SHEEN_FIT_METHOD_COUNT; m++)
        if (!a->method || !strcmp(a->method, sheen_fit_method_name((sheen_fit_method)m)))
            fit_scene(&s, label, (sheen_fit_method)m, a, a->without);
    for (int e = 0; a->ablation && e < SHEEN_EXTENSION_COUNT; e++) {
        snprintf(label, sizeof label, "%s %d -%s", name, seed, sheen_extension_name((sheen_extension)e));
        fit_scene(&s, label, SHEEN_FIT_REFINED, a, a->without | 1u << e);
    }
    exact_scene_release(&s);
}

int main(int argc, char **argv)
{
    arguments a = {.first = 1, .last = 1, .size = 1};
    const char *chosen[64];
    int n_chosen = 0;
    sheen_err err;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--method") && i + 1 < argc)
            a.method = argv[++i];
        else if (!strcmp(argv[i], "--without") && i + 1 < argc)
            assert_ok(sheen_extensions_parse(&a.without, argv[++i], &err), err);
        else if (!strcmp(argv[i], "--ablation"))
            a.ablation = 1;
        else if (!strcmp(argv[i], "--lamps"))
            a.print_lamps = 1;
        else if (!strcmp(argv[i], "--but") && i + 1 < argc)
            a.but = argv[++i];
        else if (!strcmp(argv[i], "--pictures") && i + 1 < argc)
            a.pictures = argv[++i];
        else if (!strcmp(argv[i], "--size") && i + 1 < argc)
            a.size = strtod(argv[++i], NULL);
        else if (!strcmp(argv[i], "--brightness") && i + 1 < argc)
            a.brightness = strtod(argv[++i], NULL);
        else if (!strcmp(argv[i], "--relief") && i + 1 < argc)
            a.relief_mm = strtod(argv[++i], NULL);
        else if (!strcmp(argv[i], "--views") && i + 1 < argc)
            a.n_inputs = (int)strtol(argv[++i], NULL, 10);
        else if (!strcmp(argv[i], "--turned") && i + 1 < argc)
            a.n_heights = (int)strtol(argv[++i], NULL, 10);
        else if (!strcmp(argv[i], "--seeds") && i + 1 < argc) {
            char *end;
            a.first = a.last = (int)strtol(argv[++i], &end, 10);
            if (*end == '-')
                a.last = (int)strtol(end + 1, NULL, 10);
        } else if (n_chosen < 64)
            chosen[n_chosen++] = argv[i];
    }
    if (!n_chosen)
        while (exact_scene_names[n_chosen]) {
            chosen[n_chosen] = exact_scene_names[n_chosen];
            n_chosen++;
        }
    exact_score_print_heading(stdout);
    for (int i = 0; i < n_chosen; i++)
        for (int seed = a.first; seed <= a.last; seed++)
            run_scene(&a, chosen[i], seed);
    return 0;
}
