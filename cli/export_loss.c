// SPDX-License-Identifier: Apache-2.0
// export_loss.c - draws the original model and what was written from the photographs' viewpoints, and compares.
#include "cli/export_loss.h"

#include <math.h>
#include <stdlib.h>

#include "fit/metrics.h"

// Agreement that is better than this is called this: identical pictures have no finite one.
static const double most_db = 99;

static sheen_status draw(sheen_layers *out, const sheen_export_views *v, const sheen_drawing *d, size_t i,
                         sheen_err *err)
{
    const sheen_photo *photo = &v->photos.photos[v->i_photo[i]];
    return sheen_draw(out, d, &v->photos.cam, photo->rt_cam_obj, photo->rt_world_obj, &v->options, err);
}

// One sample a pixel shows the outermost one wholly or not at all, and a mesh that was simplified by a tenth of a pixel
// would be told by those: pixels count whose neighbours are the object, too.
static int is_inside(const sheen_image *coverage, int x, int y)
{
    if (x < 1 || y < 1 || x >= coverage->width_px - 1 || y >= coverage->height_px - 1)
        return 0;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++)
            if (!(*sheen_image_at(coverage, x + dx, y + dy) > 0.999f))
                return 0;
    return 1;
}

static sheen_status open_view(sheen_export_views *v, const sheen_drawing *d, size_t i, sheen_err *err)
{
    const sheen_photo *photo = &v->photos.photos[v->i_photo[i]];
    sheen_layers layers;
    const sheen_status s = draw(&layers, v, d, i, err);
    if (s)
        return s;
    const int width_px = layers.coverage.width_px;
    const size_t n = (size_t)width_px * (size_t)layers.coverage.height_px;
    v->select[i] = calloc(n, 1);
    for (size_t k = 0; v->select[i] && k < n; k++)
        v->select[i][k] = is_inside(&layers.coverage, (int)(k % (size_t)width_px),
                                    (int)(k / (size_t)width_px)) &&
                          (!photo->mask.data || photo->mask.data[k] > 0.5f);
    v->drawn[i] = layers.composite;
    layers.composite = (sheen_image){0};
    sheen_layers_release(&layers);
    return v->select[i] ? SHEEN_OK : sheen_fail_memory(err, (double)n, "a view");
}

sheen_status sheen_export_views_open(sheen_export_views *out, const sheen_session *s,
                                     const sheen_model *model, int n_threads, const sheen_progress *progress,
                                     sheen_err *err)
{
    sheen_drawing *d = NULL;
    *out = (sheen_export_views){.options = {.samples_per_side = 1, .n_threads = n_threads}};
    sheen_status st = sheen_photos_load(&out->photos, s, SHEEN_ROLE_INPUT, progress, err);
    if (!st)
        st = sheen_drawing_new(&d, model, err);
    const size_t n = out->photos.count;
    out->n_views = n < SHEEN_EXPORT_MAX_VIEWS ? n : SHEEN_EXPORT_MAX_VIEWS;
    for (size_t i = 0; !st && i < out->n_views; i++) {
        out->i_photo[i] = i * n / out->n_views;
        st = sheen_progress_step(progress, "views", (int)i, (int)out->n_views, err);
        if (!st)
            st = open_view(out, d, i, err);
    }
    sheen_drawing_free(&d);
    if (st)
        sheen_export_views_close(out);
    return st;
}

void sheen_export_views_close(sheen_export_views *v)
{
    for (size_t i = 0; i < v->n_views; i++) {
        sheen_image_release(&v->drawn[i]);
        free(v->select[i]);
    }
    sheen_photos_release(&v->photos);
    *v = (sheen_export_views){0};
}

sheen_status sheen_export_measure(sheen_export_loss *out, const sheen_export_views *v,
                                  const sheen_model *packed, sheen_err *err)
{
    sheen_drawing *d;
    size_t n_counted = 0;
    *out = (sheen_export_loss){.agreement_db = most_db};
    sheen_status st = sheen_drawing_new(&d, packed, err);
    for (size_t i = 0; !st && i < v->n_views; i++) {
        sheen_layers layers;
        st = draw(&layers, v, d, i, err);
        if (st)
            break;
        const sheen_image *photo = &v->photos.photos[v->i_photo[i]].image;
        const sheen_psnr full = sheen_psnr_of(&v->drawn[i], photo, v->select[i]);
        const sheen_psnr after = sheen_psnr_of(&layers.composite, photo, v->select[i]);
        const sheen_psnr both = sheen_psnr_of(&layers.composite, &v->drawn[i], v->select[i]);
        sheen_layers_release(&layers);
        if (!full.n_pixels)
            continue;
        n_counted++;
        out->full_db += fmin(full.srgb_db, most_db);
        out->packed_db += fmin(after.srgb_db, most_db);
        out->agreement_db = fmin(out->agreement_db, both.srgb_db);
    }
    sheen_drawing_free(&d);
    if (!st && !n_counted)
        st = sheen_fail(err, SHEEN_EDATA, "no photograph shows the object, so the loss cannot be measured");
    if (n_counted) {
        out->full_db /= (double)n_counted;
        out->packed_db /= (double)n_counted;
    }
    return st;
}
