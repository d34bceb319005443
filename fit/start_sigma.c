// SPDX-License-Identifier: Apache-2.0
// start_sigma.c - half-maximum radius of the brightest spot, from means over rings about it.
//
// Means over rings, since mirror shots reach nodes unevenly: a spot has holes where no pixel happened to point.
#include "fit/start_sigma.h"

#include <math.h>

#include "base/image.h"
#include "base/vec.h"

enum { MAX_RINGS = 64 };

static uint32_t brightest_node(const sheen_hemisphere *h)
{
    uint32_t best = 0;
    for (uint32_t i = 1; i < h->n_nodes; i++)
        if (sheen_luminance(h->rgb + 3 * i) > sheen_luminance(h->rgb + 3 * best))
            best = i;
    return best;
}

typedef struct rings {
    double sum[MAX_RINGS];
    size_t count[MAX_RINGS]; // nodes that a mirror shot reached
} rings;

// Ring k holds the nodes at k - 1/2 .. k + 1/2 spacings from the centre; what failed the consistency check is dark.
static void measure_rings(rings *r, const sheen_hemisphere *h, const sheen_geodesic *g, uint32_t centre)
{
    *r = (rings){0};
    for (uint32_t i = 0; i < h->n_nodes; i++) {
        if (!h->n_reached[i])
            continue;
        const float cosine = sheen_dotf(g->v_world + 3 * i, g->v_world + 3 * centre);
        const double angle_rad = acos(fmin(1, fmax(-1, (double)cosine)));
        const double k = floor(angle_rad / (double)g->spacing_rad + 0.5);
        if (k < MAX_RINGS) {
            r->sum[(int)k] += (double)sheen_luminance(h->rgb + 3 * i);
            r->count[(int)k]++;
        }
    }
}

double sheen_start_sigma(const sheen_hemisphere *h, const sheen_geodesic *g)
{
    rings r;
    measure_rings(&r, h, g, brightest_node(h));
    // The peak is the mean over the first two rings: one node alone may be a lucky pixel
    const double peak = (r.sum[0] + r.sum[1]) / (double)(r.count[0] + r.count[1]);
    double inner = peak;
    int k = 1;
    for (; k < MAX_RINGS; k++) {
        const double mean = r.count[k] ? r.sum[k] / (double)r.count[k] : inner;
        if (mean < 0.5 * peak) {
            const double fraction = inner > mean ? (inner - 0.5 * peak) / (inner - mean) : 1;
            const double radius_rad = (k - 1 + fmax(0, fmin(1, fraction))) * (double)g->spacing_rad;
            return fmin(0.3, fmax(0.02, 2 * radius_rad / 2.355));
        }
        inner = mean;
    }
    return 0.3;
}
