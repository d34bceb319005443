// SPDX-License-Identifier: Apache-2.0
// scene_embree.c - ray tracing through Embree: the one file of render that includes it.
//
// The mesh is copied into Embree's buffers; rays go through in streams of STREAM rays laid out component by
// component, which Embree cuts into packets of the processor's width. Two choices keep answers repeatable:
//
//   * the structure is built by one thread, because Embree's parallel build orders triangles by chance and
//     with it decides which of two triangles owns a ray through their common edge;
//   * "robust" intersection, so that no ray slips between two triangles.
#include "render/scene.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <embree3/rtcore.h>

#include "base/vec.h"

enum { STREAM = 256 };

struct sheen_scene {
    RTCDevice device;
    RTCScene scene;
};

static sheen_status fail_rtc(RTCDevice device, sheen_err *err)
{
    const enum RTCError code = rtcGetDeviceError(device);
    if (code == RTC_ERROR_OUT_OF_MEMORY)
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory while preparing the mesh for ray tracing");
    return sheen_fail(err, SHEEN_EUNSUP, "cannot trace rays on this machine (Embree error %d)", (int)code);
}

static sheen_status add_mesh(sheen_scene *s, const sheen_mesh *mesh, sheen_err *err)
{
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry)
        return fail_rtc(s->device, err);
    const size_t vertex_bytes = 3 * sizeof(float), triangle_bytes = 3 * sizeof(uint32_t);
    void *p = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertex_bytes,
                                      mesh->n_vertices);
    void *t = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangle_bytes,
                                      mesh->n_triangles);
    if (!p || !t) {
        rtcReleaseGeometry(geometry);
        return fail_rtc(s->device, err);
    }
    memcpy(p, mesh->p_obj, mesh->n_vertices * vertex_bytes);
    memcpy(t, mesh->triangles, mesh->n_triangles * triangle_bytes);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(s->scene, geometry);
    rtcReleaseGeometry(geometry); // the scene keeps it
    rtcCommitScene(s->scene);
    return rtcGetDeviceError(s->device) == RTC_ERROR_NONE ? SHEEN_OK : fail_rtc(s->device, err);
}

sheen_status sheen_scene_new(sheen_scene **out, const sheen_mesh *mesh, sheen_err *err)
{
    *out = NULL;
    sheen_status status = SHEEN_OK;
    sheen_scene *s = calloc(1, sizeof *s);
    if (!s)
        return sheen_fail_memory(err, (double)sizeof *s, "the ray tracer");
    s->device = rtcNewDevice("threads=1,set_affinity=0");
    if (!s->device) {
        status = fail_rtc(NULL, err);
        goto done;
    }
    s->scene = rtcNewScene(s->device);
    if (!s->scene) {
        status = fail_rtc(s->device, err);
        goto done;
    }
    rtcSetSceneFlags(s->scene, RTC_SCENE_FLAG_ROBUST);
    status = add_mesh(s, mesh, err);

done:
    if (status)
        sheen_scene_free(&s);
    *out = s;
    return status;
}

void sheen_scene_free(sheen_scene **scene)
{
    sheen_scene *s = *scene;
    if (!s)
        return;
    if (s->scene)
        rtcReleaseScene(s->scene);
    if (s->device)
        rtcReleaseDevice(s->device);
    free(s);
    *scene = NULL;
}

// A stream of rays and their hits, component by component.
typedef struct stream {
    _Alignas(64) float org_x[STREAM];
    float org_y[STREAM], org_z[STREAM], tnear[STREAM];
    float dir_x[STREAM], dir_y[STREAM], dir_z[STREAM], tfar[STREAM];
    float ng_x[STREAM], ng_y[STREAM], ng_z[STREAM], u[STREAM], v[STREAM];
    unsigned int mask[STREAM], id[STREAM], flags[STREAM];
    unsigned int primitive[STREAM], geometry[STREAM], instance[STREAM];
} stream;

static struct RTCRayHitNp pointers(stream *s)
{
    struct RTCRayHitNp p = {
        .ray = {.org_x = s->org_x,
                .org_y = s->org_y,
                .org_z = s->org_z,
                .tnear = s->tnear,
                .dir_x = s->dir_x,
                .dir_y = s->dir_y,
                .dir_z = s->dir_z,
                .time = NULL,
                .tfar = s->tfar,
                .mask = s->mask,
                .id = s->id,
                .flags = s->flags},
        .hit = {.Ng_x = s->ng_x,
                .Ng_y = s->ng_y,
                .Ng_z = s->ng_z,
                .u = s->u,
                .v = s->v,
                .primID = s->primitive,
                .geomID = s->geometry},
    };
    p.hit.instID[0] = s->instance;
    return p;
}

