// SPDX-License-Identifier: Apache-2.0
// model.c - a fitted model in memory, and how it is written: model.json and texture.exr.
//
// The file states the lights' directions beside their node indices, so that a reader needs no geodesic code,
// and the digest of the mesh's file, because the texture's patches follow the order of its triangles.
#include "render/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"
#include "render/geodesic.h"
#include "render/model_private.h"

void sheen_model_init(sheen_model *m)
{
    *m = (sheen_model){.light_rgb = {1, 1, 1}};
}

void sheen_model_release(sheen_model *m)
{
    sheen_mesh_release(&m->mesh);
    sheen_texture_release(&m->texture);
    sheen_texture_release(&m->normals);
    sheen_surroundings_release(&m->surroundings);
    sheen_model_set_lights(m, 0, NULL);
    sheen_model_set_lamps(m, NULL, 0, NULL);
    sheen_model_init(m);
}

sheen_status sheen_model_set_lights(sheen_model *m, size_t n, sheen_err *err)
{
    free(m->node);
    free(m->radiance);
    free(m->lights.dx);
    free(m->lights.dy);
    free(m->lights.dz);
    free(m->lights.weight);
    m->node = NULL;
    m->radiance = NULL;
    m->lights = (sheen_lights){0};
    if (!n)
        return SHEEN_OK;
    m->node = calloc(n, sizeof *m->node);
    m->radiance = calloc(n, sizeof *m->radiance);
    m->lights.dx = calloc(n, sizeof(float));
    m->lights.dy = calloc(n, sizeof(float));
    m->lights.dz = calloc(n, sizeof(float));
    m->lights.weight = calloc(n, sizeof(float));
    if (!m->node || !m->radiance || !m->lights.dx || !m->lights.dy || !m->lights.dz || !m->lights.weight) {
        sheen_model_set_lights(m, 0, NULL);
        return sheen_fail_memory(err, 24.0 * (double)n, "the model's lights");
    }
    m->lights.count = n;
    return SHEEN_OK;
}

// 10 f^2 + 2 nodes on the sphere; 5 f of them on the horizon where f is even, none where it is odd.
size_t sheen_model_hemisphere_size(int frequency)
{
    const size_t f = (size_t)frequency;
    return 5 * f * f + 1 + (f % 2 ? 0 : f / 2 * 5);
}

static int is_name(const char *text, size_t size)
{
    const char *end = memchr(text, 0, size);
    return end && end > text &&
           strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789-_") == (size_t)(end - text);
}

static sheen_status check_lights(const sheen_model *m, sheen_status code, sheen_err *err)
{
    if (m->frequency < 1 || m->frequency > SHEEN_GEODESIC_MAX_FREQUENCY ||
        m->n_hemisphere != sheen_model_hemisphere_size(m->frequency))
        return sheen_fail(err, code, "a hemisphere of frequency %d has not %zu nodes", m->frequency,
                          m->n_hemisphere);
    if (m->lights.count > m->n_hemisphere)
        return sheen_fail(err, code, "%zu lights are more than the hemisphere has nodes (%zu)",
                          m->lights.count, m->n_hemisphere);
    for (size_t i = 0; i < m->lights.count; i++) {
        const float d[3] = {m->lights.dx[i], m->lights.dy[i], m->lights.dz[i]};
        if (m->node[i] >= m->n_hemisphere)
            return sheen_fail(err, code, "light %zu is node %u, but the hemisphere has %zu", i, m->node[i],
                              m->n_hemisphere);
        if (!(m->radiance[i] >= 0 && m->radiance[i] <= 1e30f))
            return sheen_fail(err, code, "light %zu has a radiance of %g, which is out of range", i,
                              (double)m->radiance[i]);
        if (!(fabsf(sheen_dotf(d, d) - 1) < 1e-3f))
            return sheen_fail(err, code, "light %zu has a direction which is not a unit vector", i);
    }
    return SHEEN_OK;
}

sheen_status sheen_model_check(const sheen_model *m, sheen_status code, sheen_err *err)
{
    if (!is_name(m->method, sizeof m->method))
        return sheen_fail(err, code, "the model's method has no plain name");
    for (int i = 0; i < 6; i++)
        if (!isfinite(m->rt_world_obj[i]) || !isfinite(m->rt_world_cam[i]))
            return sheen_fail(err, code, "the model's pose 'rt_world_obj' or 'rt_world_cam' is not finite");
    if (!(m->sigma_rad > 1e-5 && m->sigma_rad <= 2))
        return sheen_fail(err, code, "the roughness 'sigma_rad' %g is out of range (0.00001 to 2)",
                          m->sigma_rad);
    if (!(m->k_s >= 0 && m->k_s <= 1e30))
        return sheen_fail(err, code, "the specular magnitude 'k_s' %g is out of range", m->k_s);
    for (int c = 0; c < 3; c++)
        if (!(m->light_rgb[c] >= 0 && m->light_rgb[c] <= 1e6))
            return sheen_fail(err, code, "the lights' colour 'light_rgb' is out of range");
    sheen_status s = sheen_model_check_surroundings(&m->surroundings, code, err);
    if (!s)
        s = sheen_model_check_irradiance(&m->irradiance, code, err);
    if (!s)
        s = sheen_model_check_lamps(m, code, err);
    if (!s)
        s = sheen_model_check_gloss(&m->gloss, code, err);
    return s ? s : check_lights(m, code, err);
}

