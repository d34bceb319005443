// SPDX-License-Identifier: Apache-2.0
// bench_align.c - poses 1 to 2 px off, over many scenes: what is left of the error.
//
//     bench_align [SEEDS] [SIZE]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fit/align.h"
#include "tests/fit/exact_scene.h"
#include "tests/support.h"

static double rms_px(const exact_scene *s)
{
    double sum = 0;
    for (size_t i = 0; i < s->inputs.count; i++)
        sum += pow(exact_pose_error_px(s, s->inputs.photos[i].rt_cam_obj, s->rt_cam_obj[i]), 2);
    return sqrt(sum / (double)s->inputs.count);
}

int main(int argc, char **argv)
{
    const int seeds = argc > 1 ? atoi(argv[1]) : 20;
    double worst = 0;
    printf("%4s %8s %8s\n", "seed", "before", "after px");
    for (int seed = 1; seed <= seeds; seed++) {
        exact_options o;
        exact_scene s;
        sheen_align_result r;
        sheen_scene *scene;
        sheen_err err;
        exact_scene_options(&o, "pose-1.5", (uint64_t)(100 + seed));
        o.pose_px = 1 + (seed % 5) * 0.25; // 1 to 2
        o.size = argc > 2 ? atof(argv[2]) : 0.5;
        o.n_tests = 1;
        exact_scene_make(&s, &o);
        const double before = rms_px(&s);
        const sheen_align_options ao = {.poses = 1, .texels_per_edge = 3};
        assert_ok(sheen_scene_new(&scene, &s.mesh, &err), err);
        assert_ok(sheen_align_photos(&r, &s.inputs, &s.mesh, scene, &ao, &err), err);
        const double after = rms_px(&s);
        worst = fmax(worst, after);
        printf("%4d %8.2f %8.3f\n", seed, before, after);
        fflush(stdout);
        sheen_align_result_release(&r);
        sheen_scene_free(&scene);
        exact_scene_release(&s);
    }
    printf("worst of %d: %.3f px\n", seeds, worst);
    return 0;
}