// A direction that is not finite (a pixel through which the lens has no ray) makes a ray of no length.
static void set_ray(stream *s, size_t i, const float *origin, const float *dir, float tnear, float tfar)
{
    static const float none[3] = {0, 0, 1};
    if (!isfinite(dir[0] + dir[1] + dir[2])) {
        dir = none;
        tfar = -1;
    }
    s->org_x[i] = origin[0];
    s->org_y[i] = origin[1];
    s->org_z[i] = origin[2];
    s->dir_x[i] = dir[0];
    s->dir_y[i] = dir[1];
    s->dir_z[i] = dir[2];
    s->tnear[i] = tnear;
    s->tfar[i] = tfar;
    s->mask[i] = UINT32_MAX;
    s->id[i] = (unsigned int)i;
    s->flags[i] = 0;
    s->geometry[i] = s->primitive[i] = s->instance[i] = RTC_INVALID_GEOMETRY_ID;
}

static struct RTCIntersectContext coherent_context(void)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}

static sheen_hit hit_of(const stream *s, size_t i)
{
    if (s->geometry[i] == RTC_INVALID_GEOMETRY_ID)
        return (sheen_hit){.triangle = SHEEN_NO_HIT};
    // Robust intersection may place a hit a rounding error outside its triangle.
    const float b1 = s->u[i] > 0 ? s->u[i] : 0, b2 = s->v[i] > 0 ? s->v[i] : 0;
    const float over = b1 + b2 > 1 ? 1 / (b1 + b2) : 1;
    return (sheen_hit){.triangle = s->primitive[i], .b1 = b1 * over, .b2 = b2 * over, .t_m = s->tfar[i]};
}

void sheen_scene_first_hits(const sheen_scene *scene, sheen_hit *hits, const float *origin_obj,
                            int shared_origin, const float *v_obj, size_t n)
{
    stream s;
    const struct RTCRayHitNp p = pointers(&s);
    struct RTCIntersectContext context = coherent_context();
    for (size_t begin = 0; begin < n; begin += STREAM) {
        const size_t count = n - begin < STREAM ? n - begin : STREAM;
        for (size_t i = 0; i < count; i++)
            set_ray(&s, i, origin_obj + (shared_origin ? 0 : 3 * (begin + i)), v_obj + 3 * (begin + i), 0,
                    INFINITY);
        rtcIntersectNp(scene->scene, &context, &p, (unsigned int)count);
        for (size_t i = 0; i < count; i++)
            hits[begin + i] = hit_of(&s, i);
    }
}

// Rays run from the common target to the points: they share their origin and stay together in the structure.
void sheen_scene_occluded(const sheen_scene *scene, uint8_t *occluded, const float *p_obj, size_t n,
                          const float target_obj[3], float offset_m)
{
    stream s;
    const struct RTCRayHitNp p = pointers(&s);
    struct RTCIntersectContext context = coherent_context();
    for (size_t begin = 0; begin < n; begin += STREAM) {
        const size_t count = n - begin < STREAM ? n - begin : STREAM;
        for (size_t i = 0; i < count; i++) {
            float dir[3];
            sheen_subf(dir, p_obj + 3 * (begin + i), target_obj);
            const float length_m = sheen_normalizef(dir);
            set_ray(&s, i, target_obj, dir, offset_m, length_m - offset_m);
        }
        rtcOccludedNp(scene->scene, &context, &p.ray, (unsigned int)count);
        for (size_t i = 0; i < count; i++)
            occluded[begin + i] = s.tfar[i] == -INFINITY;
    }
}

bool sheen_scene_blocked(const sheen_scene *scene, const float origin_obj[3], const float v_obj[3])
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay ray = {.org_x = origin_obj[0],
                         .org_y = origin_obj[1],
                         .org_z = origin_obj[2],
                         .dir_x = v_obj[0],
                         .dir_y = v_obj[1],
                         .dir_z = v_obj[2],
                         .tfar = INFINITY,
                         .mask = UINT32_MAX};
    rtcOccluded1(scene->scene, &context, &ray);
    return ray.tfar == -INFINITY;
}