static void write_lights(sheen_json_writer *w, const sheen_model *m)
{
    sheen_json_put_int(w, "frequency", m->frequency);
    sheen_json_put_int(w, "n_hemisphere", (long long)m->n_hemisphere);
    sheen_json_open(w, "nodes", '{');
    sheen_json_open(w, "index", '[');
    for (size_t i = 0; i < m->lights.count; i++)
        sheen_json_put_int(w, NULL, m->node[i]);
    sheen_json_close(w);
    sheen_json_open(w, "radiance", '[');
    for (size_t i = 0; i < m->lights.count; i++)
        sheen_json_put_number(w, NULL, (double)m->radiance[i]);
    sheen_json_close(w);
    sheen_json_open(w, "direction_world", '[');
    for (size_t i = 0; i < m->lights.count; i++) {
        const double d[3] = {(double)m->lights.dx[i], (double)m->lights.dy[i], (double)m->lights.dz[i]};
        sheen_json_put_numbers(w, NULL, d, 3);
    }
    sheen_json_close(w);
    sheen_json_close(w);
    sheen_json_put_number(w, "k_s", m->k_s);
    sheen_json_put_number(w, "sigma_rad", m->sigma_rad);
    sheen_json_put_numbers(w, "light_rgb", m->light_rgb, 3);
}

void sheen_model_put_numbers(sheen_json_writer *w, const sheen_model *m)
{
    sheen_json_put_string(w, "method", m->method);
    sheen_json_put_string(w, "moving", m->moving == SHEEN_MOVING_OBJECT ? "object" : "camera");
    sheen_json_put_numbers(w, "rt_world_obj", m->rt_world_obj, 6);
    write_lights(w, m);
    sheen_model_write_lamps(w, m);
    sheen_model_put_gloss(w, &m->gloss);
    sheen_model_put_surroundings(w, m);
    sheen_model_put_irradiance(w, m);
}

static void write_surface(sheen_json_writer *w, const sheen_model *m, const char *mesh_file,
                          const char *mesh_digest)
{
    int columns, width_px, height_px;
    sheen_texture_atlas_size(m->texture.n_triangles, m->texture.texels_per_edge, &columns, &width_px,
                             &height_px);
    sheen_json_open(w, "texture", '{');
    sheen_json_put_string(w, "file", SHEEN_MODEL_TEXTURE_FILE);
    sheen_json_put_int(w, "n_triangles", (long long)m->texture.n_triangles);
    sheen_json_put_int(w, "texels_per_edge", m->texture.texels_per_edge);
    sheen_json_put_int(w, "columns", columns);
    sheen_json_close(w);
    sheen_model_put_normals(w, m);
    sheen_json_open(w, "mesh", '{');
    sheen_json_put_string(w, "file", mesh_file);
    sheen_json_put_int(w, "n_vertices", (long long)m->mesh.n_vertices);
    sheen_json_put_int(w, "n_triangles", (long long)m->mesh.n_triangles);
    sheen_json_put_string(w, "digest", mesh_digest);
    sheen_json_close(w);
}

// Half precision (11 bits) where every texel fits its range, as light of photographs does.
sheen_status sheen_model_save_atlas(const sheen_texture *t, const char *path, sheen_err *err)
{
    sheen_image atlas;
    sheen_status s = sheen_texture_to_atlas(&atlas, t, err);
    if (s)
        return s;
    const size_t n = 4 * (size_t)atlas.width_px * (size_t)atlas.height_px;
    bool half = true;
    for (size_t i = 0; i < n && !s; i++) {
        half = half && fabsf(atlas.data[i]) < 65000;
        if (!isfinite(atlas.data[i]))
            s = sheen_fail(err, SHEEN_EARG,
                           "cannot save the texture: it holds something that is not a colour");
    }
    if (!s)
        s = sheen_exr_write(path, &atlas, NULL, half, err);
    sheen_image_release(&atlas);
    return s;
}

static sheen_status save_texture(const sheen_model *m, const char *dir, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const sheen_status s = sheen_path_join(path, dir, SHEEN_MODEL_TEXTURE_FILE, err);
    return s ? s : sheen_model_save_atlas(&m->texture, path, err);
}

sheen_status sheen_model_save(const sheen_model *m, const sheen_session *s, const char *dir,
                              void (*extra)(void *self, sheen_json_writer *w), void *self, sheen_err *err)
{
    char path[SHEEN_PATH_MAX], mesh_path[SHEEN_PATH_MAX], mesh_digest[33];
    const char *mesh_file = sheen_session_mesh_file(s);
    sheen_status status = sheen_model_check(m, SHEEN_EARG, err);
    if (!status && m->texture.n_triangles != m->mesh.n_triangles)
        status = sheen_fail(err, SHEEN_EARG, "the texture has %zu triangles, the mesh %zu",
                            m->texture.n_triangles, m->mesh.n_triangles);
    if (!status && !mesh_file)
        status = sheen_fail(err, SHEEN_EARG, "session '%s' has no mesh", s->path);
    if (status)
        return sheen_wrap(err, status, "cannot save the model");
    if ((status = sheen_session_path(mesh_path, s, mesh_file, err)) ||
        (status = sheen_file_digest(mesh_digest, mesh_path, err)) ||
        (status = sheen_path_join(path, dir, SHEEN_MODEL_FILE, err)) || (status = sheen_dir_make(dir, err)) ||
        (status = save_texture(m, dir, err)) || (status = sheen_model_save_normals(m, dir, err)) ||
        (status = sheen_model_save_board(m, dir, err)))
        return status;

    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema",
                          m->normals.n_triangles || m->gloss.n ? "sheen-model/3"
                          : m->n_lamps                         ? "sheen-model/2"
                                                               : "sheen-model/1");
    sheen_model_put_numbers(&w, m);
    write_surface(&w, m, mesh_file, mesh_digest);
    if (extra)
        extra(self, &w);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}
