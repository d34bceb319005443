// SPDX-License-Identifier: Apache-2.0
// model_normals.c - the member "normals" of model.json, and the picture normals.exr that it names.
#include <math.h>
#include <string.h>

#include "base/image_file.h"
#include "render/model_private.h"

static const char normals_file[] = "normals.exr";

void sheen_model_put_normals(sheen_json_writer *w, const sheen_model *m)
{
    if (!m->normals.n_triangles)
        return;
    sheen_json_open(w, "normals", '{');
    sheen_json_put_string(w, "file", normals_file);
    sheen_json_put_int(w, "texels_per_edge", m->normals.texels_per_edge);
    sheen_json_close(w);
}

sheen_status sheen_model_save_normals(const sheen_model *m, const char *dir, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_texture copy;
    const sheen_texture *n = &m->normals;
    if (!n->n_triangles)
        return SHEEN_OK;
    if (n->n_triangles != m->mesh.n_triangles)
        return sheen_fail(err, SHEEN_EARG, "the normal map has %zu triangles, the mesh %zu", n->n_triangles,
                          m->mesh.n_triangles);
    sheen_status s = sheen_texture_init(&copy, n->n_triangles, n->texels_per_edge, err);
    if (s)
        return s;
    const size_t n_texels = n->n_triangles * sheen_texels_per_triangle(n->texels_per_edge);
    memcpy(copy.rgb, n->rgb, 3 * n_texels * sizeof *copy.rgb);
    memcpy(copy.n_views, n->n_views, n_texels);
    sheen_normal_map_to_tangents(&copy, &m->mesh);
    if (!(s = sheen_path_join(path, dir, normals_file, err)))
        s = sheen_model_save_atlas(&copy, path, err);
    sheen_texture_release(&copy);
    return s;
}

sheen_status sheen_model_parse_normals(int *texels_per_edge, const sheen_json *root, sheen_err *err)
{
    const sheen_json *in = sheen_json_get(root, "normals");
    *texels_per_edge = 0;
    if (!in)
        return SHEEN_OK;
    if (!sheen_json_is_object(in))
        return sheen_fail(err, SHEEN_EFORMAT, "'normals' is no object");
    return sheen_json_int(in, "texels_per_edge", SHEEN_TEXTURE_MIN_EDGE, SHEEN_TEXTURE_MAX_EDGE,
                          texels_per_edge, err);
}

sheen_status sheen_model_load_normals(sheen_model *m, const char *dir, const sheen_json *root, sheen_err *err)
{
    int texels_per_edge;
    sheen_status s = sheen_model_parse_normals(&texels_per_edge, root, err);
    if (s || !texels_per_edge)
        return s;
    s = sheen_model_load_atlas(&m->normals, dir, sheen_json_get(root, "normals"), m->mesh.n_triangles,
                               texels_per_edge, err);
    if (s)
        return s;
    const size_t n = m->normals.n_triangles * sheen_texels_per_triangle(texels_per_edge);
    for (size_t i = 0; i < 3 * n; i++)
        if (!(fabsf(m->normals.rgb[i]) <= SHEEN_NORMAL_MAP_MOST))
            return sheen_fail(err, SHEEN_EFORMAT, "the normal map holds an offset that is out of range");
    sheen_normal_map_from_tangents(&m->normals, &m->mesh);
    return SHEEN_OK;
}
