// SPDX-License-Identifier: Apache-2.0
// model_gloss.c - the member "gloss" of model.json: colours of texture and how strongly they shine.
#include <math.h>

#include "render/model_private.h"

sheen_status sheen_model_check_gloss(const sheen_gloss *g, sheen_status code, sheen_err *err)
{
    if (g->n < 0 || g->n > SHEEN_GLOSS_MAX || (g->n && !(g->width >= 1e-3f && g->width <= 10)))
        return sheen_fail(err, code, "the gloss by colour has %d colours or a width that is out of range",
                          g->n);
    for (int i = 0; i < g->n; i++) {
        bool good = g->share[i] >= 0 && g->share[i] <= 1e4f;
        for (int c = 0; c < 3; c++)
            good = good && g->root[i][c] >= 0 && g->root[i][c] <= 1e3f;
        if (!good)
            return sheen_fail(err, code, "colour %d of the gloss by colour is out of range", i);
    }
    return SHEEN_OK;
}

void sheen_model_put_gloss(sheen_json_writer *w, const sheen_gloss *g)
{
    if (!g->n)
        return;
    sheen_json_open(w, "gloss", '{');
    sheen_json_put_number(w, "width", (double)g->width);
    sheen_json_open(w, "colours", '[');
    for (int i = 0; i < g->n; i++) {
        const double row[4] = {(double)g->root[i][0], (double)g->root[i][1], (double)g->root[i][2],
                               (double)g->share[i]};
        sheen_json_put_numbers(w, NULL, row, 4);
    }
    sheen_json_close(w);
    sheen_json_close(w);
}

sheen_status sheen_model_get_gloss(sheen_gloss *g, const sheen_json *root, sheen_err *err)
{
    const sheen_json *in = sheen_json_get(root, "gloss"), *colours;
    double width;
    sheen_status s;
    if (!in)
        return SHEEN_OK;
    if ((s = sheen_json_number(in, "width", &width, err)) ||
        (s = sheen_json_array(in, "colours", &colours, err)))
        return s;
    const size_t n = sheen_json_count(colours);
    if (n > SHEEN_GLOSS_MAX)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "%zu colours of gloss are more than the %d that a model may have", n,
                          SHEEN_GLOSS_MAX);
    for (size_t i = 0; i < n; i++) {
        const sheen_json *row = sheen_json_at(colours, i);
        float *x[4] = {&g->root[i][0], &g->root[i][1], &g->root[i][2], &g->share[i]};
        for (size_t k = 0; k < 4; k++)
            *x[k] = sheen_json_count(row) == 4
                        ? (float)sheen_json_value_number(sheen_json_at(row, k), (double)NAN)
                        : NAN;
    }
    g->width = (float)width;
    g->n = (int)n;
    return SHEEN_OK;
}
