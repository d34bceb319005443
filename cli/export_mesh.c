// SPDX-License-Identifier: Apache-2.0
// export_mesh.c - the surface without its highlights: a textured OBJ, a PLY with a colour a vertex. Frame obj, metres.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"
#include "base/text.h"
#include "cli/export.h"
#include "render/surface_picture.h"

enum { MAX_SIDE_PX = 4096 };

static sheen_status write_obj(const char *path, const char *stem, const sheen_surface_picture *p,
                              sheen_err *err)
{
    sheen_text t = {0};
    const sheen_charts *c = &p->charts;
    sheen_text_put(
        &t, "# metres; the light that left the surface without its highlights, in sRGB\nmtllib %.255s.mtl\n",
        stem);
    for (size_t i = 0; i < p->mesh.n_vertices; i++)
        sheen_text_put(&t, "v %.9g %.9g %.9g\n", (double)p->mesh.p_obj[3 * i],
                       (double)p->mesh.p_obj[3 * i + 1], (double)p->mesh.p_obj[3 * i + 2]);
    for (size_t i = 0; i < p->mesh.n_vertices; i++)
        sheen_text_put(&t, "vn %.6g %.6g %.6g\n", (double)p->mesh.n_obj[3 * i],
                       (double)p->mesh.n_obj[3 * i + 1], (double)p->mesh.n_obj[3 * i + 2]);
    for (size_t i = 0; i < c->n_vertices; i++)
        sheen_text_put(&t, "vt %.7g %.7g\n", (double)(c->q_px[2 * i] / (float)c->side_px),
                       (double)(1 - c->q_px[2 * i + 1] / (float)c->side_px));
    sheen_text_put(&t, "usemtl surface\n");
    for (size_t i = 0; i < c->n_triangles; i++) {
        sheen_text_put(&t, "f");
        for (size_t k = 0; k < 3; k++) {
            const uint32_t vt = c->triangles[3 * i + k] + 1, v = c->vertex[vt - 1] + 1;
            sheen_text_put(&t, " %u/%u/%u", v, vt, v);
        }
        sheen_text_put(&t, "\n");
    }
    return sheen_text_save(&t, path, err);
}

static sheen_status write_mtl(const char *path, const char *stem, sheen_err *err)
{
    char mtl[512];
    const int n = snprintf(mtl, sizeof mtl,
                           "newmtl surface\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd %.255s.png\n", stem);
    return sheen_file_write(path, mtl, (size_t)n, err);
}

// The same place with another ending.
static sheen_status sibling(char path[SHEEN_PATH_MAX], const char *output, const char *ending, sheen_err *err)
{
    const size_t stem = strlen(output) - strlen(sheen_path_extension(output));
    const int n = snprintf(path, SHEEN_PATH_MAX, "%.*s%s", (int)stem, output, ending);
    return n > 0 && n < SHEEN_PATH_MAX
               ? SHEEN_OK
               : sheen_fail(err, SHEEN_EARG, "the path '%.80s...' is too long", output);
}

sheen_status sheen_export_obj(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                              const sheen_cli_view *v, sheen_err *err)
{
    char mtl[SHEEN_PATH_MAX], png[SHEEN_PATH_MAX], stem[256];
    sheen_surface_picture p;
    (void)s;
    snprintf(stem, sizeof stem, "%.255s", sheen_path_base(a->output));
    stem[strlen(stem) - strlen(sheen_path_extension(stem)) - 1] = 0;
    sheen_status st = sibling(mtl, a->output, "mtl", err);
    if (!st)
        st = sibling(png, a->output, "png", err);
    if (!st)
        st = sheen_surface_picture_make(&p, &v->model, v->model.mesh.n_triangles, MAX_SIDE_PX, err);
    if (st)
        return st;
    st = sheen_image_fill(&p.rgb, p.known, err);
    if (!st)
        st = sheen_png_write_srgb(png, &p.rgb, err);
    if (!st)
        st = write_mtl(mtl, stem, err);
    if (!st)
        st = write_obj(a->output, stem, &p, err);
    if (!st) {
        sheen_cli_say(cli, "%s, %s, %s: %zu triangles, texture of %d px a side", a->output,
                      sheen_path_base(mtl), sheen_path_base(png), p.mesh.n_triangles, p.charts.side_px);
        sheen_json_put_string(&cli->out, "made", a->output);
        sheen_json_put_int(&cli->out, "triangles", (long long)p.mesh.n_triangles);
        sheen_json_put_int(&cli->out, "texture_px", p.charts.side_px);
    }
    sheen_surface_picture_release(&p);
    return st;
}

