// SPDX-License-Identifier: Apache-2.0
// model_parse.c - reading model.json, the texture and the mesh that belongs to them. Nothing in them is
// trusted.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"
#include "base/json.h"
#include "render/geodesic.h"
#include "render/model_private.h"

static const double pi = 3.14159265358979323846;

enum { MAX_MODEL_BYTES = 256 << 20 };

static sheen_status parse_head(sheen_model *m, const sheen_json *root, sheen_err *err)
{
    const char *method, *moving;
    sheen_status s;
    if ((s = sheen_json_string(root, "method", &method, err)) ||
        (s = sheen_json_string(root, "moving", &moving, err)) ||
        (s = sheen_json_numbers(root, "rt_world_obj", m->rt_world_obj, 6, err)) ||
        (s = sheen_json_number(root, "k_s", &m->k_s, err)) ||
        (s = sheen_json_number(root, "sigma_rad", &m->sigma_rad, err)) ||
        (s = sheen_json_numbers(root, "light_rgb", m->light_rgb, 3, err)))
        return s;
    if (strlen(method) >= sizeof m->method)
        return sheen_fail(err, SHEEN_EFORMAT, "the model's method has no plain name");
    memcpy(m->method, method, strlen(method) + 1);
    if (strcmp(moving, "camera") != 0 && strcmp(moving, "object") != 0)
        return sheen_fail(err, SHEEN_EFORMAT, "'moving' is '%.40s', neither 'camera' nor 'object'", moving);
    m->moving = strcmp(moving, "object") == 0 ? SHEEN_MOVING_OBJECT : SHEEN_MOVING_CAMERA;
    return SHEEN_OK;
}

// One light from the three lists.
static sheen_status parse_light(sheen_model *m, size_t i, double node, double radiance,
                                const sheen_json *direction, sheen_err *err)
{
    if (!(node >= 0 && node < (double)m->n_hemisphere && node == floor(node)))
        return sheen_fail(err, SHEEN_EFORMAT, "light %zu is node %g, but the hemisphere has %zu", i, node,
                          m->n_hemisphere);
    if (!(radiance >= 0 && radiance <= 1e30))
        return sheen_fail(err, SHEEN_EFORMAT, "light %zu has a radiance of %g, which is out of range", i,
                          radiance);
    double d[3];
    for (size_t k = 0; k < 3; k++)
        d[k] = sheen_json_value_number(sheen_json_at(direction, k), (double)NAN);
    if (sheen_json_count(direction) != 3 || !(fabs(sheen_norm(d) - 1) < 1e-3))
        return sheen_fail(err, SHEEN_EFORMAT, "light %zu has a direction which is not a unit vector", i);
    sheen_normalize(d);
    m->node[i] = (uint32_t)node;
    m->radiance[i] = (float)radiance;
    m->lights.dx[i] = (float)d[0];
    m->lights.dy[i] = (float)d[1];
    m->lights.dz[i] = (float)d[2];
    m->lights.weight[i] = (float)(2 * pi / (double)m->n_hemisphere * radiance);
    return SHEEN_OK;
}

static sheen_status parse_lights(sheen_model *m, const sheen_json *root, sheen_err *err)
{
    int n_hemisphere;
    const sheen_json *index, *radiance, *direction;
    const int most = (int)sheen_model_hemisphere_size(SHEEN_GEODESIC_MAX_FREQUENCY);
    const sheen_json *nodes = sheen_json_get(root, "nodes");
    sheen_status s = sheen_json_int(root, "frequency", 1, SHEEN_GEODESIC_MAX_FREQUENCY, &m->frequency, err);
    if (s || (s = sheen_json_int(root, "n_hemisphere", 1, most, &n_hemisphere, err)))
        return s;
    m->n_hemisphere = (size_t)n_hemisphere;
    if (!sheen_json_is_object(nodes))
        return sheen_fail(err, SHEEN_EFORMAT, "no object 'nodes'");
    if ((s = sheen_json_array(nodes, "index", &index, err)) ||
        (s = sheen_json_array(nodes, "radiance", &radiance, err)) ||
        (s = sheen_json_array(nodes, "direction_world", &direction, err)))
        return s;
    const size_t n = sheen_json_count(index);
    if (sheen_json_count(radiance) != n || sheen_json_count(direction) != n)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "'index', 'radiance' and 'direction_world' of 'nodes' differ in length");
    if (n > m->n_hemisphere)
        return sheen_fail(err, SHEEN_EFORMAT, "%zu lights are more than the hemisphere has nodes (%zu)", n,
                          m->n_hemisphere);
    s = sheen_model_set_lights(m, n, err);
    for (size_t i = 0; i < n && !s; i++)
        s = parse_light(m, i, sheen_json_value_number(sheen_json_at(index, i), -1),
                        sheen_json_value_number(sheen_json_at(radiance, i), -1), sheen_json_at(direction, i),
                        err);
    return s;
}

