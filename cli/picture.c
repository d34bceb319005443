// SPDX-License-Identifier: Apache-2.0
// picture.c - a drawn view as a file.
#include "cli/picture.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/image_file.h"
#include "render/draw_geometry.h"

static const char *const appearance[] = {"all", "diffuse", "specular"};
static const char *const geometry[] = {"mask", "normal", "depth"};

bool sheen_cli_layer_is_geometry(const char *layer)
{
    for (int i = 0; i < 3 && layer; i++)
        if (!strcmp(layer, geometry[i]))
            return true;
    return false;
}

bool sheen_cli_layer_known(const char *layer)
{
    for (int i = 0; i < 3 && layer; i++)
        if (!strcmp(layer, appearance[i]))
            return true;
    return !layer || sheen_cli_layer_is_geometry(layer);
}

static bool is_exr(const char *path)
{
    return !strcasecmp(sheen_path_extension(path), "exr");
}

// One or three channels of numbers 0..1 as they are, 8 bits.
static sheen_status write_numbers(const char *path, const sheen_image *img, float scale, float offset,
                                  sheen_err *err)
{
    const size_t n = (size_t)img->width_px * (size_t)img->height_px * (size_t)img->n_channels;
    sheen_raster r = {malloc(n), img->width_px, img->height_px, img->n_channels, 8};
    if (!r.data)
        return sheen_fail_memory(err, (double)n, "a picture");
    for (size_t i = 0; i < n; i++)
        ((uint8_t *)r.data)[i] = (uint8_t)(255 * (img->data[i] * scale + offset) + 0.5f);
    const sheen_status st = sheen_png_write(path, &r, err);
    free(r.data);
    return st;
}

static sheen_status save_geometry(const char *layer, const sheen_cli_view *v, const sheen_camera *cam,
                                  const double rt_cam_obj[6], const char *path, sheen_err *err)
{
    static const char *const depth_name[] = {"Z"}, *const normal_names[] = {"NX", "NY", "NZ"};
    sheen_geometry g;
    sheen_status st = sheen_draw_geometry(&g, v->drawing, cam, rt_cam_obj, v->options.n_threads, err);
    if (st)
        return st;
    if (!strcmp(layer, "depth"))
        st = sheen_exr_write(path, &g.depth_m, depth_name, false, err);
    else if (!strcmp(layer, "normal"))
        st = is_exr(path) ? sheen_exr_write(path, &g.n_cam, normal_names, false, err)
                          : write_numbers(path, &g.n_cam, 0.5f, 0.5f, err);
    else
        st = is_exr(path) ? sheen_exr_write(path, &g.mask, NULL, true, err)
                          : write_numbers(path, &g.mask, 1, 0, err);
    sheen_geometry_release(&g);
    return st;
}

// The colour that is seen of each pixel's share of the object, and that share: PNG keeps the two apart, EXR
// multiplied.
static sheen_status with_alpha(sheen_image *out, const sheen_image *rgb, const sheen_image *coverage,
                               bool multiplied, sheen_err *err)
{
    const sheen_status st = sheen_image_init(out, rgb->width_px, rgb->height_px, 4, err);
    const size_t n = (size_t)rgb->width_px * (size_t)rgb->height_px;
    for (size_t i = 0; i < n && !st; i++) {
        const float alpha = coverage->data[i], over = multiplied || !(alpha > 0) ? 1 : 1 / alpha;
        for (int c = 0; c < 3; c++)
            out->data[4 * i + (size_t)c] = rgb->data[3 * i + (size_t)c] * over;
        out->data[4 * i + 3] = alpha;
    }
    return st;
}

static sheen_status write(const char *path, const sheen_image *img, sheen_err *err)
{
    return is_exr(path) ? sheen_exr_write(path, img, NULL, true, err) : sheen_png_write_srgb(path, img, err);
}

sheen_status sheen_cli_picture_save(const sheen_cli_picture *p, const sheen_cli_view *v,
                                    const sheen_camera *cam, const double rt_cam_obj[6], const char *path,
                                    sheen_err *err)
{
    if (sheen_cli_layer_is_geometry(p->layer))
        return save_geometry(p->layer, v, cam, rt_cam_obj, path, err);
    sheen_cli_view own = *v;
    sheen_layers layers = {0};
    sheen_image rgba = {0};
    if (p->transparent)
        memset(own.options.background_rgb, 0, sizeof own.options.background_rgb);
    sheen_status st = sheen_cli_view_draw(&layers, &own, cam, rt_cam_obj, err);
    const sheen_image *rgb = sheen_cli_layer(&layers, p->layer);
    if (!st && p->transparent)
        st = with_alpha(&rgba, rgb, &layers.coverage, is_exr(path), err);
    if (!st)
        st = write(path, p->transparent ? &rgba : rgb, err);
    sheen_image_release(&rgba);
    sheen_layers_release(&layers);
    return st;
}
