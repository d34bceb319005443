// SPDX-License-Identifier: Apache-2.0
// samples.c - picks residual pixels.
#include "fit/samples.h"

#include <stdlib.h>
#include <string.h>

#include "base/image.h"

static bool counts(const sheen_residual_pixel *p, float threshold_lin)
{
    return (p->x_px + p->y_px) % 2 == 0 && sheen_luminance(p->rgb) > threshold_lin;
}

static void add(sheen_samples *s, const sheen_residual_pixel *p, size_t view)
{
    memcpy(s->p_obj + 3 * s->count, p->p_obj, sizeof p->p_obj);
    s->view[s->count] = view;
    memcpy(s->n_world + 3 * s->count, p->n_world, sizeof p->n_world);
    memcpy(s->v_world + 3 * s->count, p->v_world, sizeof p->v_world);
    s->intensity[s->count++] = sheen_luminance(p->rgb);
}

sheen_status sheen_samples_take(sheen_samples *out, const sheen_residual *residuals, size_t n_views,
                                float threshold_lin, size_t max_count, sheen_err *err)
{
    *out = (sheen_samples){0};
    size_t n = 0;
    for (size_t v = 0; v < n_views; v++)
        for (size_t i = 0; i < residuals[v].count; i++)
            n += counts(&residuals[v].pixels[i], threshold_lin);
    const size_t step = n > max_count ? (n + max_count - 1) / max_count : 1;
    const size_t n_kept = (n + step - 1) / step;
    out->n_world = malloc((3 * n_kept + 1) * sizeof(float));
    out->v_world = malloc((3 * n_kept + 1) * sizeof(float));
    out->p_obj = malloc((3 * n_kept + 1) * sizeof(float));
    out->view = malloc((n_kept + 1) * sizeof *out->view);
    out->intensity = malloc((n_kept + 1) * sizeof(float));
    if (!out->n_world || !out->v_world || !out->p_obj || !out->view || !out->intensity) {
        sheen_samples_release(out);
        return sheen_fail_memory(err, 48.0 * (double)n_kept, "samples of the residual images");
    }
    size_t k = 0;
    for (size_t v = 0; v < n_views; v++)
        for (size_t i = 0; i < residuals[v].count; i++)
            if (counts(&residuals[v].pixels[i], threshold_lin) && k++ % step == 0)
                add(out, &residuals[v].pixels[i], v);
    return SHEEN_OK;
}

void sheen_samples_release(sheen_samples *s)
{
    free(s->n_world);
    free(s->v_world);
    free(s->p_obj);
    free(s->view);
    free(s->intensity);
    *s = (sheen_samples){0};
}