static sheen_status parse_texture(const sheen_json *root, size_t *n_triangles, int *texels_per_edge,
                                  sheen_err *err)
{
    const sheen_json *texture = sheen_json_get(root, "texture");
    int n, columns, want_columns, width_px, height_px;
    if (!sheen_json_is_object(texture))
        return sheen_fail(err, SHEEN_EFORMAT, "no object 'texture'");
    sheen_status s = sheen_json_int(texture, "n_triangles", 1, SHEEN_MESH_MAX_TRIANGLES, &n, err);
    if (s ||
        (s = sheen_json_int(texture, "texels_per_edge", SHEEN_TEXTURE_MIN_EDGE, SHEEN_TEXTURE_MAX_EDGE,
                            texels_per_edge, err)) ||
        (s = sheen_json_int(texture, "columns", 1, SHEEN_IMAGE_MAX_SIDE_PX, &columns, err)))
        return s;
    *n_triangles = (size_t)n;
    sheen_texture_atlas_size(*n_triangles, *texels_per_edge, &want_columns, &width_px, &height_px);
    if (columns != want_columns)
        return sheen_fail(err, SHEEN_EFORMAT, "a texture of %d triangles stands in %d columns, not %d", n,
                          want_columns, columns);
    return SHEEN_OK;
}

sheen_status sheen_model_get_numbers(sheen_model *m, const sheen_json *root, sheen_err *err)
{
    sheen_status s = parse_head(m, root, err);
    if (!s)
        s = parse_lights(m, root, err);
    if (!s)
        s = sheen_model_parse_lamps(m, root, err);
    if (!s)
        s = sheen_model_get_gloss(&m->gloss, root, err);
    if (!s)
        s = sheen_model_get_surroundings(m, root, err);
    if (!s)
        s = sheen_model_get_irradiance(m, root, err);
    if (!s)
        s = sheen_model_check(m, SHEEN_EFORMAT, err);
    return s;
}

static sheen_status parse_root(sheen_model *m, const sheen_json *root, size_t *n_triangles,
                               int *texels_per_edge, sheen_err *err)
{
    int version, of_normals;
    sheen_status s = sheen_json_schema(root, SHEEN_MODEL_SCHEMA, SHEEN_MODEL_VERSION, &version, err);
    if (!s)
        s = sheen_model_get_numbers(m, root, err);
    if (!s)
        s = parse_texture(root, n_triangles, texels_per_edge, err);
    return s ? s : sheen_model_parse_normals(&of_normals, root, err);
}

sheen_status sheen_model_parse(sheen_model *m, const void *data, size_t size_bytes, size_t *n_triangles,
                               int *texels_per_edge, sheen_err *err)
{
    sheen_model_init(m);
    sheen_json *root = NULL;
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = parse_root(m, root, n_triangles, texels_per_edge, err);
    sheen_json_free(&root);
    if (s)
        sheen_model_release(m);
    return s;
}

// The mesh must be the one that was fitted, triangle by triangle.
static sheen_status load_mesh(sheen_model *m, const sheen_session *s, const sheen_json *root, sheen_err *err)
{
    const char *file = sheen_session_mesh_file(s), *want;
    char path[SHEEN_PATH_MAX], digest[33];
    const sheen_json *mesh = sheen_json_get(root, "mesh");
    if (!file)
        return sheen_fail(err, SHEEN_EFORMAT,
                          "the session has a model but no mesh: import the mesh that was fitted");
    if (!sheen_json_is_object(mesh))
        return sheen_fail(err, SHEEN_EFORMAT, "no object 'mesh'");
    sheen_status status = sheen_json_string(mesh, "digest", &want, err);
    if (status || (status = sheen_session_path(path, s, file, err)) ||
        (status = sheen_file_digest(digest, path, err)))
        return status;
    if (strcmp(digest, want) != 0)
        return sheen_fail(err, SHEEN_EFORMAT, "the mesh '%s' is not the one that was fitted: fit again",
                          file);
    return sheen_mesh_load(&m->mesh, path, err);
}

