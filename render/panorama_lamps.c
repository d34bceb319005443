// SPDX-License-Identifier: Apache-2.0
// panorama_lamps.c - a panorama cut into regions over which its light is little spread, each a lamp.
//
// Variance cut (Viriyothai and Debevec 2009): the region with the largest light times squared angle from its middle is halved,
// along the side on which it is spread more, where the two halves are spread least. A lamp stands at its region's middle of light and is a disc of the same mean square width. Its colour at the
// highlight's peak follows from the region's power as in far_lights.c: f0 times the integral of radiance, over
// 8 pi sigma^2 (1 + tail).
#include "render/panorama_lamps.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "render/panorama.h"

static const double pi = 3.14159265358979323846;

typedef struct region {
    int x0, y0, x1, y1; // pixels x0 .. x1 - 1
    double light;       // sum of luminance times solid angle
    double spread;      // sum of light times squared angle from the middle
    int cut;            // pixels of the half that begins at x0, y0; 0: none to halve
    bool by_columns;
} region;

static const float *pixel(const sheen_image *img, int x, int y)
{
    return img->data + 3 * ((size_t)y * (size_t)img->width_px + (size_t)x);
}

static double pixel_light(const sheen_image *img, int x, int y)
{
    return (double)sheen_luminance(pixel(img, x, y)) * sheen_panorama_pixel_sr(img, y);
}

// Light along one side of a region, pixel column by column or row by row: sums of light, light times place, and times its
// square, up to and with place k.
typedef struct sums {
    double light, moment, square;
} sums;

static double spread(const sums *s)
{
    return s->light > 0 ? fmax(s->square - s->moment * s->moment / s->light, 0) : 0;
}

// until[k]: sums over the first k + 1 columns (or rows) of a region; places in radians on the sphere.
static void sum_up(sums *until, const sheen_image *img, const region *r, bool columns)
{
    const double elevation = (0.5 - 0.5 * (r->y0 + r->y1) / img->height_px) * pi,
                 step_rad = pi / img->height_px * (columns ? cos(elevation) : 1);
    const int n = columns ? r->x1 - r->x0 : r->y1 - r->y0;
    sums sum = {0};
    assert(n > 0);
    for (int k = 0; k < n; k++) {
        double light = 0;
        for (int y = columns ? r->y0 : r->y0 + k; y < (columns ? r->y1 : r->y0 + k + 1); y++)
            for (int x = columns ? r->x0 + k : r->x0; x < (columns ? r->x0 + k + 1 : r->x1); x++)
                light += pixel_light(img, x, y);
        const double at = k * step_rad;
        sum.light += light;
        sum.moment += light * at;
        sum.square += light * at * at;
        until[k] = sum;
    }
}

// Where to halve: after which column or row of those the light is spread less about the two middles than elsewhere.
static int best_cut(const sums *until, int n)
{
    const sums *all = &until[n - 1];
    int best = 0;
    double least = INFINITY;
    for (int k = 0; k + 1 < n; k++) {
        const sums rest = {all->light - until[k].light, all->moment - until[k].moment,
                           all->square - until[k].square};
        const double sum = spread(&until[k]) + spread(&rest);
        if (sum < least) {
            least = sum;
            best = k + 1;
        }
    }
    return best;
}

// Finds how much a region's light is spread, and where it is to be halved. room: [width of the picture]
static void measure(region *r, sums *room, const sheen_image *img)
{
    const int n[2] = {r->y1 - r->y0, r->x1 - r->x0};
    double spreads[2];
    r->cut = 0;
    for (int columns = 0; columns < 2; columns++) {
        assert(n[columns] > 0);
        sum_up(room, img, r, columns);
        spreads[columns] = spread(&room[n[columns] - 1]);
        r->light = room[n[columns] - 1].light;
        const int cut = best_cut(room, n[columns]);
        if (n[columns] > 1 && (!r->cut || spreads[columns] > spreads[0])) {
            r->cut = cut;
            r->by_columns = columns;
        }
    }
    r->spread = spreads[0] + spreads[1];
}

