// SPDX-License-Identifier: Apache-2.0
// gltf.c - what glTF wants to know of a model: base colour from the global texture and the panorama's irradiance.
#include "render/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/order.h"
#include "base/pose3.h"
#include "base/vec.h"
#include "render/far_lights.h"
#include "render/gltf_specular.h"
#include "render/gltf_surface.h"
#include "render/gltf_write.h"
#include "render/panorama.h"
#include "render/surface_picture.h"

static const double pi = 3.14159265358979323846;
static const double dielectric = SHEEN_DIELECTRIC_F0; // what glTF reflects at normal incidence
// alpha_GGX over sigma: the GGX lobe that is nearest to the normalised Gaussian one, in least squares over small angles;
// the heavy-tailed lobe is one; and between the two the nearest lies on a line, to 0.01.
static const double ggx_per_sigma = 1.32, ggx_per_sigma_of_tail = 2;
static const double brightest = 0.9; // base colour, but for PERCENT of the surface
enum { PANORAMA_HEIGHT_PX = 512, PERCENT = 2 };

void sheen_gltf_release(sheen_gltf *g)
{
    free(g->glb);
    sheen_image_release(&g->panorama);
    sheen_surface_picture_release(&g->surface);
    sheen_image_release(&g->normals);
    sheen_image_release(&g->specular);
    free(g->tangent);
    *g = (sheen_gltf){.glb = NULL};
}

// Board axes (z up) to glTF's (y up): x stays, y = z, z = -y. The box's middle comes above the origin, its foot on it.
static void place_object(sheen_gltf *g, const sheen_mesh *mesh, const double rt_board_obj[6])
{
    sheen_Rt board_obj;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    sheen_Rt_from_rt(&board_obj, rt_board_obj);
    for (int k = 0; k < 3; k++) {
        g->R_gltf_obj[0][k] = board_obj.R[0][k];
        g->R_gltf_obj[1][k] = board_obj.R[2][k];
        g->R_gltf_obj[2][k] = -board_obj.R[1][k];
    }
    for (size_t i = 0; i < mesh->n_vertices; i++)
        for (int k = 0; k < 3; k++) {
            const double p[3] = {(double)mesh->p_obj[3 * i], (double)mesh->p_obj[3 * i + 1],
                                 (double)mesh->p_obj[3 * i + 2]};
            const double x = sheen_dot(g->R_gltf_obj[k], p);
            low[k] = fmin(low[k], x);
            high[k] = fmax(high[k], x);
        }
    for (int k = 0; k < 3; k++)
        g->t_gltf_obj[k] = k == 1 ? -low[1] : -0.5 * (low[k] + high[k]);
    float centre_f[3], radius_m;
    sheen_mesh_sphere(mesh, centre_f, &radius_m);
    const double centre[3] = {(double)centre_f[0], (double)centre_f[1], (double)centre_f[2]};
    for (int k = 0; k < 3; k++)
        g->middle_gltf[k] = sheen_dot(g->R_gltf_obj[k], centre) + g->t_gltf_obj[k];
}

static void irradiance_at(float rgb[3], const sheen_gltf *g, const sheen_image *irradiance, size_t place)
{
    float p_obj[3], n_obj[3], n_env[3];
    sheen_gltf_surface_at(p_obj, n_obj, g, &g->surface.places[place]);
    sheen_gltf_to_env(n_env, g, n_obj);
    sheen_panorama_at(rgb, irradiance, n_env);
}

// The least light from everywhere, L, with which light = f0 L + base (1 - f0) (E + pi L) / pi has no base beyond
// `brightest` on nearly all of the surface.
static sheen_status find_dome(sheen_gltf *g, const sheen_image *irradiance, sheen_err *err)
{
    const sheen_surface_picture *p = &g->surface;
    const double f0 = g->f0;
    const size_t n_px = (size_t)p->charts.side_px * (size_t)p->charts.side_px;
    double *wants = malloc(n_px * sizeof *wants);
    size_t n = 0;
    if (!wants)
        return sheen_fail_memory(err, (double)(n_px * sizeof *wants), "a texture's levels");
    for (size_t i = 0; i < n_px; i++) {
        if (!p->known[i])
            continue;
        float E[3];
        irradiance_at(E, g, irradiance, i);
        double most = 0;
        for (size_t c = 0; c < 3; c++)
            most = fmax(most, (double)p->rgb.data[3 * i + c] - brightest * (1 - f0) * (double)E[c] / pi);
        wants[n++] = most / (brightest * (1 - f0) + f0);
    }
    qsort(wants, n, sizeof *wants, sheen_ascending);
    if (n)
        g->dome_lin = wants[(n - 1) * (100 - PERCENT) / 100];
    free(wants);
    return SHEEN_OK;
}

