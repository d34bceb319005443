// SPDX-License-Identifier: Apache-2.0
// bench_certainty.c - predicted standard deviations against true errors, over exact scenes and seeds.
//
//     bench_certainty [--seeds FIRST-LAST] [--size SHARE] [SCENE...]
//
// A row a scene: how many lamps were told from a true light within three degrees; then for log sigma, log strength and direction (an
// axis) of the lamps the root mean square of the true errors, that of the predicted deviations, and the median of |error| / deviation over
// 0.6745, which is 1 where deviations are what they say. A single wrong lamp does not move a median; the last column is the share beyond three
// deviations.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"
#include "base/order.h"
#include "base/vec.h"
#include "fit/certainty.h"
#include "fit/method.h"
#include "tests/fit/exact_scene.h"
#include "tests/support.h"

enum { MOST = 4000 };

typedef struct errors {
    double error[MOST], deviation[MOST];
    size_t n;
} errors;

static void note(errors *e, double error, double deviation)
{
    if (e->n == MOST || !(deviation > 0))
        return;
    e->error[e->n] = error;
    e->deviation[e->n++] = deviation;
}

static void print_errors(errors *e)
{
    double error2 = 0, deviation2 = 0, ratio[MOST];
    size_t beyond = 0;
    for (size_t i = 0; i < e->n; i++) {
        error2 += e->error[i] * e->error[i];
        deviation2 += e->deviation[i] * e->deviation[i];
        ratio[i] = fabs(e->error[i]) / e->deviation[i];
        beyond += ratio[i] > 3;
    }
    if (!e->n)
        return;
    qsort(ratio, e->n, sizeof *ratio, sheen_ascending);
    const double n = (double)e->n;
    printf("| %.2g, %.2g, %.2f, %.0f %% ", sqrt(error2 / n), sqrt(deviation2 / n), ratio[e->n / 2] / 0.6745,
           100 * (double)beyond / n);
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// Each true light against the lamp nearest to it.
static int compare_lamps(errors *strength, errors *direction, const exact_scene *s, const sheen_model *m,
                         const sheen_certainty *c)
{
    int n_found = 0;
    for (int i = 0; i < EXACT_LIGHTS; i++) {
        const exact_light *t = &s->lights[i];
        // Lamps are stated from the model's origin
        double v_world[3];
        for (int k = 0; k < 3; k++)
            v_world[k] = t->v_world[k] - m->lamp_origin_world[k] / t->distance_m;
        const double length = sheen_normalize(v_world);
        const sheen_lamp_certainty *best = NULL;
        for (size_t k = 0; k < c->n_lamps; k++)
            if (!best || sheen_dot(c->lamps[k].v_world, v_world) > sheen_dot(best->v_world, v_world))
                best = &c->lamps[k];
        double across[3];
        if (!best || sheen_dot(best->v_world, v_world) < cos(0.0524))
            continue;
        sheen_cross(across, best->v_world, v_world);
        note(strength, log(best->strength * length * length / luminance(t->rgb)), best->strength_share);
        note(direction, sheen_norm(across) / sqrt(2), best->direction_rad);
        n_found++;
    }
    return n_found;
}

static void run(const char *name, int first, int last, double size)
{
    static errors sigma, strength, direction;
    sigma.n = strength.n = direction.n = 0;
    int n_found = 0;
    for (int seed = first; seed <= last; seed++) {
        exact_options o;
        exact_scene s;
        sheen_paper_fit f;
        sheen_certainty c;
        sheen_err err;
        assert_true(exact_scene_options(&o, name, (uint64_t)seed));
        o.size = size;
        o.n_tests = 1;
        exact_scene_make(&s, &o);
        const sheen_paper_options po = {0};
        assert_ok(sheen_fit_make(&f, SHEEN_FIT_REFINED, SHEEN_MOVING_CAMERA, &s.mesh, &s.inputs, &po, &err),
                  err);
        assert_ok(sheen_certainty_find(&c, &f, &s.mesh, &s.inputs, SHEEN_MOVING_CAMERA, &err), err);
        if (o.sigma_rad > 0 && !(o.ggx_alpha > 0))
            note(&sigma, log(f.model.sigma_rad / o.sigma_rad), c.sigma_share);
        n_found += compare_lamps(&strength, &direction, &s, &f.model, &c);
        sheen_certainty_release(&c);
        sheen_paper_fit_release(&f);
        exact_scene_release(&s);
    }
    printf("| %s | %d of %d ", name, n_found, EXACT_LIGHTS * (last - first + 1));
    print_errors(&sigma);
    print_errors(&strength);
    print_errors(&direction);
    printf("|\n");
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const char *const standard[] = {"far", "near", "discs", "noise", "sigma-.1", "coloured"};
    int first = 1, last = 4, n = 0;
    double size = 0.35;
    printf(
        "| scene | lamps | log sigma: error, predicted, ratio, beyond 3 | log strength | direction, rad |\n");
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--seeds") && i + 1 < argc) {
            if (sscanf(argv[++i], "%d-%d", &first, &last) < 2)
                last = first;
        } else if (!strcmp(argv[i], "--size") && i + 1 < argc) {
            size = atof(argv[++i]);
        } else {
            run(argv[i], first, last, size);
            n++;
        }
    }
    for (size_t i = 0; i < sizeof standard / sizeof *standard && !n; i++)
        run(standard[i], first, last, size);
    return 0;
}
