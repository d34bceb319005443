// SPDX-License-Identifier: Apache-2.0
// register_pictures.c - masks made smaller by area, and their centres.
#include "pose/register_pictures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "calib/cholesky.h"

static const double MIN_AREA_PX = 64; // of a mask that shows something

void sheen_register_pictures_release(sheen_register_pictures *p)
{
    for (size_t i = 0; i < p->n_views && p->outlines; i++)
        sheen_outline_release(&p->outlines[i]);
    free(p->views);
    free(p->outlines);
    free(p->pixels);
    *p = (sheen_register_pictures){0};
}

// Longest side of the box round the mask's inside; 0 where there is too little of it.
static double side_px(const sheen_image *mask)
{
    int box[4] = {INT32_MAX, INT32_MAX, -1, -1};
    double area = 0;
    for (int y = 0; y < mask->height_px; y++)
        for (int x = 0; x < mask->width_px; x++)
            if (mask->data[(size_t)y * (size_t)mask->width_px + (size_t)x] >= 0.5f) {
                area++;
                box[0] = x < box[0] ? x : box[0];
                box[1] = y < box[1] ? y : box[1];
                box[2] = x > box[2] ? x : box[2];
                box[3] = y > box[3] ? y : box[3];
            }
    return area < MIN_AREA_PX ? 0 : 1 + fmax(box[2] - box[0], box[3] - box[1]);
}

// Mean over the part of the picture under each small pixel, of what is known; negative where half or more of it is not.
static void shrink(float *out, int width_px, int height_px, const sheen_image *in, double factor)
{
    for (int y = 0; y < height_px; y++)
        for (int x = 0; x < width_px; x++) {
            const int x0 = (int)floor(x / factor), y0 = (int)floor(y / factor);
            int x1 = (int)floor((x + 1) / factor), y1 = (int)floor((y + 1) / factor);
            x1 = x1 > in->width_px ? in->width_px : x1 > x0 ? x1 : x0 + 1;
            y1 = y1 > in->height_px ? in->height_px : y1 > y0 ? y1 : y0 + 1;
            double sum = 0;
            int n = 0;
            for (int j = y0; j < y1; j++)
                for (int i = x0; i < x1; i++) {
                    const float v = in->data[(size_t)j * (size_t)in->width_px + (size_t)i];
                    n += v >= 0;
                    sum += v >= 0 ? (double)v : 0;
                }
            out[(size_t)y * (size_t)width_px + (size_t)x] = 2 * n > (x1 - x0) * (y1 - y0) ? (float)(sum / n)
                                                                                          : -1.0f;
        }
}

static int descending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static void fill_view(sheen_outline_view *out, float *mask, float *light, const sheen_camera *camera,
                      const sheen_register_view *view, double factor)
{
    out->canvas = (sheen_outline_canvas){.camera = camera,
                                         .factor = factor,
                                         .width_px = (int)fmax(8, floor(camera->width_px * factor)),
                                         .height_px = (int)fmax(8, floor(camera->height_px * factor))};
    sheen_Rt_from_rt(&out->canvas.Rt_cam_board, view->rt_cam_board);
    shrink(mask, out->canvas.width_px, out->canvas.height_px, view->mask, factor);
    out->mask = mask;
    out->light = NULL;
    if (light) {
        shrink(light, out->canvas.width_px, out->canvas.height_px, view->light, factor);
        out->light = light;
    }
}

