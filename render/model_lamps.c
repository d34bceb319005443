// SPDX-License-Identifier: Apache-2.0
// model_lamps.c - the member "lamps" of model.json.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/model_private.h"

sheen_status sheen_model_set_lamps(sheen_model *m, const sheen_lamp *lamps, size_t n, sheen_err *err)
{
    sheen_lamp *copy = NULL;
    if (n && !(copy = malloc(n * sizeof *copy)))
        return sheen_fail_memory(err, (double)(n * sizeof *copy), "the model's lamps");
    if (n)
        memcpy(copy, lamps, n * sizeof *copy);
    free(m->lamps);
    m->lamps = copy;
    m->n_lamps = n;
    return SHEEN_OK;
}

sheen_lobe_shape sheen_model_lobe(const sheen_model *m)
{
    return (sheen_lobe_shape){(float)m->sigma_rad, (float)m->lobe_tail, (float)m->lobe_fresnel};
}

void sheen_model_scale_highlights(sheen_model *m, const double rgb[3])
{
    for (int c = 0; c < 3; c++)
        m->light_rgb[c] *= rgb[c];
    for (size_t i = 0; i < m->n_lamps; i++)
        for (int c = 0; c < 3; c++)
            m->lamps[i].rgb[c] *= (float)rgb[c];
}

sheen_status sheen_model_check_lamps(const sheen_model *m, sheen_status code, sheen_err *err)
{
    if (m->n_lamps > SHEEN_LAMPS_MAX)
        return sheen_fail(err, code, "%zu lamps are more than the %d that a model may have", m->n_lamps,
                          SHEEN_LAMPS_MAX);
    if (!(m->lobe_tail >= 0 && m->lobe_tail <= 1) || !(m->lobe_fresnel >= 0 && m->lobe_fresnel <= 1e4))
        return sheen_fail(err, code, "the lamps' lobe is out of range");
    for (int i = 0; i < 3; i++)
        if (!(fabs(m->lamp_origin_world[i]) <= 1e6))
            return sheen_fail(err, code, "the lamps' origin is out of range");
    for (size_t i = 0; i < m->n_lamps; i++) {
        const sheen_lamp *l = &m->lamps[i];
        if (!(fabsf(sheen_dotf(l->direction_world, l->direction_world) - 1) < 1e-3f))
            return sheen_fail(err, code, "lamp %zu has a direction which is not a unit vector", i);
        if (!(l->inverse_distance_per_m >= 0 && l->inverse_distance_per_m <= 1e6f) ||
            !(l->radius_rad >= 0 && l->radius_rad <= 1.6f))
            return sheen_fail(err, code, "lamp %zu has a distance or an extent that is out of range", i);
        for (int c = 0; c < 3; c++)
            if (!(l->rgb[c] >= 0 && l->rgb[c] <= 1e30f))
                return sheen_fail(err, code, "lamp %zu has a colour that is out of range", i);
    }
    return SHEEN_OK;
}

static void put_floats(sheen_json_writer *w, const char *name, const float v[3])
{
    const double d[3] = {(double)v[0], (double)v[1], (double)v[2]};
    sheen_json_put_numbers(w, name, d, 3);
}

void sheen_model_write_lamps(sheen_json_writer *w, const sheen_model *m)
{
    if (!m->n_lamps)
        return;
    sheen_json_open(w, "lamps", '{');
    sheen_json_put_numbers(w, "origin_world", m->lamp_origin_world, 3);
    sheen_json_put_number(w, "tail", m->lobe_tail);
    sheen_json_put_number(w, "fresnel", m->lobe_fresnel);
    sheen_json_open(w, "lights", '[');
    for (size_t i = 0; i < m->n_lamps; i++) {
        const sheen_lamp *l = &m->lamps[i];
        sheen_json_open(w, NULL, '{');
        put_floats(w, "direction_world", l->direction_world);
        sheen_json_put_number(w, "inverse_distance_per_m", (double)l->inverse_distance_per_m);
        sheen_json_put_number(w, "radius_rad", (double)l->radius_rad);
        put_floats(w, "rgb", l->rgb);
        sheen_json_close(w);
    }
    sheen_json_close(w);
    sheen_json_close(w);
}

static sheen_status parse_lamp(sheen_lamp *out, const sheen_json *in, sheen_err *err)
{
    double direction[3], rgb[3], per_m, radius_rad;
    sheen_status s;
    if ((s = sheen_json_numbers(in, "direction_world", direction, 3, err)) ||
        (s = sheen_json_numbers(in, "rgb", rgb, 3, err)) ||
        (s = sheen_json_number(in, "inverse_distance_per_m", &per_m, err)) ||
        (s = sheen_json_number(in, "radius_rad", &radius_rad, err)))
        return s;
    for (int i = 0; i < 3; i++) {
        out->direction_world[i] = (float)direction[i];
        out->rgb[i] = (float)rgb[i];
    }
    out->inverse_distance_per_m = (float)per_m;
    out->radius_rad = (float)radius_rad;
    return SHEEN_OK;
}

sheen_status sheen_model_parse_lamps(sheen_model *m, const sheen_json *root, sheen_err *err)
{
    const sheen_json *in = sheen_json_get(root, "lamps"), *lights;
    sheen_status s;
    if (!in)
        return SHEEN_OK;
    if ((s = sheen_json_numbers(in, "origin_world", m->lamp_origin_world, 3, err)) ||
        (s = sheen_json_number(in, "tail", &m->lobe_tail, err)) ||
        (s = sheen_json_number(in, "fresnel", &m->lobe_fresnel, err)) ||
        (s = sheen_json_array(in, "lights", &lights, err)))
        return s;
    const size_t n = sheen_json_count(lights);
    if (n > SHEEN_LAMPS_MAX)
        return sheen_fail(err, SHEEN_EFORMAT, "%zu lamps are more than the %d that a model may have", n,
                          SHEEN_LAMPS_MAX);
    sheen_lamp *lamps = calloc(n + 1, sizeof *lamps);
    if (!lamps)
        return sheen_fail_memory(err, (double)(n * sizeof *lamps), "the model's lamps");
    for (size_t i = 0; i < n && !s; i++)
        s = parse_lamp(&lamps[i], sheen_json_at(lights, i), err);
    if (!s)
        s = sheen_model_set_lamps(m, lamps, n, err);
    free(lamps);
    return s;
}
