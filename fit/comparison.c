// SPDX-License-Identifier: Apache-2.0
// comparison.c - the side-by-side picture of an evaluation.
#include "fit/comparison.h"

#include <stdio.h>
#include <string.h>

#include "base/image_file.h"

enum { N_PANELS = 5, MARGIN_PX = 12, GAP_PX = 4 };

static int clamp(int x, int lo, int hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

// The box of the object's pixels with a margin.
static void find_cut(sheen_comparison *c, const sheen_image *photo, const uint8_t *object)
{
    int x0 = photo->width_px, y0 = photo->height_px, x1 = -1, y1 = -1;
    for (int y = 0; y < photo->height_px; y++)
        for (int x = 0; x < photo->width_px; x++)
            if (object[(size_t)y * (size_t)photo->width_px + (size_t)x]) {
                x0 = x < x0 ? x : x0;
                x1 = x > x1 ? x : x1;
                y0 = y < y0 ? y : y0;
                y1 = y;
            }
    if (x1 < 0)
        x0 = y0 = x1 = y1 = 0;
    c->x0_px = clamp(x0 - MARGIN_PX, 0, photo->width_px - 1);
    c->y0_px = clamp(y0 - MARGIN_PX, 0, photo->height_px - 1);
    c->width_px = clamp(x1 + MARGIN_PX, 0, photo->width_px - 1) - c->x0_px + 1;
    c->height_px = clamp(y1 + MARGIN_PX, 0, photo->height_px - 1) - c->y0_px + 1;
}

static void put_panel(sheen_comparison *c, int panel, const sheen_image *img)
{
    for (int y = 0; y < c->height_px; y++)
        memcpy(sheen_image_at(&c->strip, panel * (c->width_px + GAP_PX), y),
               sheen_image_at(img, c->x0_px, c->y0_px + y), (size_t)c->width_px * 3 * sizeof(float));
}

// Differences of sRGB code values, four times enlarged, grey where there is none; as light, for the writer codes it.
static void put_difference(sheen_comparison *c, int panel, const sheen_image *a, const sheen_image *b)
{
    for (int y = 0; y < c->height_px; y++)
        for (int x = 0; x < 3 * c->width_px; x++) {
            const float *pa = sheen_image_at(a, c->x0_px, c->y0_px + y) + x;
            const float *pb = sheen_image_at(b, c->x0_px, c->y0_px + y) + x;
            const float d = sheen_transfer_encode(SHEEN_TRANSFER_SRGB, *pa < 1 ? *pa : 1) -
                            sheen_transfer_encode(SHEEN_TRANSFER_SRGB, *pb < 1 ? *pb : 1);
            const float code = 0.5f + 4 * d;
            sheen_image_at(&c->strip, panel * (c->width_px + GAP_PX),
                           y)[x] = sheen_transfer_decode(SHEEN_TRANSFER_SRGB, code < 0   ? 0
                                                                              : code > 1 ? 1
                                                                                         : code);
        }
}

static sheen_status start_strip(sheen_comparison *c, const sheen_photo *photo, const uint8_t *object)
{
    sheen_image_release(&c->strip);
    find_cut(c, &photo->image, object);
    const int width_px = N_PANELS * c->width_px + (N_PANELS - 1) * GAP_PX;
    const sheen_status s = sheen_image_init(&c->strip, width_px, c->height_px, 3, &c->err);
    for (size_t i = 0; !s && i < (size_t)width_px * (size_t)c->height_px * 3; i++)
        c->strip.data[i] = 1;
    return s;
}

static sheen_status write_strip(sheen_comparison *c, const char *view)
{
    char name[80], path[SHEEN_PATH_MAX];
    snprintf(name, sizeof name, "%s.png", view);
    const sheen_status s = sheen_path_join(path, c->dir, name, &c->err);
    return s ? s : sheen_png_write_srgb(path, &c->strip, &c->err);
}

void sheen_comparison_add(void *self, const sheen_photo *photo, int method, const sheen_image *rendered,
                          const uint8_t *object)
{
    sheen_comparison *c = self;
    if (!c->status && method == 0)
        c->status = start_strip(c, photo, object);
    if (c->status)
        return;
    if (method == 0) {
        put_panel(c, 0, &photo->image);
        put_panel(c, 1, rendered);
        put_difference(c, 2, rendered, &photo->image);
    } else if (method == 1 + SHEEN_BASELINE_MINIMUM) {
        put_panel(c, 3, rendered);
    } else if (method == 1 + SHEEN_BASELINE_MEDIAN) {
        put_panel(c, 4, rendered);
    } else if (method == SHEEN_EVALUATION_METHODS - 1) {
        c->status = write_strip(c, photo->name);
    }
}

void sheen_comparison_release(sheen_comparison *c)
{
    sheen_image_release(&c->strip);
}
