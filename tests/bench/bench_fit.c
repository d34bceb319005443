// SPDX-License-Identifier: Apache-2.0
// bench_fit.c - what a fit costs: wall and processor seconds and the most memory, from decoded photographs to the model.
//
//     bench_fit [--method NAME] [PHOTOGRAPHS:MEGAPIXELS:SPLITS[:THREADS]]...
//
// Photographs of the exact scene "far" (tests/fit/exact_scene.h); its mesh of 18,000 triangles is split SPLITS times into four,
// so that its shape stays. Without a size: eight of two megapixels and 72,000 triangles; twice as many; three hundred small ones; a
// million triangles. Memory is what the process took at most during the fit beyond what it held before it, plus the photographs.
// "texture" is section 3.2 alone.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/method.h"
#include "tests/fit/exact_score.h"
#include "tests/support.h"

typedef struct size {
    int n_photos, n_splits, n_threads;
    double megapixels;
} size;

// A line of /proc/self/status, in MB; 0 where the system has none.
static double status_mb(const char *name)
{
    char line[200];
    double kb = 0;
    FILE *f = fopen("/proc/self/status", "r");
    while (f && fgets(line, sizeof line, f))
        if (!strncmp(line, name, strlen(name)))
            kb = strtod(line + strlen(name) + 1, NULL);
    if (f)
        fclose(f);
    return kb / 1024;
}

// From here on VmHWM counts anew.
static void forget_peak(void)
{
    FILE *f = fopen("/proc/self/clear_refs", "w");
    if (!f)
        return;
    fputs("5", f);
    fclose(f);
}

// Open addressing over an edge's two corners; the middle that it has, or a new one.
static uint32_t middle(sheen_mesh *m, uint32_t *table, size_t capacity, uint32_t a, uint32_t b)
{
    const uint64_t low = a < b ? a : b, high = a < b ? b : a;
    size_t at = (size_t)((low * 0x9E3779B97F4A7C15u + high * 0xC2B2AE3D27D4EB4Fu) >> 20) % capacity;
    for (; table[3 * at]; at = (at + 1) % capacity)
        if (table[3 * at] == low + 1 && table[3 * at + 1] == high)
            return table[3 * at + 2];
    const uint32_t v = (uint32_t)m->n_vertices++;
    table[3 * at] = (uint32_t)low + 1;
    table[3 * at + 1] = (uint32_t)high;
    table[3 * at + 2] = v;
    double n[3];
    for (int k = 0; k < 3; k++) {
        m->p_obj[3 * v + (uint32_t)k] = 0.5f *
                                        (m->p_obj[3 * a + (uint32_t)k] + m->p_obj[3 * b + (uint32_t)k]);
        n[k] = (double)m->n_obj[3 * a + (uint32_t)k] + (double)m->n_obj[3 * b + (uint32_t)k];
    }
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++)
        m->n_obj[3 * v + (uint32_t)k] = (float)(n[k] / length);
    return v;
}

static void split(sheen_mesh *m)
{
    const size_t n = m->n_triangles, most = m->n_vertices + 3 * n, capacity = 4 * n;
    uint32_t *table = calloc(3 * capacity, sizeof *table), *out = malloc(12 * n * sizeof *out);
    m->p_obj = realloc(m->p_obj, 3 * most * sizeof *m->p_obj);
    m->n_obj = realloc(m->n_obj, 3 * most * sizeof *m->n_obj);
    assert_true(table && out && m->p_obj && m->n_obj);
    for (size_t t = 0; t < n; t++) {
        const uint32_t *c = m->triangles + 3 * t;
        const uint32_t x = middle(m, table, capacity, c[0], c[1]), y = middle(m, table, capacity, c[1], c[2]),
                       z = middle(m, table, capacity, c[2], c[0]);
        const uint32_t four[12] = {c[0], x, z, x, c[1], y, z, y, c[2], x, y, z};
        memcpy(out + 12 * t, four, sizeof four);
    }
    free(m->triangles);
    free(table);
    m->triangles = out;
    m->n_triangles = 4 * n;
}

