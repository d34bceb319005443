// SPDX-License-Identifier: Apache-2.0
// Registration from random starts: slow_register [STARTS [MESH.ply...]]. For each mesh, masks are rendered from eight
// sides; then the mesh is turned, moved and stated in another unit at random, and has to be found again. Right is
// within 0.3 mm and 0.3 degrees; what is wrong must have been called uncertain. The
// bottle, which has a place for every turn, gets a fifth of the starts.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/progress.h"
#include "mask_scene.h"
#include "support.h"

enum { STARTS_A_SCENE = 25 }; // errors of poses and masks are drawn anew

static const double DEG = 3.14159265358979323846 / 180;

typedef struct tally {
    int right, unsure, wrong;
    double sum_mm2, sum_deg2, sum_predicted_mm2, worst_mm, worst_deg, cpu_s;
} tally;

static sheen_mesh centred(const sheen_mesh *mesh)
{
    sheen_mesh out;
    float low[3], high[3], size = 0;
    sheen_mesh_bounds(mesh, low, high);
    for (int c = 0; c < 3; c++)
        size = fmaxf(size, high[c] - low[c]);
    mask_scene_move(&out, mesh,
                    (const double[6]){0, 0, 0, 0.5 * (double)(low[0] + high[0]),
                                      0.5 * (double)(low[1] + high[1]), (double)low[2]},
                    (double)size / 0.12);
    return out;
}

static void one(tally *t, const mask_scene *scene, const sheen_mesh *mesh, uint64_t *seed, bool sized)
{
    static const double units[] = {1, 1e-3, 1e-2, 0.0254};
    sheen_err err;
    sheen_mesh moved;
    sheen_registration r;
    double yaw[6] = {0, 0, 360 * DEG * test_random(seed), 0, 0, 0}, rt[6], mm, deg;
    const double unit_m = sized ? 1 : units[(int)(4 * test_random(seed))];
    for (int k = 3; k < 6; k++)
        yaw[k] = 0.1 * (test_random(seed) - 0.5);
    // the file's up axis is any of the six, too
    static const double ups[6][3] = {{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {2, 0, 0}};
    const double *up = ups[(int)(6 * test_random(seed))];
    double turned[6] = {90 * DEG * up[0], 90 * DEG * up[1], 90 * DEG * up[2], 0, 0, 0};
    sheen_rt_compose(rt, yaw, turned);
    mask_scene_move(&moved, mesh, rt, unit_m);
    const sheen_register_options o = {.unit_m = sized ? 1 : 0};
    const sheen_stopwatch since = sheen_stopwatch_now();
    assert_ok(sheen_register_search(&r, &moved, &scene->camera, scene->views, scene->n_views, &o, &err), err);
    t->cpu_s += sheen_stopwatch_now().cpu_s - since.cpu_s;
    mask_scene_error(&mm, &deg, &r.placement, rt, unit_m, mesh);
    mm *= 1e3;
    deg /= DEG;
    const bool right = mm < 0.3 && deg < 0.3;
    t->right += right && r.state == SHEEN_REGISTER_SURE;
    t->unsure += r.state != SHEEN_REGISTER_SURE;
    t->wrong += !right && r.state == SHEEN_REGISTER_SURE;
    if (getenv("SHEEN_TEST_VERBOSE"))
        printf("  %.3f mm %.3f deg state %d border %.3f second %.3f found %.2f overlap %.3f unit %g scale %g "
               "rms %.3f "
               "sigma %.3f mm %.3f deg: %s\n",
               mm, deg, r.state, r.misfit.border_px, r.second_border_px, r.misfit.found, r.misfit.overlap,
               r.unit_m, r.placement.scale, r.misfit.rms_px, 1e3 * r.sigma_m, r.sigma_rad / DEG, r.reason);
    if (right) {
        t->sum_mm2 += mm * mm;
        t->sum_deg2 += deg * deg;
        t->sum_predicted_mm2 += 1e6 * r.sigma_m * r.sigma_m;
        t->worst_mm = fmax(t->worst_mm, mm);
        t->worst_deg = fmax(t->worst_deg, deg);
    }
    sheen_mesh_release(&moved);
}

static tally many(const char *name, const sheen_mesh *mesh, int n, double noise_px, bool sized, uint64_t seed)
{
    tally t = {0};
    mask_scene scene = {0};
    for (int i = 0; i < n; i++) {
        if (i % STARTS_A_SCENE == 0) {
            mask_scene_release(&scene);
            mask_scene_make(&scene, mesh,
                            &(mask_scene_options){.width_px = 1280,
                                                  .height_px = 960,
                                                  .n_views = 8,
                                                  .distance_m = 0.45,
                                                  .pose_noise = 1,
                                                  .mask_noise_px = noise_px,
                                                  .seed = seed});
        }
        one(&t, &scene, mesh, &seed, sized);
    }
    mask_scene_release(&scene);
    const double k = fmax(1, t.right);
    printf("%-12s masks +- %.1f px, unit %-7s: %3d of %d right, %d said to be uncertain, %d wrong; rms %.3f "
           "mm (said: "
           "%.3f) %.3f deg, worst %.3f mm %.3f deg; %.1f s CPU each\n",
           name, noise_px, sized ? "known" : "unknown", t.right, n, t.unsure, t.wrong, sqrt(t.sum_mm2 / k),
           sqrt(t.sum_predicted_mm2 / k), sqrt(t.sum_deg2 / k), t.worst_mm, t.worst_deg, t.cpu_s / n);
    fflush(stdout);
    return t;
}

int main(int argc, char **argv)
{
    const int n = argc > 1 ? atoi(argv[1]) : 3;
    sheen_err err;
    int failures = 0, all = 0, right = 0;
    const char *const usual[] = {SHEEN_TEST_DATA "/penguin/mesh.ply"};
    const char *const *paths = argc > 2 ? (const char *const *)argv + 2 : usual;
    const int n_paths = argc > 2 ? argc - 2 : 1;
    for (int m = -2; m < n_paths; m++) {
        sheen_mesh mesh, own;
        if (m == -2)
            mask_scene_bottle(&own);
        else if (m == -1)
            mask_scene_figure(&own);
        else
            assert_ok(sheen_mesh_load(&own, paths[m], &err), err);
        const char *slash = m < 0 ? NULL : strrchr(paths[m], '/');
        mesh = centred(&own);
        const int n_here = m == -2 ? (n + 4) / 5 : n;
        for (int noise = 0; noise < 2; noise++) {
            const tally t = many(m == -2   ? "bottle"
                                 : m == -1 ? "figure"
                                 : slash   ? slash + 1
                                           : paths[m],
                                 &mesh, n_here, noise ? 0.7 : 0, noise, 7 + (uint64_t)(m + 2));
            if (m == -2)
                failures += t.unsure < n_here;
            else {
                failures += t.wrong;
                all += n;
                right += t.right;
            }
        }
        sheen_mesh_release(&mesh);
        sheen_mesh_release(&own);
    }
    printf("%d of %d right\n", right, all);
    return failures || 100 * right < 95 * all;
}
