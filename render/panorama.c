// SPDX-License-Identifier: Apache-2.0
// panorama.c - node lights and surroundings, splatted into an equirectangular picture, and its irradiance.
#include "render/panorama.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/pose3.h"
#include "base/vec.h"
#include "render/far_lights.h"

static const double pi = 3.14159265358979323846;

void sheen_panorama_direction(float v_env[3], const sheen_image *panorama, int x, int y)
{
    const double azimuth = ((x + 0.5) / panorama->width_px - 0.5) * 2 * pi,
                 elevation = (0.5 - (y + 0.5) / panorama->height_px) * pi;
    v_env[0] = (float)(cos(elevation) * cos(azimuth));
    v_env[1] = (float)sin(elevation);
    v_env[2] = (float)(cos(elevation) * sin(azimuth));
}

double sheen_panorama_pixel_sr(const sheen_image *panorama, int y)
{
    const double step = pi / panorama->height_px, top = pi / 2 - y * step;
    return 2 * pi / panorama->width_px * (sin(top) - sin(top - step));
}

// The picture's right side meets its left one.
void sheen_panorama_at(float rgb[3], const sheen_image *panorama, const float v_env[3])
{
    const float turns = atan2f(v_env[2], v_env[0]) / (float)(2 * pi),
                height = asinf(fmaxf(-1, fminf(1, v_env[1]))) / (float)pi;
    const float x = (turns + 0.5f) * (float)panorama->width_px - 0.5f,
                y = (0.5f - height) * (float)panorama->height_px - 0.5f, left = floorf(x), top = floorf(y);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int dy = 0; dy < 2; dy++)
        for (int dx = 0; dx < 2; dx++) {
            const int w = panorama->width_px, h = panorama->height_px, row = (int)top + dy;
            const float *from = sheen_image_at(panorama, ((int)left + dx + w) % w,
                                               row < 0 ? 0 : (row < h ? row : h - 1));
            const float share = (dx ? x - left : 1 - x + left) * (dy ? y - top : 1 - y + top);
            for (int c = 0; c < 3; c++)
                rgb[c] += share * from[c];
        }
}

// Adds to the pixels whose centres lie in a disc (rgb NULL: to none), and returns the solid angle of those.
static double splat(sheen_image *img, const float l_env[3], float least_cosine, const float rgb[3])
{
    const double radius = acos((double)least_cosine), elevation = asin(fmax(-1, fmin(1, (double)l_env[1])));
    const double row_of = img->height_px / pi;
    const int y0 = (int)fmax(0, floor((pi / 2 - elevation - radius) * row_of) - 1),
              y1 = (int)fmin(img->height_px - 1, ceil((pi / 2 - elevation + radius) * row_of) + 1);
    double sr = 0;
    for (int y = y0; y <= y1; y++)
        for (int x = 0; x < img->width_px; x++) {
            float v[3];
            sheen_panorama_direction(v, img, x, y);
            if (!(sheen_dotf(v, l_env) >= least_cosine))
                continue;
            float *to = sheen_image_at(img, x, y);
            sr += sheen_panorama_pixel_sr(img, y);
            for (int c = 0; rgb && c < 3; c++)
                to[c] += rgb[c];
        }
    return sr;
}

// The disc is given the light's power whatever pixels it has.
static void add_light(sheen_image *img, const float l_env[3], const double power_rgb[3],
                      double solid_angle_sr)
{
    const double pixel_rad = pi / img->height_px;
    double least = 1 - solid_angle_sr / (2 * pi);
    least = fmin(least, cos(pixel_rad)); // a pixel or more
    const double sr = splat(img, l_env, (float)least, NULL);
    if (!(sr > 0))
        return;
    const float rgb[3] = {(float)(power_rgb[0] / sr), (float)(power_rgb[1] / sr), (float)(power_rgb[2] / sr)};
    splat(img, l_env, (float)least, rgb);
}