static double photos_mb(const sheen_photos *p)
{
    double bytes = 0;
    for (size_t i = 0; i < p->count; i++)
        bytes += 12.0 * p->photos[i].image.width_px * p->photos[i].image.height_px;
    return bytes / 1048576;
}

static void say_step(void *self, const char *what, double wall_s, double cpu_s)
{
    (void)self;
    printf("    %-28s %7.2f s %8.2f CPU s   so far %5.0f MB\n", what, wall_s, cpu_s, status_mb("VmHWM"));
    fflush(stdout);
}

static void measure(const exact_scene *s, const size *z, const char *name, sheen_fit_method method,
                    sheen_paper_stop stop)
{
    sheen_paper_fit f;
    sheen_err err;
    sheen_photos inputs = s->inputs; // a method may correct poses: not in the scene itself
    inputs.photos = malloc(inputs.count * sizeof *inputs.photos);
    assert_non_null(inputs.photos);
    memcpy(inputs.photos, s->inputs.photos, inputs.count * sizeof *inputs.photos);
    const sheen_paper_options o = {
        .stop_after = stop, .n_threads = z->n_threads, .progress = {.timed = say_step}};
    forget_peak();
    const double before_mb = status_mb("VmRSS");
    const sheen_stopwatch start = sheen_stopwatch_now();
    const sheen_status status = sheen_fit_make(&f, method, SHEEN_MOVING_CAMERA, &s->mesh, &inputs, &o, &err);
    const sheen_stopwatch end = sheen_stopwatch_now();
    const double taken_mb = status_mb("VmHWM") - before_mb + photos_mb(&inputs);
    if (status)
        printf("  %-8s %s\n", name, err.msg);
    else
        printf("  %-8s %7.2f s %8.2f CPU s %6.0f MB   sigma %+.1f %%, %zu lights, %.2f M texels\n", name,
               end.wall_s - start.wall_s, end.cpu_s - start.cpu_s, taken_mb,
               100 * (f.model.sigma_rad / s->o.sigma_rad - 1), f.model.lights.count + f.model.n_lamps,
               1e-6 * (double)(f.model.texture.n_triangles *
                               sheen_texels_per_triangle(f.model.texture.texels_per_edge)));
    fflush(stdout);
    free(inputs.photos);
    if (!status)
        sheen_paper_fit_release(&f);
}

static void run(const size *z, sheen_fit_method method)
{
    exact_options o;
    exact_scene s;
    if (!exact_scene_options(&o, "far", 1))
        return;
    o.size = sqrt(z->megapixels / 1.2288);
    o.n_inputs = (size_t)z->n_photos;
    o.n_tests = 1;
    exact_scene_make(&s, &o);
    for (int i = 0; i < z->n_splits; i++)
        split(&s.mesh);
    printf("%d photographs of %.2f megapixels, %zu triangles, threads %d\n", z->n_photos, z->megapixels,
           s.mesh.n_triangles, z->n_threads);
    measure(&s, z, "texture", SHEEN_FIT_PAPER, SHEEN_PAPER_TEXTURE);
    measure(&s, z, sheen_fit_method_name(method), method, SHEEN_PAPER_ALL);
    exact_scene_release(&s);
}

int main(int argc, char **argv)
{
    static const size standard[] = {{8, 1, 0, 2}, {16, 1, 0, 2}, {300, 0, 0, 0.08}, {8, 3, 0, 0.5}};
    sheen_fit_method method = SHEEN_FIT_REFINED;
    int n = 0;
    for (int i = 1; i < argc; i++) {
        sheen_err err;
        if (!strcmp(argv[i], "--method") && i + 1 < argc) {
            assert_ok(sheen_fit_method_from_name(&method, argv[++i], &err), err);
            continue;
        }
        size z = {0};
        if (sscanf(argv[i], "%d:%lf:%d:%d", &z.n_photos, &z.megapixels, &z.n_splits, &z.n_threads) < 3) {
            fprintf(stderr, "'%s' is no PHOTOGRAPHS:MEGAPIXELS:SPLITS\n", argv[i]);
            return 2;
        }
        run(&z, method);
        n++;
    }
    for (size_t i = 0; i < sizeof standard / sizeof *standard && !n; i++)
        run(&standard[i], method);
    return 0;
}
