// SPDX-License-Identifier: Apache-2.0
// texel_view.c - which texels a photograph sees, and their colours.
//
// Occlusion is decided by a ray from the texel to the camera. The gbuffer then tells how near the next
// depth edge is: the 3x3 pixels round the texel's image must all show surface at about the texel's own
// distance, since a bilinear sample there, and a pose that is half a pixel off, would mix two surfaces.
#include "fit/texel_view.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "fit/depth_edges.h"
#include "render/texture.h"

static const double most_texels_per_px2 = 4;

enum { MAX_TEXELS = SHEEN_TEXTURE_MAX_EDGE * (SHEEN_TEXTURE_MAX_EDGE + 1) / 2 };

sheen_status sheen_texel_view_init(sheen_texel_view *v, size_t n_triangles, int texels_per_edge,
                                   sheen_err *err)
{
    v->n_texels = n_triangles * sheen_texels_per_triangle(texels_per_edge);
    v->rgb = malloc(v->n_texels * 3 * sizeof *v->rgb);
    v->seen = malloc(v->n_texels);
    if (!v->rgb || !v->seen) {
        sheen_texel_view_release(v);
        return sheen_fail_memory(err, 13.0 * (double)v->n_texels, "texels of one photograph");
    }
    return SHEEN_OK;
}

void sheen_texel_view_release(sheen_texel_view *v)
{
    free(v->rgb);
    free(v->seen);
    *v = (sheen_texel_view){0};
}

typedef struct job {
    sheen_texel_view *out;
    const sheen_mesh *mesh;
    const sheen_scene *scene;
    const sheen_gbuffer *g;
    const sheen_camera *cam;
    const sheen_photo *photo;
    sheen_Rt Rt_cam_obj;
    float camera_obj[3];
    float footprint_per_m; // size of a pixel on a surface that faces the camera, per metre of distance
    float offset_m;
    int texels_per_edge;
} job;

static bool inside_mask(const sheen_image *mask, const double q_px[2])
{
    float m = 0;
    return !mask->data || (sheen_image_bilinear(&m, mask, q_px[0], q_px[1]) && m > 0.99f);
}

// True where no place on the triangle faces the camera: c - p and n are both linear in the barycentric coordinates.
static bool faces_away(const job *j, size_t triangle)
{
    const uint32_t *corner = j->mesh->triangles + 3 * triangle;
    for (int i = 0; i < 3; i++) {
        float v[3];
        sheen_subf(v, j->camera_obj, j->mesh->p_obj + 3 * (size_t)corner[i]);
        for (int k = 0; k < 3; k++)
            if (sheen_dotf(v, j->mesh->n_obj + 3 * (size_t)corner[k]) > 0)
                return false;
    }
    return true;
}

// Colours of one triangle's texels.
static void fill_triangle(const job *j, size_t triangle)
{
    float p_obj[MAX_TEXELS * 3], n_obj[MAX_TEXELS * 3];
    double p_cam[MAX_TEXELS * 3], q_px[MAX_TEXELS * 2];
    uint8_t occluded[MAX_TEXELS];
    const size_t n = sheen_texels_per_triangle(j->texels_per_edge);
    uint8_t *seen = j->out->seen + triangle * n;
    float *rgb = j->out->rgb + triangle * n * 3;

    memset(seen, 0, n);
    if (faces_away(j, triangle))
        return;
    sheen_texture_lattice(j->mesh, triangle, j->texels_per_edge, p_obj, n_obj);
    bool any = false;
    for (size_t i = 0; i < n; i++) {
        const double p[3] = {(double)p_obj[3 * i], (double)p_obj[3 * i + 1], (double)p_obj[3 * i + 2]};
        sheen_Rt_point(p_cam + 3 * i, &j->Rt_cam_obj, p);
        float v[3];
        sheen_subf(v, j->camera_obj, p_obj + 3 * i);
        const float distance_m = sheen_normalizef(v);
        seen[i] = p_cam[3 * i + 2] > 0 && distance_m > 0 &&
                  sheen_dotf(v, n_obj + 3 * i) >= SHEEN_SEEN_MIN_COS;
        any = any || seen[i];
    }
    if (!any)
        return;
    const sheen_status s = sheen_camera_project(j->cam, q_px, NULL, p_cam, n, NULL);
    assert(!s);
    (void)s;
    sheen_scene_occluded(j->scene, occluded, p_obj, n, j->camera_obj, j->offset_m);
    for (size_t i = 0; i < n; i++) {
        if (!seen[i])
            continue;
        float v[3];
        sheen_subf(v, j->camera_obj, p_obj + 3 * i);
        const float distance_m = sheen_normalizef(v);
        seen[i] = !occluded[i] && fabs(q_px[2 * i]) < 1e6 && fabs(q_px[2 * i + 1]) < 1e6 &&
                  sheen_clear_of_depth_edges(j->g, (int)lround(q_px[2 * i]), (int)lround(q_px[2 * i + 1]),
                                             distance_m, sheen_dotf(v, n_obj + 3 * i), j->footprint_per_m) &&
                  inside_mask(&j->photo->mask, q_px + 2 * i) &&
                  sheen_image_bilinear(rgb + 3 * i, &j->photo->image, q_px[2 * i], q_px[2 * i + 1]);
    }
}

