// SPDX-License-Identifier: Apache-2.0
// change_model.c - change_model bent|turned|fine SESSION FOLDER: the session's model, into FOLDER, with a normal map of small waves;
// or with that and as one of an object that turned under its lights, with light of two lamps and the room on its texture; or with
// four times the triangles, whose mesh replaces the session's.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/model.h"

enum { TEXELS = 5 };
static const float slope = 0.15f, waves = 3; // radians; on the object's radius

// Unit waves along each axis, the mesh's normal taken off.
static void bend(sheen_model *m)
{
    float p[3 * TEXELS * TEXELS], n[3 * TEXELS * TEXELS], centre[3], radius_m;
    const size_t per_triangle = sheen_texels_per_triangle(TEXELS);
    sheen_mesh_sphere(&m->mesh, centre, &radius_m);
    for (size_t f = 0; f < m->mesh.n_triangles; f++) {
        sheen_texture_lattice(&m->mesh, f, TEXELS, p, n);
        for (size_t i = 0; i < per_triangle; i++) {
            float *d = m->normals.rgb + 3 * (f * per_triangle + i);
            for (size_t k = 0; k < 3; k++)
                d[k] = slope * sinf(6.2831853f * waves * (p[3 * i + k] - centre[k]) / radius_m);
            const float along = sheen_dotf(d, n + 3 * i);
            for (size_t k = 0; k < 3; k++)
                d[k] -= along * n[3 * i + k];
        }
    }
}

// The camera stands 0.4 m above and beside the object, as the first photograph's might have.
static void turn(sheen_model *m)
{
    static const double rt_world_cam[6] = {-2.2, 0.03, 0.01, 0, -0.36, 0.3};
    static const sheen_irradiance_lamp lamps[2] = {{{0.6f, 0, 0.8f}, 0, {1.2, 1, 0.8}},
                                                   {{0, -0.8f, 0.6f}, 1.5f, {0.3, 0.4, 0.6}}};
    m->moving = SHEEN_MOVING_OBJECT;
    memcpy(m->rt_world_cam, rt_world_cam, sizeof rt_world_cam);
    m->irradiance = (sheen_irradiance){.present = 1, .degree = 1, .n_lamps = 2};
    memcpy(m->irradiance.lamps, lamps, sizeof lamps);
    for (int c = 0; c < 3; c++) {
        m->irradiance.rgb[0][c] = 1.5 + 0.2 * c;
        m->irradiance.rgb[2][c] = 0.5;
    }
}

// The vertex in the middle of an edge, on the round surface that the normals tell; the same for both of the edge's triangles.
// table: [n_slots] of (lesser vertex + 1, greater, middle), by hash.
static uint32_t middle_of(sheen_mesh *mesh, uint32_t (*table)[3], size_t n_slots, uint32_t a, uint32_t b)
{
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    size_t slot = (low * (size_t)2654435761u + high * (size_t)40503u) % n_slots;
    while (table[slot][0] && (table[slot][0] != low + 1 || table[slot][1] != high))
        slot = (slot + 1) % n_slots;
    if (table[slot][0])
        return table[slot][2];
    const uint32_t vertex = (uint32_t)mesh->n_vertices++;
    const float *p0 = mesh->p_obj + 3 * (size_t)low, *p1 = mesh->p_obj + 3 * (size_t)high,
                *n0 = mesh->n_obj + 3 * (size_t)low, *n1 = mesh->n_obj + 3 * (size_t)high;
    float *p = mesh->p_obj + 3 * (size_t)vertex, *n = mesh->n_obj + 3 * (size_t)vertex, e[3];
    sheen_subf(e, p1, p0);
    const float rise0 = sheen_dotf(e, n0) / 8, rise1 = sheen_dotf(e, n1) / 8;
    for (int k = 0; k < 3; k++) {
        n[k] = n0[k] + n1[k];
        p[k] = (p0[k] + p1[k]) / 2 - rise0 * n0[k] + rise1 * n1[k];
    }
    sheen_normalizef(n);
    table[slot][0] = low + 1;
    table[slot][1] = high;
    return table[slot][2] = vertex;
}

