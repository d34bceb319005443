// SPDX-License-Identifier: Apache-2.0
// certainty_view.c - looks at the mesh from candidate viewpoints.
#include "fit/certainty_view.h"

#include <math.h>
#include <stdlib.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "render/scene.h"

enum { POINTS = 1500, AZIMUTHS = 24, ELEVATIONS = 4 };

static const double elevations_deg[ELEVATIONS] = {15, 35, 55, 75};
static const double pi = 3.14159265358979323846;

typedef struct search {
    const sheen_certainty *c;
    const sheen_model *model;
    const sheen_scene *scene;
    sheen_Rt Rt_world_obj;
    float centre_obj[3], radius_m, distance_m;
    float p_obj[3 * POINTS], n_world[3 * POINTS];
    uint8_t seldom[POINTS]; // fewer than two photographs saw it
    size_t n_points;
} search;

static void to_world(float out[3], const sheen_Rt *Rt, const float v[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (float)(Rt->R[i][0] * (double)v[0] + Rt->R[i][1] * (double)v[1] +
                         Rt->R[i][2] * (double)v[2]);
}

// Middles of evenly chosen triangles.
static void take_points(search *s, const sheen_mesh *mesh)
{
    const sheen_texture *t = &s->model->texture;
    const size_t per = sheen_texels_per_triangle(t->texels_per_edge);
    for (size_t i = 0; i < POINTS && i < mesh->n_triangles; i++, s->n_points++) {
        const size_t f = mesh->n_triangles <= POINTS ? i : i * mesh->n_triangles / POINTS;
        float n[3] = {0, 0, 0}, *p = s->p_obj + 3 * i;
        p[0] = p[1] = p[2] = 0;
        for (int c = 0; c < 3; c++) {
            const size_t v = mesh->triangles[3 * f + (size_t)c];
            for (size_t k = 0; k < 3; k++) {
                p[k] += mesh->p_obj[3 * v + k] / 3;
                n[k] += mesh->n_obj[3 * v + k];
            }
        }
        sheen_normalizef(n);
        to_world(s->n_world + 3 * i, &s->Rt_world_obj, n);
        s->seldom[i] = t->n_views[f * per + per / 2] < 2;
    }
}

// What a photograph from v_world would add: lamps that are shown seldom, and share of the surface that is.
static double worth_of(const search *s, const float v_world[3])
{
    float camera_obj[3];
    double lamps = 0, surface = 0;
    for (int k = 0; k < 3; k++) // obj from world: the transpose
        camera_obj[k] = s->centre_obj[k] +
                        s->distance_m * (float)(s->Rt_world_obj.R[0][k] * (double)v_world[0] +
                                                s->Rt_world_obj.R[1][k] * (double)v_world[1] +
                                                s->Rt_world_obj.R[2][k] * (double)v_world[2]);
    uint8_t visible[POINTS];
    sheen_scene_occluded(s->scene, visible, s->p_obj, s->n_points, camera_obj, 2e-3f * s->radius_m);
    for (size_t i = 0; i < s->n_points; i++) {
        visible[i] = !visible[i] && sheen_dotf(s->n_world + 3 * i, v_world) > 0.35f;
        surface += visible[i] && s->seldom[i];
    }
    const float reach = (float)fmax(2 * s->model->sigma_rad, 0.08); // points lie apart
    for (size_t l = 0; l < s->c->n_lamps; l++) {
        const sheen_lamp_certainty *lamp = &s->c->lamps[l];
        const float light[3] = {(float)lamp->v_world[0], (float)lamp->v_world[1], (float)lamp->v_world[2]};
        int shown = 0;
        for (size_t i = 0; i < s->n_points && lamp->n_views < 2 && !shown; i++)
            shown = visible[i] && sheen_lobe_alpha2(s->n_world + 3 * i, v_world, light) < reach * reach;
        lamps += shown;
    }
    return 0.2 * lamps + surface / (double)s->n_points;
}

sheen_status sheen_certainty_advise(sheen_certainty *c, const sheen_model *model, const sheen_mesh *mesh,
                                    const sheen_photos *photos, sheen_err *err)
{
    search *s = calloc(1, sizeof *s);
    sheen_scene *scene = NULL;
    if (!s)
        return sheen_fail_memory(err, (double)sizeof *s, "viewpoints");
    const sheen_status status = sheen_scene_new(&scene, mesh, err);
    if (status) {
        free(s);
        return status;
    }
    s->c = c;
    s->model = model;
    s->scene = scene;
    sheen_Rt_from_rt(&s->Rt_world_obj, photos->photos[0].rt_world_obj);
    sheen_mesh_sphere(mesh, s->centre_obj, &s->radius_m);
    for (size_t i = 0; i < photos->count; i++)
        s->distance_m += (float)(sheen_norm(photos->photos[i].rt_cam_obj + 3) / (double)photos->count);
    take_points(s, mesh);
    double best = 0.05; // less is not worth a photograph
    for (int e = 0; e < ELEVATIONS; e++)
        for (int a = 0; a < AZIMUTHS; a++) {
            const double az = 2 * pi * a / AZIMUTHS, el = elevations_deg[e] * pi / 180;
            const float v[3] = {(float)(cos(el) * cos(az)), (float)(cos(el) * sin(az)), (float)sin(el)};
            const double worth = worth_of(s, v);
            if (worth > best) {
                best = worth;
                c->advised = 1;
                c->advice_azimuth_deg = 360.0 * a / AZIMUTHS;
                c->advice_elevation_deg = elevations_deg[e];
            }
        }
    sheen_scene_free(&scene);
    free(s);
    return SHEEN_OK;
}