// Light into base colour, in place.
static void find_base_colour(sheen_gltf *g, const sheen_image *irradiance)
{
    sheen_surface_picture *p = &g->surface;
    const size_t n_px = (size_t)p->charts.side_px * (size_t)p->charts.side_px;
    size_t n_clipped = 0, n = 0;
    for (size_t i = 0; i < n_px; i++) {
        if (!p->known[i])
            continue;
        float E[3];
        irradiance_at(E, g, irradiance, i);
        int clipped = 0;
        for (size_t c = 0; c < 3; c++) {
            const double light = (double)p->rgb.data[3 * i + c] - g->f0 * g->dome_lin;
            const double base = light * pi / fmax((1 - g->f0) * ((double)E[c] + pi * g->dome_lin), 1e-9);
            clipped = clipped || base > 1 || base < 0;
            p->rgb.data[3 * i + c] = (float)fmin(fmax(base, 0), 1);
        }
        n_clipped += (size_t)clipped;
        n++;
    }
    g->clipped = n ? (double)n_clipped / (double)n : 0;
}

static sheen_status make_base_colour(sheen_gltf *g, sheen_err *err)
{
    sheen_image irradiance = {.data = NULL};
    sheen_status s = sheen_gltf_irradiance(&irradiance, &g->panorama, err);
    if (!s)
        s = find_dome(g, &irradiance, err);
    if (!s) {
        const size_t n = 3 * (size_t)g->panorama.width_px * (size_t)g->panorama.height_px;
        find_base_colour(g, &irradiance);
        for (size_t i = 0; i < n; i++)
            g->panorama.data[i] += (float)g->dome_lin;
        s = sheen_image_fill(&g->surface.rgb, g->surface.known, err);
    }
    sheen_image_release(&irradiance);
    return s;
}

// The picture is then what its reader has.
static sheen_status code_picture(uint8_t **jpeg, size_t *jpeg_bytes, sheen_image *lin, int quality,
                                 sheen_err *err)
{
    sheen_raster coded;
    sheen_image decoded = {0};
    sheen_status s = sheen_raster_from_linear(&coded, lin, err);
    if (s)
        return s;
    s = sheen_jpeg_encode(jpeg, jpeg_bytes, &coded, quality, err);
    sheen_raster_release(&coded);
    if (!s)
        s = sheen_raster_parse(&coded, *jpeg, *jpeg_bytes, err);
    if (s)
        return s;
    s = sheen_image_from_raster(&decoded, &coded, SHEEN_TRANSFER_SRGB, err);
    sheen_raster_release(&coded);
    if (s)
        return s;
    sheen_image_release(lin);
    *lin = decoded;
    return SHEEN_OK;
}

static double brightness(const sheen_far_light *l)
{
    return l->power_rgb[0] + l->power_rgb[1] + l->power_rgb[2];
}

// The sum of all lights about lights[best], which are marked; one at a distance shines from there.
static sheen_gltf_light group_about(const sheen_far_light *lights, size_t n, size_t best, uint8_t *taken,
                                    float least_cosine, const sheen_gltf *g)
{
    double direction[3] = {0}, rgb[3] = {0}, per_m = 0, whole = 0, radius_rad = 0;
    for (size_t i = 0; i < n; i++) {
        if (taken[i] || !(sheen_dotf(lights[i].v_env, lights[best].v_env) > least_cosine))
            continue;
        taken[i] = 1;
        whole += brightness(&lights[i]);
        radius_rad = fmax(radius_rad, sqrt(lights[i].solid_angle_sr / pi));
        per_m += brightness(&lights[i]) / lights[i].distance_m;
        for (int k = 0; k < 3; k++) {
            direction[k] += brightness(&lights[i]) * (double)lights[i].v_env[k];
            rgb[k] += lights[i].power_rgb[k] / g->f0;
        }
    }
    sheen_normalize(direction);
    const double most = fmax(rgb[0], fmax(rgb[1], rgb[2])), distance_m = whole / per_m;
    sheen_gltf_light l = {.near = per_m > 0,
                          .radius_rad = radius_rad,
                          .intensity = per_m > 0 ? most * distance_m * distance_m : most};
    for (int k = 0; k < 3; k++) {
        l.direction[k] = direction[k];
        l.position[k] = l.near ? g->middle_gltf[k] + distance_m * direction[k] : 0;
        l.rgb[k] = rgb[k] / most;
    }
    return l;
}