static size_t cut_up(region *regions, size_t most, sums *room, const sheen_image *img)
{
    size_t n = 1;
    regions[0] = (region){.x1 = img->width_px, .y1 = img->height_px};
    measure(&regions[0], room, img);
    while (n < most) {
        size_t best = 0;
        for (size_t i = 1; i < n; i++)
            if (regions[i].spread > regions[best].spread)
                best = i;
        region *low = &regions[best], *high = &regions[n];
        if (!(low->spread > 0) || !low->cut)
            break;
        *high = *low;
        if (low->by_columns)
            high->x0 = low->x1 = low->x0 + low->cut;
        else
            high->y0 = low->y1 = low->y0 + low->cut;
        measure(low, room, img);
        measure(high, room, img);
        n++;
    }
    return n;
}

static void board_direction(float v_board[3], const sheen_image *img, int x, int y)
{
    float v_env[3];
    sheen_panorama_direction(v_env, img, x, y);
    v_board[0] = v_env[0];
    v_board[1] = -v_env[2];
    v_board[2] = v_env[1];
}

static void lamp_of(sheen_lamp *lamp, const sheen_image *img, const region *r, double share)
{
    double middle[3] = {0}, rgb[3] = {0}, square = 0;
    for (int y = r->y0; y < r->y1; y++)
        for (int x = r->x0; x < r->x1; x++) {
            float v[3];
            const double light = pixel_light(img, x, y), sr = sheen_panorama_pixel_sr(img, y);
            board_direction(v, img, x, y);
            for (int k = 0; k < 3; k++) {
                middle[k] += light * (double)v[k];
                rgb[k] += sr * (double)pixel(img, x, y)[k];
            }
        }
    sheen_normalize(middle);
    for (int y = r->y0; y < r->y1; y++)
        for (int x = r->x0; x < r->x1; x++) {
            float v[3];
            board_direction(v, img, x, y);
            const double wide[3] = {(double)v[0], (double)v[1], (double)v[2]};
            const double angle = acos(fmax(-1, fmin(1, sheen_dot(wide, middle))));
            square += pixel_light(img, x, y) * (angle * angle + sheen_panorama_pixel_sr(img, y) / (2 * pi));
        }
    // a disc's mean square distance from its middle is half of its radius squared
    lamp->radius_rad = (float)fmin(sqrt(2 * square / r->light), 0.5);
    lamp->inverse_distance_per_m = 0;
    for (int k = 0; k < 3; k++) {
        lamp->direction_world[k] = (float)middle[k];
        lamp->rgb[k] = (float)(share * rgb[k]);
    }
}

static sheen_status check(const sheen_image *img, sheen_err *err)
{
    if (img->n_channels != 3 || img->width_px != 2 * img->height_px)
        return sheen_fail(
            err, SHEEN_EDATA,
            "a panorama is a colour picture twice as wide as high, not %d x %d px with %d channels",
            img->width_px, img->height_px, img->n_channels);
    const size_t n = 3 * (size_t)img->width_px * (size_t)img->height_px;
    double most = 0;
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(img->data[i]) || img->data[i] < 0)
            return sheen_fail(err, SHEEN_EDATA, "the panorama holds light that is negative or not finite");
        most = fmax(most, (double)img->data[i]);
    }
    return most > 0 ? SHEEN_OK : sheen_fail(err, SHEEN_EDATA, "the panorama is all black");
}

sheen_status sheen_model_light_by_panorama(sheen_model *m, const sheen_image *panorama, size_t n_lamps,
                                           double f0, sheen_err *err)
{
    sheen_status s = check(panorama, err);
    if (s)
        return s;
    const size_t most = n_lamps < 1 ? 1 : n_lamps > SHEEN_LAMPS_MAX ? SHEEN_LAMPS_MAX : n_lamps;
    const double share = f0 / (8 * pi * m->sigma_rad * m->sigma_rad * (1 + m->lobe_tail));
    region *regions = malloc(most * sizeof *regions);
    sheen_lamp *lamps = malloc(most * sizeof *lamps);
    sums *room = malloc((size_t)panorama->width_px * sizeof *room);
    if (regions && lamps && room) {
        const size_t n_regions = cut_up(regions, most, room, panorama);
        size_t n = 0;
        for (size_t i = 0; i < n_regions; i++)
            if (regions[i].light > 0)
                lamp_of(&lamps[n++], panorama, &regions[i], share);
        s = sheen_model_set_lights(m, 0, err);
        if (!s)
            s = sheen_model_set_lamps(m, lamps, n, err);
        sheen_surroundings_release(&m->surroundings);
    } else {
        s = sheen_fail_memory(err, (double)most * (double)(sizeof *regions + sizeof *lamps),
                              "a panorama's lamps");
    }
    free(room);
    free(regions);
    free(lamps);
    return s;
}
