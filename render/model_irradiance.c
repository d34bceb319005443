// SPDX-License-Identifier: Apache-2.0
// model_irradiance.c - the members of model.json for an object that turned: its light on the diffuse part.
#include <math.h>
#include <string.h>

#include "base/pose3.h"
#include "render/model_private.h"

// Direction, colour, inverse distance.
enum { LAMP_NUMBERS = 7 };

static int in_range(const double *x, size_t n, double least, double most)
{
    for (size_t i = 0; i < n; i++)
        if (!(x[i] >= least && x[i] <= most))
            return 0;
    return 1;
}

sheen_status sheen_model_check_irradiance(const sheen_irradiance *e, sheen_status code, sheen_err *err)
{
    if (!e->present)
        return SHEEN_OK;
    int good = e->degree >= 0 && e->degree <= 2 && e->n_lamps >= 0 &&
               e->n_lamps <= SHEEN_IRRADIANCE_MAX_LAMPS &&
               in_range(&e->rgb[0][0], 3 * SHEEN_AMBIENT_TERMS, -1e6, 1e6);
    for (int j = 0; good && j < e->n_lamps; j++)
        good = in_range(e->lamps[j].rgb, 3, 0, 1e6) &&
               fabsf(sheen_dotf(e->lamps[j].l_world, e->lamps[j].l_world) - 1) < 1e-3f &&
               e->lamps[j].inverse_distance_per_m >= 0 && e->lamps[j].inverse_distance_per_m <= 1e4f;
    return good ? SHEEN_OK : sheen_fail(err, code, "the light 'irradiance' is out of range");
}

void sheen_model_put_irradiance(sheen_json_writer *w, const sheen_model *m)
{
    const sheen_irradiance *e = &m->irradiance;
    if (m->moving == SHEEN_MOVING_OBJECT)
        sheen_json_put_numbers(w, "rt_world_cam", m->rt_world_cam, 6);
    if (!e->present)
        return;
    sheen_json_open(w, "irradiance", '{');
    sheen_json_put_int(w, "degree", e->degree);
    sheen_json_open(w, "harmonics_rgb", '[');
    for (int k = 0; k < sheen_irradiance_terms(e->degree); k++)
        sheen_json_put_numbers(w, NULL, e->rgb[k], 3);
    sheen_json_close(w);
    sheen_json_open(w, "lamps", '[');
    for (int j = 0; j < e->n_lamps; j++) {
        const sheen_irradiance_lamp *lamp = &e->lamps[j];
        const double row[LAMP_NUMBERS] = {(double)lamp->l_world[0],
                                          (double)lamp->l_world[1],
                                          (double)lamp->l_world[2],
                                          lamp->rgb[0],
                                          lamp->rgb[1],
                                          lamp->rgb[2],
                                          (double)lamp->inverse_distance_per_m};
        sheen_json_put_numbers(w, NULL, row, LAMP_NUMBERS);
    }
    sheen_json_close(w);
    sheen_json_close(w);
}

static void read_row(double *out, const sheen_json *row, size_t n)
{
    for (size_t i = 0; i < n; i++)
        out[i] = sheen_json_count(row) == n ? sheen_json_value_number(sheen_json_at(row, i), (double)NAN)
                                            : (double)NAN;
}

sheen_status sheen_model_get_irradiance(sheen_model *m, const sheen_json *root, sheen_err *err)
{
    const sheen_json *given = sheen_json_get(root, "irradiance"), *harmonics, *lamps;
    sheen_irradiance *e = &m->irradiance;
    sheen_status s = SHEEN_OK;
    if (sheen_json_get(root, "rt_world_cam"))
        s = sheen_json_numbers(root, "rt_world_cam", m->rt_world_cam, 6, err);
    if (s || !given)
        return s;
    if ((s = sheen_json_int(given, "degree", 0, 2, &e->degree, err)) ||
        (s = sheen_json_array(given, "harmonics_rgb", &harmonics, err)) ||
        (s = sheen_json_array(given, "lamps", &lamps, err)))
        return s;
    const size_t n_terms = (size_t)sheen_irradiance_terms(e->degree), n_lamps = sheen_json_count(lamps);
    if (sheen_json_count(harmonics) != n_terms || n_lamps > SHEEN_IRRADIANCE_MAX_LAMPS)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "'irradiance' has %zu harmonics and %zu lamps: it should be %zu, and at most %d",
                          sheen_json_count(harmonics), n_lamps, n_terms, (int)SHEEN_IRRADIANCE_MAX_LAMPS);
    for (size_t k = 0; k < n_terms; k++)
        read_row(e->rgb[k], sheen_json_at(harmonics, k), 3);
    for (size_t j = 0; j < n_lamps; j++) {
        double row[LAMP_NUMBERS] = {0};
        const sheen_json *given_row = sheen_json_at(lamps, j);
        // Rows without the distance are of lamps infinitely far
        read_row(row, given_row,
                 sheen_json_count(given_row) == LAMP_NUMBERS - 1 ? LAMP_NUMBERS - 1 : LAMP_NUMBERS);
        e->lamps[j].inverse_distance_per_m = (float)row[6];
        for (int k = 0; k < 3; k++) {
            e->lamps[j].l_world[k] = (float)row[k];
            e->lamps[j].rgb[k] = row[3 + k];
        }
    }
    e->n_lamps = (int)n_lamps;
    e->present = 1;
    return SHEEN_OK;
}

void sheen_model_place(double rt_world_obj[6], const sheen_model *m, const double rt_cam_obj[6])
{
    if (m->moving == SHEEN_MOVING_OBJECT)
        sheen_rt_compose(rt_world_obj, m->rt_world_cam, rt_cam_obj);
    else
        memcpy(rt_world_obj, m->rt_world_obj, sizeof m->rt_world_obj);
}
