// SPDX-License-Identifier: Apache-2.0
// far_lights.c - lights without the model's own ways of stating them, for formats that know only direction and power.
//
// A mirror of reflectance f0 under a wide light of radiance L' shows f0 L'. Eq. (7) adds up to 8 pi sigma^2 k_S L (a half
// vector has a fourth of the solid angle of the light), so a light of weight w, solid angle times radiance, has the power
// 8 pi sigma^2 k_S w over f0. A lamp's heavy-tailed lobe holds twice what a Gaussian of its peak does: 8 pi sigma^2
// (1 + tail) times its rgb. Lamps at a distance are taken as they are seen from the middle of the object.
#include "render/far_lights.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"

static const double pi = 3.14159265358979323846;

typedef struct frames {
    sheen_Rt world_obj;
    double (*R_env_obj)[3];
} frames;

static void to_env(float v_env[3], const frames *f, const double v_world[3])
{
    double v_obj[3];
    for (int k = 0; k < 3; k++)
        v_obj[k] = f->world_obj.R[0][k] * v_world[0] + f->world_obj.R[1][k] * v_world[1] +
                   f->world_obj.R[2][k] * v_world[2];
    for (int k = 0; k < 3; k++)
        v_env[k] = (float)sheen_dot(f->R_env_obj[k], v_obj);
    sheen_normalizef(v_env);
}

static void from_node(sheen_far_light *out, const sheen_model *m, size_t i, const frames *f)
{
    const double l[3] = {(double)m->lights.dx[i], (double)m->lights.dy[i], (double)m->lights.dz[i]};
    to_env(out->v_env, f, l);
    for (int c = 0; c < 3; c++)
        out->power_rgb[c] = 8 * pi * m->sigma_rad * m->sigma_rad * m->k_s * (double)m->lights.weight[i] *
                            m->light_rgb[c];
    out->solid_angle_sr = m->n_hemisphere ? 2 * pi / (double)m->n_hemisphere : 0;
    out->distance_m = INFINITY;
}

// middle_m: of the object, from the lamps' origin, in world.
static void from_lamp(sheen_far_light *out, const sheen_model *m, size_t i, const frames *f,
                      const double middle_m[3])
{
    const sheen_lamp *lamp = &m->lamps[i];
    const double per_m = (double)lamp->inverse_distance_per_m;
    double to_lamp[3];
    for (int k = 0; k < 3; k++)
        to_lamp[k] = (double)lamp->direction_world[k] - per_m * middle_m[k];
    const double length = fmax(sqrt(sheen_dot(to_lamp, to_lamp)), 1e-6);
    to_env(out->v_env, f, to_lamp);
    for (int c = 0; c < 3; c++)
        out->power_rgb[c] = 8 * pi * m->sigma_rad * m->sigma_rad * (1 + m->lobe_tail) * (double)lamp->rgb[c] /
                            (length * length);
    out->solid_angle_sr = 2 * pi * (1 - cos(fmin((double)lamp->radius_rad / length, pi / 2)));
    out->distance_m = per_m > 0 ? length / per_m : (double)INFINITY;
}

static bool shines(const sheen_far_light *l)
{
    return l->power_rgb[0] > 0 || l->power_rgb[1] > 0 || l->power_rgb[2] > 0;
}

sheen_status sheen_far_lights_make(sheen_far_light **out, size_t *n, const sheen_model *model,
                                   const double rt_world_obj[6], double R_env_obj[3][3], sheen_err *err)
{
    const size_t most = model->lights.count + model->n_lamps;
    frames f = {.R_env_obj = R_env_obj};
    float centre[3], radius_m;
    double middle[3], middle_m[3];
    *n = 0;
    *out = malloc((most + 1) * sizeof **out);
    if (!*out)
        return sheen_fail_memory(err, (double)((most + 1) * sizeof **out), "the model's lights");
    sheen_Rt_from_rt(&f.world_obj, rt_world_obj);
    sheen_mesh_sphere(&model->mesh, centre, &radius_m);
    for (int k = 0; k < 3; k++)
        middle[k] = (double)centre[k];
    sheen_Rt_point(middle_m, &f.world_obj, middle);
    for (int k = 0; k < 3; k++)
        middle_m[k] -= model->lamp_origin_world[k];
    for (size_t i = 0; i < most; i++) {
        if (i < model->lights.count)
            from_node(&(*out)[*n], model, i, &f);
        else
            from_lamp(&(*out)[*n], model, i - model->lights.count, &f, middle_m);
        *n += shines(&(*out)[*n]) ? 1 : 0;
    }
    return SHEEN_OK;
}