static void fill_triangles(void *self, size_t begin, size_t end)
{
    const job *j = self;
    for (size_t f = begin; f < end; f++)
        fill_triangle(j, f);
}

static float mesh_radius_m(const sheen_mesh *mesh)
{
    float centre[3], radius;
    sheen_mesh_sphere(mesh, centre, &radius);
    return radius;
}

void sheen_texel_view_fill(sheen_texel_view *v, const sheen_mesh *mesh, const sheen_scene *scene,
                           const sheen_gbuffer *g, const sheen_camera *cam, const sheen_photo *photo,
                           int texels_per_edge, int n_threads)
{
    job j = {.out = v,
             .mesh = mesh,
             .scene = scene,
             .g = g,
             .cam = cam,
             .photo = photo,
             .footprint_per_m = 1.0f / (float)cam->intrinsics[0],
             .offset_m = 1e-4f * mesh_radius_m(mesh),
             .texels_per_edge = texels_per_edge};
    sheen_Rt_from_rt(&j.Rt_cam_obj, photo->rt_cam_obj);
    for (int i = 0; i < 3; i++)
        j.camera_obj[i] = (float)g->p_camera_obj[i];
    sheen_parallel_for(mesh->n_triangles, 64, n_threads, fill_triangles, &j);
}

// Area of a triangle in the camera's pixels as it would be seen squarely; negative: it faces away.
static double area_px2(const sheen_mesh *mesh, size_t triangle, const double camera_obj[3], double focal_px)
{
    const float *p[3];
    float e[2][3], n[3], to_camera[3];
    for (int i = 0; i < 3; i++)
        p[i] = mesh->p_obj + 3 * (size_t)mesh->triangles[3 * triangle + (size_t)i];
    sheen_subf(e[0], p[1], p[0]);
    sheen_subf(e[1], p[2], p[0]);
    for (int i = 0; i < 3; i++)
        to_camera[i] = (float)camera_obj[i] - p[0][i];
    sheen_crossf(n, e[0], e[1]);
    if (sheen_dotf(n, to_camera) <= 0)
        return -1;
    const double per_m = focal_px / sqrt((double)sheen_dotf(to_camera, to_camera));
    return fmin(1e8, 0.5 * sqrt((double)sheen_dotf(n, n)) * per_m * per_m);
}

// A lattice of T texels an edge cuts its triangle into (T - 1)^2 / 2 pairs of pieces, a pixel each where T - 1 = sqrt(2 area).
int sheen_texels_per_edge_for(const sheen_mesh *mesh, const sheen_photos *photos)
{
    enum { MOST = SHEEN_TEXTURE_MAX_EDGE };
    double weight[MOST + 1] = {0}, total = 0, below = 0;
    const size_t step = 1 + mesh->n_triangles /
                                20000; // every triangle of a small mesh, an even choice of a large one
    for (size_t v = 0; v < photos->count; v++) {
        double rt_obj_cam[6];
        sheen_rt_invert(rt_obj_cam, photos->photos[v].rt_cam_obj);
        for (size_t f = 0; f < mesh->n_triangles; f += step) {
            const double area = area_px2(mesh, f, rt_obj_cam + 3, photos->cam.intrinsics[0]);
            if (!(area > 0))
                continue;
            weight[(int)fmin(MOST, round(sqrt(2 * area)))] += area;
            total += area;
        }
    }
    int pieces = 1;
    for (below = weight[0] + weight[1]; pieces < MOST - 1 && below < 0.5 * total;)
        below += weight[++pieces];
    // Half of a surface faces a camera. Where triangles are of very different sizes the many small ones would have more texels
    // than all photographs have pixels.
    const double surface_px2 = 2 * (double)step * total / (double)(photos->count ? photos->count : 1);
    int edge = pieces + 1;
    while (edge > SHEEN_TEXTURE_MIN_EDGE &&
           (double)(mesh->n_triangles * sheen_texels_per_triangle(edge)) > most_texels_per_px2 * surface_px2)
        edge--;
    return edge;
}