// Each triangle's four quarters; places in their triangle are the corners' of the one before.
static sheen_status refine(sheen_model *m, const char *mesh_path, sheen_err *err)
{
    static const float corner[4][3][2] = {{{0, 0}, {0.5f, 0}, {0, 0.5f}},
                                          {{0.5f, 0}, {1, 0}, {0.5f, 0.5f}},
                                          {{0, 0.5f}, {0.5f, 0.5f}, {0, 1}},
                                          {{0.5f, 0.5f}, {0, 0.5f}, {0.5f, 0}}};
    sheen_mesh *old = &m->mesh, fine = {.n_vertices = old->n_vertices, .n_triangles = 4 * old->n_triangles};
    const size_t n_most = old->n_vertices + 3 * old->n_triangles, n_slots = 8 * old->n_triangles + 7;
    sheen_texture texture;
    const int T = m->texture.texels_per_edge / 2 + 1;
    fine.p_obj = calloc(3 * n_most, sizeof *fine.p_obj);
    fine.n_obj = calloc(3 * n_most, sizeof *fine.n_obj);
    fine.triangles = calloc(3 * fine.n_triangles, sizeof *fine.triangles);
    uint32_t(*table)[3] = calloc(n_slots, sizeof *table);
    sheen_status s = sheen_texture_init(&texture, fine.n_triangles, T, err);
    if (s || !table || !fine.p_obj || !fine.n_obj || !fine.triangles)
        return sheen_fail_memory(err, 24.0 * (double)n_most, "a mesh");
    memcpy(fine.p_obj, old->p_obj, 3 * old->n_vertices * sizeof *fine.p_obj);
    memcpy(fine.n_obj, old->n_obj, 3 * old->n_vertices * sizeof *fine.n_obj);
    for (size_t f = 0; f < old->n_triangles; f++) {
        const uint32_t *v = old->triangles + 3 * f;
        uint32_t mid[3]; // opposite to each corner
        for (size_t k = 0; k < 3; k++)
            mid[k] = middle_of(&fine, table, n_slots, v[(k + 1) % 3], v[(k + 2) % 3]);
        const uint32_t quarter[4][3] = {
            {v[0], mid[2], mid[1]}, {mid[2], v[1], mid[0]}, {mid[1], mid[0], v[2]}, {mid[0], mid[1], mid[2]}};
        memcpy(fine.triangles + 12 * f, quarter, sizeof quarter);
    }
    const size_t n = fine.n_triangles * sheen_texels_per_triangle(T);
    for (size_t i = 0; i < n; i++) {
        const sheen_hit at = sheen_texel_hit(T, i);
        const float(*c)[2] = corner[at.triangle % 4], b0 = 1 - at.b1 - at.b2;
        const sheen_hit was = {.triangle = at.triangle / 4,
                               .b1 = b0 * c[0][0] + at.b1 * c[1][0] + at.b2 * c[2][0],
                               .b2 = b0 * c[0][1] + at.b1 * c[1][1] + at.b2 * c[2][1]};
        texture.n_views[i] = sheen_texture_sample(&m->texture, &was, texture.rgb + 3 * i) > 0.5f;
    }
    free(table);
    sheen_mesh_release(old);
    sheen_texture_release(&m->texture);
    *old = fine;
    m->texture = texture;
    return sheen_mesh_save_ply(old, mesh_path, err);
}

static sheen_status change(sheen_model *model, const char *how, const sheen_session *session, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_texture_release(&model->normals);
    if (!strcmp(how, "fine")) {
        const sheen_status s = sheen_session_path(path, session, sheen_session_mesh_file(session), err);
        return s ? s : refine(model, path, err);
    }
    const sheen_status s = sheen_normal_map_init(&model->normals, model->mesh.n_triangles, TEXELS, err);
    if (s)
        return s;
    bend(model);
    if (!strcmp(how, "turned"))
        turn(model);
    return SHEEN_OK;
}

int main(int argc, char **argv)
{
    sheen_err err;
    sheen_session session;
    sheen_model model;
    if (argc != 4)
        return 2;
    sheen_status s = sheen_session_open(&session, argv[2], &err);
    if (!s)
        s = sheen_model_load(&model, &session, &err);
    if (s)
        return fprintf(stderr, "%s\n", err.msg), 1;
    s = change(&model, argv[1], &session, &err);
    if (!s)
        s = sheen_model_save(&model, &session, argv[3], NULL, NULL, &err);
    if (s)
        fprintf(stderr, "%s\n", err.msg);
    sheen_model_release(&model);
    sheen_session_release(&session);
    return s != SHEEN_OK;
}
