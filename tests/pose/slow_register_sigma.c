// SPDX-License-Identifier: Apache-2.0
// Is a registration as good as it says? slow_register_sigma [SCENES [WIDTH [KIND]]]: several objects, several faults of the
// masks, scenes with seeds of their own; errors of the vertex that is furthest off, against what was said of it.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/pose3.h"
#include "mask_scene.h"
#include "support.h"

enum { ALL_KINDS = 9 };

static const double DEG = 3.14159265358979323846 / 180;

typedef struct condition {
    const char *name;
    double mask_noise_px;
    int fault; // -1: none
    size_t n_views;
    bool fit_scale;
} condition;

static const condition conditions[ALL_KINDS] = {
    {"exact", 0, -1, 8, false},
    {"wandering by 0.7 px", 0.7, -1, 8, false},
    {"wider by a pixel", 0, MASK_SCENE_WIDER, 8, false},
    {"a piece missing", 0.3, MASK_SCENE_BITTEN, 8, false},
    {"a shadow added", 0.3, MASK_SCENE_SHADOW, 8, false},
    {"wandering, 5 frames", 0.7, -1, 5, false},
    {"wandering, 3 frames", 0.7, -1, 3, false},
    {"wandering, size fitted", 0.7, -1, 8, true},
    {"wider, size fitted", 0, MASK_SCENE_WIDER, 8, true},
};

typedef struct sums {
    double error_mm2, said_mm2, error_deg2, said_deg2, scaled;
    int n;
} sums;

static void one(sums *t, const sheen_mesh *mesh, const condition *c, int width_px, uint64_t seed)
{
    sheen_err err;
    mask_scene scene;
    sheen_registration r;
    mask_scene_make(&scene, mesh,
                    &(mask_scene_options){.width_px = width_px,
                                          .height_px = width_px * 3 / 4,
                                          .n_views = c->n_views,
                                          .distance_m = 0.45,
                                          .pose_noise = 1,
                                          .mask_noise_px = c->mask_noise_px,
                                          .seed = seed});
    if (c->fault >= 0)
        mask_scene_spoil(&scene, (mask_scene_fault)c->fault, &seed);
    sheen_placement start = {.scale = 1};
    sheen_Rt_from_rt(&start.Rt_board_obj, (const double[6]){0, 0, 0.01, 0.0005, 0.0005, 0});
    const sheen_register_options o = {.unit_m = 1, .fit_scale = c->fit_scale};
    assert_ok(sheen_register_refine(&r, mesh, &scene.camera, scene.views, scene.n_views, &start, &o, &err),
              err);
    double m, rad;
    mask_scene_error(&m, &rad, &r.placement, (const double[6]){0}, 1, mesh);
    t->error_mm2 += 1e6 * m * m;
    t->said_mm2 += 1e6 * r.sigma_m * r.sigma_m;
    t->error_deg2 += rad * rad / DEG / DEG;
    t->said_deg2 += r.sigma_rad * r.sigma_rad / DEG / DEG;
    t->scaled += m * m / (r.sigma_m * r.sigma_m);
    t->n++;
    if (getenv("SHEEN_TEST_VERBOSE"))
        printf("  %.3f mm (said %.3f) %.3f deg (said %.3f) rms %.2f px offset %.2f px scale %.5f\n", 1e3 * m,
               1e3 * r.sigma_m, rad / DEG, r.sigma_rad / DEG, r.misfit.rms_px, r.misfit.offset_px,
               r.placement.scale);
    mask_scene_release(&scene);
}

int main(int argc, char **argv)
{
    const int n = argc > 1 ? atoi(argv[1]) : 6, width_px = argc > 2 ? atoi(argv[2]) : 640,
              only = argc > 3 ? atoi(argv[3]) : -1;
    static void (*const shapes[])(sheen_mesh *) = {mask_scene_figure, mask_scene_block};
    static const char *const names[] = {"figure", "block", "sample's mesh"};
    sheen_err err;
    int failures = 0;
    printf("object          masks                    error mm (said)   degrees (said)   error / said   "
           "scaled rms\n");
    for (int k = 0; k < ALL_KINDS; k++) {
        sums all = {0};
        if (only >= 0 && k != only)
            continue;
        for (int m = 0; m < 3; m++) {
            sheen_mesh mesh;
            sums t = {0};
            if (m < 2)
                shapes[m](&mesh);
            else
                assert_ok(sheen_mesh_load(&mesh, SHEEN_TEST_DATA "/penguin/mesh.ply", &err), err);
            for (int i = 0; i < n; i++)
                one(&t, &mesh, &conditions[k], width_px, 1000 * (uint64_t)(10 * k + m) + (uint64_t)i);
            printf("%-15s %-24s %.3f (%.3f)     %.3f (%.3f)    %.2f   %.2f\n", names[m], conditions[k].name,
                   sqrt(t.error_mm2 / n), sqrt(t.said_mm2 / n), sqrt(t.error_deg2 / n), sqrt(t.said_deg2 / n),
                   sqrt(t.error_mm2 / t.said_mm2), sqrt(t.scaled / n));
            fflush(stdout);
            all.error_mm2 += t.error_mm2 / t.said_mm2;
            sheen_mesh_release(&mesh);
        }
        const double ratio = sqrt(all.error_mm2 / 3);
        failures += !(ratio > 0.7 && ratio < 1.4);
    }
    return failures > 0;
}