// The picture's size is compared before it is decoded.
sheen_status sheen_model_load_atlas(sheen_texture *t, const char *dir, const sheen_json *in,
                                    size_t n_triangles, int texels_per_edge, sheen_err *err)
{
    const char *file;
    char path[SHEEN_PATH_MAX];
    int columns, want_width, want_height, width_px = 0, height_px = 0;
    uint8_t *data = NULL;
    size_t size_bytes;
    sheen_raster raster = {0};
    sheen_status s = sheen_json_string(in, "file", &file, err);
    if (s)
        return s;
    if (!*file || *file == '.' || strchr(file, '/'))
        return sheen_fail(err, SHEEN_EFORMAT, "the texture's file '%.80s' is not a plain name", file);
    sheen_texture_atlas_size(n_triangles, texels_per_edge, &columns, &want_width, &want_height);
    const size_t most = (size_t)want_width * (size_t)want_height * 16 + (1 << 20);
    if ((s = sheen_path_join(path, dir, file, err)) ||
        (s = sheen_file_read(&data, &size_bytes, path, most, err)))
        return s;
    s = sheen_raster_probe(&width_px, &height_px, data, size_bytes, err);
    if (!s && (width_px != want_width || height_px != want_height))
        s = sheen_fail(err, SHEEN_EFORMAT,
                       "it is a picture of %d x %d px, not the %d x %d px of this model's texture", width_px,
                       height_px, want_width, want_height);
    if (!s)
        s = sheen_exr_parse(&raster, data, size_bytes, err);
    if (!s) {
        const sheen_image atlas = {raster.data, raster.width_px, raster.height_px, raster.n_channels};
        s = raster.bits == 32 ? sheen_texture_from_atlas(t, &atlas, n_triangles, texels_per_edge, err)
                              : sheen_fail(err, SHEEN_EFORMAT, "it is not a picture of floats");
    }
    sheen_raster_release(&raster);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read the texture '%s'", path) : SHEEN_OK;
}

static sheen_status load_parts(sheen_model *m, const sheen_session *s, const char *dir,
                               const sheen_json *root, sheen_err *err)
{
    size_t n_triangles = 0;
    int texels_per_edge = 0;
    sheen_status status = parse_root(m, root, &n_triangles, &texels_per_edge, err);
    if (!status)
        status = load_mesh(m, s, root, err);
    if (!status && m->mesh.n_triangles != n_triangles)
        status = sheen_fail(err, SHEEN_EFORMAT, "the texture has %zu triangles, the mesh %zu: fit again",
                            n_triangles, m->mesh.n_triangles);
    if (!status)
        status = sheen_model_load_atlas(&m->texture, dir, sheen_json_get(root, "texture"), n_triangles,
                                        texels_per_edge, err);
    if (!status)
        status = sheen_model_load_normals(m, dir, root, err);
    if (!status)
        status = sheen_model_load_surroundings(m, dir, root, err);
    return status;
}

sheen_status sheen_model_load(sheen_model *m, const sheen_session *s, sheen_err *err)
{
    char dir[SHEEN_PATH_MAX], path[SHEEN_PATH_MAX];
    uint8_t *data = NULL;
    size_t size_bytes;
    sheen_json *root = NULL;
    sheen_model_init(m);
    sheen_status status = sheen_session_path(dir, s, SHEEN_SESSION_MODEL, err);
    if (status || (status = sheen_path_join(path, dir, SHEEN_MODEL_FILE, err)))
        return status;
    if (!sheen_file_exists(path))
        return sheen_fail(err, SHEEN_EDATA, "session '%s' has no model yet: fit it first", s->path);
    status = sheen_file_read(&data, &size_bytes, path, MAX_MODEL_BYTES, err);
    if (status)
        return status;
    status = sheen_json_parse(&root, data, size_bytes, err);
    if (!status)
        status = load_parts(m, s, dir, root, err);
    sheen_json_free(&root);
    free(data);
    if (status) {
        sheen_model_release(m);
        return sheen_wrap(err, status, "cannot load the model '%s'", path);
    }
    return SHEEN_OK;
}