sheen_status sheen_export_vertex_colours(uint8_t **out, const sheen_model *m, sheen_err *err)
{
    const size_t n = m->mesh.n_vertices;
    float *sum = calloc(4 * n, sizeof *sum); // r g b, weight
    *out = malloc(4 * n);
    if (!sum || !*out) {
        free(sum);
        free(*out);
        *out = NULL;
        return sheen_fail_memory(err, 20.0 * (double)n, "colours of vertices");
    }
    for (size_t i = 0; i < 3 * m->mesh.n_triangles; i++) {
        const sheen_hit hit = {
            .triangle = (uint32_t)(i / 3), .b1 = i % 3 == 1 ? 1.0f : 0.0f, .b2 = i % 3 == 2 ? 1.0f : 0.0f};
        float rgb[3], *to = sum + 4 * (size_t)m->mesh.triangles[i];
        if (!(sheen_texture_sample(&m->texture, &hit, rgb) > 0))
            continue;
        for (int c = 0; c < 3; c++)
            to[c] += rgb[c];
        to[3] += 1;
    }
    for (size_t i = 0; i < n; i++) {
        const float *from = sum + 4 * i;
        for (size_t c = 0; c < 3; c++) {
            const float lin = from[3] > 0 ? fminf(fmaxf(from[c] / from[3], 0), 1) : 0;
            (*out)[4 * i + c] = (uint8_t)lrintf(255.0f * sheen_transfer_encode(SHEEN_TRANSFER_SRGB, lin));
        }
        (*out)[4 * i + 3] = from[3] > 0 ? 255 : 0;
    }
    free(sum);
    return SHEEN_OK;
}

static sheen_status write_ply(const char *path, const sheen_mesh *mesh, const uint8_t *rgba, sheen_err *err)
{
    sheen_text t = {0};
    sheen_text_put(
        &t, "ply\nformat ascii 1.0\ncomment metres; colours in sRGB, alpha 0 where no photograph saw the "
            "vertex\n");
    sheen_text_put(&t, "element vertex %zu\n", mesh->n_vertices);
    sheen_text_put(&t, "property float x\nproperty float y\nproperty float z\n");
    sheen_text_put(&t, "property float nx\nproperty float ny\nproperty float nz\n");
    sheen_text_put(&t,
                   "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n");
    sheen_text_put(&t, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
                   mesh->n_triangles);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        const float *p = mesh->p_obj + 3 * i, *n = mesh->n_obj + 3 * i;
        const uint8_t *c = rgba + 4 * i;
        sheen_text_put(&t, "%.9g %.9g %.9g %.6g %.6g %.6g %d %d %d %d\n", (double)p[0], (double)p[1],
                       (double)p[2], (double)n[0], (double)n[1], (double)n[2], c[0], c[1], c[2], c[3]);
    }
    for (size_t i = 0; i < mesh->n_triangles; i++)
        sheen_text_put(&t, "3 %u %u %u\n", mesh->triangles[3 * i], mesh->triangles[3 * i + 1],
                       mesh->triangles[3 * i + 2]);
    return sheen_text_save(&t, path, err);
}

sheen_status sheen_export_ply(sheen_cli *cli, const sheen_export_args *a, const sheen_session *s,
                              const sheen_cli_view *v, sheen_err *err)
{
    uint8_t *rgba;
    (void)s;
    sheen_status st = sheen_export_vertex_colours(&rgba, &v->model, err);
    if (!st)
        st = write_ply(a->output, &v->model.mesh, rgba, err);
    free(rgba);
    if (st)
        return st;
    sheen_cli_say(cli, "%s: %zu vertices with colours, %zu triangles", a->output, v->model.mesh.n_vertices,
                  v->model.mesh.n_triangles);
    sheen_json_put_string(&cli->out, "made", a->output);
    sheen_json_put_int(&cli->out, "triangles", (long long)v->model.mesh.n_triangles);
    return SHEEN_OK;
}