// The strongest lights, each with those that stand about it.
static sheen_status group_lights(sheen_gltf_light *out, size_t *n_out, size_t n_most, float least_cosine,
                                 const sheen_gltf *g, const sheen_model *m, const double rt_world_obj[6],
                                 sheen_err *err)
{
    sheen_far_light *lights;
    size_t n;
    double R_env_obj[3][3];
    memcpy(R_env_obj, g->R_gltf_obj, sizeof R_env_obj);
    *n_out = 0;
    sheen_status s = sheen_far_lights_make(&lights, &n, m, rt_world_obj, R_env_obj, err);
    uint8_t *taken = calloc(n + 1, 1);
    if (!s && !taken)
        s = sheen_fail_memory(err, (double)n, "the model's lights");
    while (!s && *n_out < n_most) {
        size_t best = n;
        for (size_t i = 0; i < n; i++)
            if (!taken[i] && (best == n || brightness(&lights[i]) > brightness(&lights[best])))
                best = i;
        if (best == n)
            break;
        out[(*n_out)++] = group_about(lights, n, best, taken, least_cosine, g);
    }
    free(taken);
    free(lights);
    return s;
}

static bool is_plain(const sheen_model *m)
{
    return !m->shadows && !m->gloss.n && !m->surroundings.present;
}

// What a model has that a panorama has not: in weights and light of its surface.
static sheen_status fit_specular(sheen_gltf *g, const sheen_model *model, const sheen_gltf_options *o,
                                 const sheen_image *dark, sheen_err *err)
{
    sheen_gltf_light lights[SHEEN_GLTF_MAX_LIGHTS];
    size_t n;
    const sheen_status s = group_lights(lights, &n, SHEEN_GLTF_MAX_LIGHTS, 0.9994f, g, model, o->rt_world_obj,
                                        err); // within 2 degrees
    return s ? s : sheen_gltf_fit_specular(g, model, o->rt_world_obj, dark, lights, n, o->n_threads, err);
}

static uint8_t to_u8(float x)
{
    return (uint8_t)lrintf(255 * fmaxf(0, fminf(1, x)));
}

// Of a weight the alpha has what is below 1, the colour (in sRGB, over the most) what is above.
static void code_weight(uint8_t rgba[4], float weight)
{
    const float colour = fmaxf(1, weight) / SHEEN_GLTF_MOST_WEIGHT;
    rgba[0] = rgba[1] = rgba[2] = to_u8(sheen_transfer_encode(SHEEN_TRANSFER_SRGB, colour));
    rgba[3] = to_u8(weight);
}

static sheen_status code_png(uint8_t **png, size_t *png_bytes, const sheen_image *img, bool weights,
                             sheen_err *err)
{
    sheen_raster raster;
    const size_t channels = weights ? 4 : 3;
    *png = NULL;
    if (!img->data)
        return SHEEN_OK;
    sheen_status s = sheen_raster_init(&raster, img->width_px, img->height_px, (int)channels, 8, err);
    if (s)
        return s;
    uint8_t *to = raster.data;
    for (size_t i = 0; i < (size_t)img->width_px * (size_t)img->height_px; i++, to += channels) {
        if (weights)
            code_weight(to, img->data[3 * i]);
        for (size_t c = 0; !weights && c < 3; c++)
            to[c] = to_u8(img->data[3 * i + c]);
    }
    s = sheen_png_encode(png, png_bytes, &raster, err);
    sheen_raster_release(&raster);
    return s;
}