sheen_status sheen_register_pictures_make(sheen_register_pictures *out, const sheen_camera *camera,
                                          const sheen_register_view *views, size_t n_views, size_t max_views,
                                          double size_px, sheen_err *err)
{
    *out = (sheen_register_pictures){0};
    double *sides = malloc((2 * n_views + 2) * sizeof *sides);
    if (!sides)
        return sheen_fail_memory(err, (double)n_views * 16, "masks");
    double *sorted = sides + n_views + 1;
    size_t n_seen = 0;
    for (size_t i = 0; i < n_views; i++) {
        sides[i] = side_px(views[i].mask);
        if (sides[i] > 0)
            sorted[n_seen++] = sides[i];
    }
    if (!n_seen) {
        free(sides);
        return sheen_fail(err, SHEEN_EDATA, "no mask shows the object");
    }
    qsort(sorted, n_seen, sizeof *sorted, descending);
    out->factor = fmin(1, size_px / sorted[n_seen / 2]);
    const size_t n = n_seen < max_views ? n_seen : max_views;
    const size_t pixels = (size_t)fmax(8, floor(camera->width_px * out->factor)) *
                          (size_t)fmax(8, floor(camera->height_px * out->factor));
    out->views = calloc(n, sizeof *out->views);
    out->outlines = calloc(n, sizeof *out->outlines);
    out->pixels = malloc(2 * n * pixels * sizeof *out->pixels);
    if (!out->views || !out->outlines || !out->pixels) {
        free(sides);
        sheen_register_pictures_release(out);
        return sheen_fail_memory(err, 8.0 * (double)n * (double)pixels, "masks");
    }
    size_t seen = 0;
    for (size_t i = 0; i < n_views; i++) {
        if (!(sides[i] > 0))
            continue;
        if (seen++ * n / n_seen == out->n_views && out->n_views < n) { // every (n_seen / n)th
            float *mask = out->pixels + 2 * out->n_views * pixels;
            fill_view(&out->views[out->n_views++], mask, views[i].light ? mask + pixels : NULL, camera,
                      &views[i], out->factor);
        }
    }
    free(sides);
    return SHEEN_OK;
}

sheen_status sheen_register_centre(double centre_board[3], const sheen_register_pictures *p, sheen_err *err)
{
    double A[9] = {0}, b[3] = {0};
    for (size_t v = 0; v < p->n_views; v++) {
        const sheen_outline_canvas *c = &p->views[v].canvas;
        double n = 0, q[2] = {0}, direction[3], eye[3];
        for (int y = 0; y < c->height_px; y++)
            for (int x = 0; x < c->width_px; x++) {
                const double m = fmax(0,
                                      (double)p->views[v].mask[(size_t)y * (size_t)c->width_px + (size_t)x]);
                n += m;
                q[0] += m * x;
                q[1] += m * y;
            }
        for (int k = 0; k < 2; k++)
            q[k] = (q[k] / n + 0.5) / c->factor - 0.5;
        const sheen_status s = sheen_camera_unproject(c->camera, direction, q, 1, err);
        if (s)
            return s;
        if (!isfinite(direction[0] + direction[1] + direction[2]))
            continue;
        sheen_Rt Rt_board_cam;
        sheen_Rt_invert(&Rt_board_cam, &c->Rt_cam_board);
        sheen_Rt_direction(direction, &Rt_board_cam, direction);
        memcpy(eye, Rt_board_cam.t, sizeof eye);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                const double across = (i == j) - direction[i] * direction[j];
                A[3 * i + j] += across;
                b[i] += across * eye[j];
            }
    }
    memcpy(centre_board, b, sizeof b);
    if (!sheen_cholesky(A, 3))
        return sheen_fail(err, SHEEN_EDATA,
                          "the masks' views do not tell where the object is: take them from "
                          "several sides");
    sheen_cholesky_solve(centre_board, A, 3);
    return SHEEN_OK;
}

double sheen_register_mask_area(const sheen_register_pictures *p)
{
    double sum = 0;
    for (size_t v = 0; v < p->n_views; v++) {
        const sheen_outline_canvas *c = &p->views[v].canvas;
        for (size_t i = 0; i < (size_t)c->width_px * (size_t)c->height_px; i++)
            sum += fmax(0, (double)p->views[v].mask[i]);
    }
    return sum;
}

double sheen_register_cover_area(const sheen_register_pictures *p)
{
    double sum = 0;
    for (size_t v = 0; v < p->n_views; v++)
        for (size_t i = 0; i < (size_t)p->outlines[v].width_px * (size_t)p->outlines[v].height_px; i++)
            sum += p->views[v].mask[i] >= 0 ? p->outlines[v].cover[i] : 0;
    return sum;
}