static void add_surroundings(sheen_image *img, const sheen_model *m, const sheen_Rt *world_obj,
                             double R_env_obj[3][3])
{
    float centre_obj[3], radius_m, centre_world[3];
    sheen_mesh_sphere(&m->mesh, centre_obj, &radius_m);
    for (int k = 0; k < 3; k++)
        centre_world[k] = (float)(world_obj->R[k][0] * (double)centre_obj[0] +
                                  world_obj->R[k][1] * (double)centre_obj[1] +
                                  world_obj->R[k][2] * (double)centre_obj[2] + world_obj->t[k]);
    for (int y = 0; y < img->height_px; y++)
        for (int x = 0; x < img->width_px; x++) {
            float v_env[3], v_world[3], rgb[3];
            double v_obj[3];
            sheen_panorama_direction(v_env, img, x, y);
            for (int k = 0; k < 3; k++)
                v_obj[k] = R_env_obj[0][k] * (double)v_env[0] + R_env_obj[1][k] * (double)v_env[1] +
                           R_env_obj[2][k] * (double)v_env[2];
            for (int k = 0; k < 3; k++)
                v_world[k] = (float)sheen_dot(world_obj->R[k], v_obj);
            sheen_surroundings_radiance(rgb, &m->surroundings, centre_world, v_world);
            for (int c = 0; c < 3; c++)
                sheen_image_at(img, x, y)[c] = rgb[c];
        }
}

sheen_status sheen_panorama_make(sheen_image *out, const sheen_model *model, const double rt_world_obj[6],
                                 double R_env_obj[3][3], int height_px, sheen_err *err)
{
    sheen_Rt world_obj;
    const sheen_status s = sheen_image_init(out, 2 * height_px, height_px, 3, err);
    if (s)
        return s;
    sheen_Rt_from_rt(&world_obj, rt_world_obj);
    if (model->surroundings.present)
        add_surroundings(out, model, &world_obj, R_env_obj);
    return SHEEN_OK;
}

sheen_status sheen_panorama_add_lights(sheen_image *panorama, const sheen_model *model,
                                       const double rt_world_obj[6], double R_env_obj[3][3], double f0,
                                       sheen_err *err)
{
    sheen_far_light *lights;
    size_t n;
    const sheen_status s = sheen_far_lights_make(&lights, &n, model, rt_world_obj, R_env_obj, err);
    for (size_t i = 0; !s && i < n; i++) {
        const double *power = lights[i].power_rgb, rgb[3] = {power[0] / f0, power[1] / f0, power[2] / f0};
        add_light(panorama, lights[i].v_env, rgb, lights[i].solid_angle_sr);
    }
    free(lights);
    return s;
}

// Sums over blocks of pixels stand for them: the cosine changes little within 3 degrees.
sheen_status sheen_panorama_irradiance(float *rgb, const float *n_env, size_t n, const sheen_image *panorama,
                                       sheen_err *err)
{
    enum { ROWS = 64 };
    sheen_image sums;
    const sheen_status s = sheen_image_init(&sums, 2 * ROWS, ROWS, 3, err);
    if (s)
        return s;
    for (int y = 0; y < panorama->height_px; y++)
        for (int x = 0; x < panorama->width_px; x++) {
            const float *from = sheen_image_at(panorama, x, y);
            float *to = sheen_image_at(&sums, x * 2 * ROWS / panorama->width_px,
                                       y * ROWS / panorama->height_px);
            for (int c = 0; c < 3; c++)
                to[c] += from[c] * (float)sheen_panorama_pixel_sr(panorama, y);
        }
    memset(rgb, 0, 3 * n * sizeof *rgb);
    for (int y = 0; y < ROWS; y++)
        for (int x = 0; x < 2 * ROWS; x++) {
            float v[3];
            const float *light = sheen_image_at(&sums, x, y);
            sheen_panorama_direction(v, &sums, x, y);
            for (size_t i = 0; i < n && (light[0] > 0 || light[1] > 0 || light[2] > 0); i++) {
                const float cosine = sheen_dotf(v, n_env + 3 * i);
                for (size_t c = 0; cosine > 0 && c < 3; c++)
                    rgb[3 * i + c] += cosine * light[c];
            }
        }
    sheen_image_release(&sums);
    return SHEEN_OK;
}