static bool has_fresnel(const sheen_model *m)
{
    return m->surroundings.present || (m->n_lamps && m->lobe_fresnel > 0);
}

static sheen_status write_it(sheen_gltf *g, const sheen_model *model, const sheen_gltf_options *o,
                             sheen_err *err)
{
    sheen_surface_picture *p = &g->surface;
    sheen_gltf_parts parts = {.title = o->title,
                              .mesh = &p->mesh,
                              .charts = &p->charts,
                              .R_gltf_obj = g->R_gltf_obj,
                              .t_gltf_obj = g->t_gltf_obj,
                              .roughness = g->roughness,
                              .specular_factor = g->specular_factor,
                              .specular_colour = g->specular_colour *
                                                 (g->specular.data ? (double)SHEEN_GLTF_MOST_WEIGHT : 1),
                              .tangent = g->tangent};
    uint8_t *jpeg = NULL, *normals = NULL, *specular = NULL;
    sheen_gltf_light lights[SHEEN_GLTF_MAX_LIGHTS];
    sheen_status s = code_picture(&jpeg, &parts.jpeg_bytes, &p->rgb, o->jpeg_quality, err);
    if (!s)
        s = code_png(&normals, &parts.normals_bytes, &g->normals, false, err);
    if (!s)
        s = code_png(&specular, &parts.specular_bytes, &g->specular, true, err);
    parts.jpeg = jpeg;
    parts.normals = normals;
    parts.specular = specular;
    parts.lights = lights;
    const int n_most = o->n_lights < SHEEN_GLTF_MAX_LIGHTS ? o->n_lights : SHEEN_GLTF_MAX_LIGHTS;
    if (!s && n_most > 0)
        s = group_lights(lights, &parts.n_lights, (size_t)n_most, 0.99f, g, model, o->rt_world_obj,
                         err); // 8 degrees
    g->n_lights = (int)parts.n_lights;
    if (!s)
        s = sheen_gltf_write(&g->glb, &g->glb_bytes, &parts, err);
    free(jpeg);
    free(normals);
    free(specular);
    return s;
}

sheen_status sheen_gltf_make(sheen_gltf *out, const sheen_model *model, const sheen_gltf_options *o,
                             sheen_err *err)
{
    const bool own_f0 = model->surroundings.present && model->surroundings.f0 > 0;
    const double f0 = own_f0 ? model->surroundings.f0 : dielectric;
    *out = (sheen_gltf){.f0 = f0,
                        .specular_factor = has_fresnel(model) ? 1 : f0,
                        .specular_colour = has_fresnel(model) ? f0 / dielectric : 1 / dielectric};
    sheen_surface_picture *p = &out->surface;
    const double tail = model->n_lamps ? model->lobe_tail : 0;
    out->roughness = sqrt(
        fmin(1, (ggx_per_sigma + tail * (ggx_per_sigma_of_tail - ggx_per_sigma)) * model->sigma_rad));
    sheen_status s = sheen_surface_picture_make(p, model, o->max_triangles, o->max_side_px, err);
    if (s)
        return s;
    out->n_triangles = p->mesh.n_triangles;
    out->side_px = p->charts.side_px;
    out->moved_m = p->moved_m;
    place_object(out, &model->mesh, o->rt_board_obj);
    sheen_image dark = {.data = NULL};
    s = sheen_panorama_make(&dark, model, o->rt_world_obj, out->R_gltf_obj, PANORAMA_HEIGHT_PX, err);
    if (!s)
        s = sheen_panorama_make(&out->panorama, model, o->rt_world_obj, out->R_gltf_obj, PANORAMA_HEIGHT_PX,
                                err);
    if (!s)
        s = sheen_panorama_add_lights(&out->panorama, model, o->rt_world_obj, out->R_gltf_obj, out->f0, err);
    if (!s && p->n_obj.data)
        s = sheen_gltf_tangents(&out->tangent, p, err);
    if (!s)
        s = sheen_gltf_normal_picture(&out->normals, out, model, err);
    if (!s && !is_plain(model))
        s = fit_specular(out, model, o, &dark, err);
    sheen_image_release(&dark);
    if (!s)
        s = make_base_colour(out, err);
    if (!s)
        s = write_it(out, model, o, err);
    if (s)
        sheen_gltf_release(out);
    return s;
}
