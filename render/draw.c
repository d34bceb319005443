// SPDX-License-Identifier: Apache-2.0
// draw.c - pictures of a model by section 5: texture, plus specular reflection by eq. (7), added at each
// sample. The picture is worked on in small squares of samples, whose layers are then summed into its pixels.
#include "render/draw.h"

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "base/parallel.h"
#include "base/pose3.h"
#include "render/draw_private.h"
#include "render/draw_tile.h"
#include "render/first_hits.h"
#include "render/shade.h"

enum { DEFAULT_SAMPLES_PER_SIDE = 2, TILE_SAMPLES_PER_SIDE = 16, BAND_TILES = 2, STREAM_LEAST_PX = 64 };

void sheen_layers_release(sheen_layers *l)
{
    sheen_image_release(&l->diffuse);
    sheen_image_release(&l->specular);
    sheen_image_release(&l->composite);
    sheen_image_release(&l->coverage);
    sheen_image_release(&l->holes);
    *l = (sheen_layers){0};
}

sheen_status sheen_drawing_new(sheen_drawing **out, const sheen_model *model, sheen_err *err)
{
    *out = NULL;
    if (!model->mesh.n_triangles || model->texture.n_triangles != model->mesh.n_triangles)
        return sheen_fail(err, SHEEN_EARG,
                          "cannot draw a model whose texture has %zu triangles and whose mesh has %zu",
                          model->texture.n_triangles, model->mesh.n_triangles);
    if (!(model->sigma_rad > 0))
        return sheen_fail(err, SHEEN_EARG, "cannot draw a model of roughness %g", model->sigma_rad);
    sheen_drawing *d = calloc(1, sizeof *d);
    if (!d)
        return sheen_fail_memory(err, (double)sizeof *d, "a drawing");
    d->model = model;
    sheen_status s = sheen_scene_new(&d->scene, &model->mesh, err);
    if (!s)
        s = sheen_lobe_block_cells(&d->cells, &model->lights, (float)model->sigma_rad, err);
    if (!s)
        s = sheen_lamp_points_init(&d->lamps, model->lamps, model->n_lamps, (float)model->sigma_rad, err);
    if (s)
        sheen_drawing_free(&d);
    *out = d;
    return s;
}

void sheen_drawing_free(sheen_drawing **d)
{
    if (!*d)
        return;
    sheen_scene_free(&(*d)->scene);
    sheen_light_cells_free(&(*d)->cells);
    sheen_lamp_points_release(&(*d)->lamps);
    free(*d);
    *d = NULL;
}

typedef struct job {
    const sheen_first_hits *first_hits;
    const sheen_draw_options *options;
    sheen_layers *out;
    sheen_shading shading;
    int width_px; // of the picture
    int tile_px;  // pixels a side that are worked on together
    bool composite_alone;
    atomic_int failed;
} job;

// Sums over a pixel's samples.
typedef struct sums {
    float diffuse[3], coverage, specular[3], holes;
} sums;

static void add_sample(sums *s, const sheen_tile *tile, int i, const sheen_draw_options *o)
{
    const float *diffuse = tile->hole[i] && o->mark_holes ? o->hole_rgb : tile->diffuse[i];
    const float *specular = tile->specular[i];
    s->diffuse[0] += diffuse[0];
    s->diffuse[1] += diffuse[1];
    s->diffuse[2] += diffuse[2];
    s->specular[0] += specular[0];
    s->specular[1] += specular[1];
    s->specular[2] += specular[2];
    s->coverage += 1;
    s->holes += tile->hole[i] ? 1 : 0;
}

// n pixels of a row, from (x, y) on.
static void put_pixels(const job *j, int x, int y, const sums *s, int n)
{
    const sheen_layers *out = j->out;
    const int n_side = j->first_hits->window.samples_per_side;
    const float share = 1.0f / (float)(n_side * n_side);
    const float *background = j->options->background_rgb;
    float *diffuse = out->diffuse.data ? sheen_image_at(&out->diffuse, x, y) : NULL;
    float *specular = out->specular.data ? sheen_image_at(&out->specular, x, y) : NULL;
    float *composite = out->composite.data ? sheen_image_at(&out->composite, x, y) : NULL;
    float *coverage = out->coverage.data ? sheen_image_at(&out->coverage, x, y) : NULL;
    float *holes = out->holes.data ? sheen_image_at(&out->holes, x, y) : NULL;
    for (int i = 0; composite && i < n; i++)
        for (int c = 0; c < 3; c++)
            composite[3 * i + c] = (s[i].diffuse[c] + s[i].specular[c]) * share +
                                   (1 - s[i].coverage * share) * background[c];
    for (int i = 0; diffuse && i < n; i++)
        for (int c = 0; c < 3; c++)
            diffuse[3 * i + c] = s[i].diffuse[c] * share;
    for (int i = 0; specular && i < n; i++)
        for (int c = 0; c < 3; c++)
            specular[3 * i + c] = s[i].specular[c] * share;
    for (int i = 0; coverage && i < n; i++)
        coverage[i] = s[i].coverage * share;
    for (int i = 0; holes && i < n; i++)
        holes[i] = s[i].holes * share;
}

// Writes n RGB pixels past the caches, which a picture's background would push everything else out of.
#if defined(__x86_64__)
static void stream(float *to, const float rgb[3], size_t n)
{
    for (; n && (uintptr_t)to % 16; n--, to += 3)
        memcpy(to, rgb, 3 * sizeof *rgb);
    const __m128 a = _mm_setr_ps(rgb[0], rgb[1], rgb[2], rgb[0]),
                 b = _mm_setr_ps(rgb[1], rgb[2], rgb[0], rgb[1]),
                 c = _mm_setr_ps(rgb[2], rgb[0], rgb[1], rgb[2]);
    for (; n >= 4; n -= 4, to += 12) {
        _mm_stream_ps(to, a);
        _mm_stream_ps(to + 4, b);
        _mm_stream_ps(to + 8, c);
    }
    for (; n; n--, to += 3)
        memcpy(to, rgb, 3 * sizeof *rgb);
    _mm_sfence(); // before another thread is told that it is there
}
#endif

static void fill(sheen_image *layer, int y, int begin, int end, const float value[4])
{
    const size_t n = (size_t)layer->n_channels, pixel_bytes = n * sizeof(float);
    if (begin >= end)
        return;
    float *first = sheen_image_at(layer, begin, y);
#if defined(__x86_64__)
    if (n == 3 && end - begin >= STREAM_LEAST_PX) {
        stream(first, value, (size_t)(end - begin));
        return;
    }
#endif
    memcpy(first, value, pixel_bytes);
    for (size_t done = 1, count = (size_t)(end - begin); done < count; done *= 2) // what is filled fills on
        memcpy(first + done * n, first, (done < count - done ? done : count - done) * pixel_bytes);
}

// Background over the pixels [begin, end) of a row.
static void clear(const job *j, int y, int begin, int end)
{
    static const float black[4] = {0, 0, 0, 0};
    const float *rgb = j->options->background_rgb, background[4] = {rgb[0], rgb[1], rgb[2], 0};
    sheen_image *const layers[] = {&j->out->diffuse, &j->out->specular, &j->out->composite, &j->out->coverage,
                                   &j->out->holes};
    for (size_t i = 0; i < sizeof layers / sizeof *layers; i++)
        if (layers[i]->data)
            fill(layers[i], y, begin, end, layers[i] == &j->out->composite ? background : black);
}

// Squares of side x side pixels of a band, cut to it, row after row.
typedef struct square {
    sheen_tile tile;
    int x0, y0, width, height; // pixels of the band
} square;

// Collects the samples of square number i, and asks the memory for their colours.
static void prepare_square(square *q, const job *j, const sheen_gbuffer *g, int i)
{
    const int n = g->samples_per_side, side = j->tile_px, per_row = (g->width_px + side - 1) / side;
    q->x0 = i % per_row * side;
    q->y0 = i / per_row * side;
    q->width = g->width_px - q->x0 < side ? g->width_px - q->x0 : side;
    q->height = g->height_px - q->y0 < side ? g->height_px - q->y0 : side;
    sheen_tile_gather(&q->tile, g, q->x0 * n, q->y0 * n, side * n);
    sheen_texture_ask(&j->shading.model->texture, q->tile.hits, (size_t)q->tile.count);
}

// A composite alone, of one sample a pixel. (x, y): the square's first pixel.
static void put_samples(const job *j, const square *q, int x, int y)
{
    const sheen_tile *tile = &q->tile;
    const sheen_draw_options *o = j->options;
    const size_t stride = 3 * (size_t)j->width_px;
    float *first = sheen_image_at(&j->out->composite, x, y);
    for (int row = 0; row < q->height && tile->count < q->width * q->height; row++)
        clear(j, y + row, x, x + q->width);
    for (int i = 0; i < tile->count; i++) {
        const float *diffuse = tile->hole[i] && o->mark_holes ? o->hole_rgb : tile->diffuse[i];
        const float *specular = tile->specular[i];
        float *to = first + tile->y[i] * stride + 3 * (size_t)tile->x[i];
        to[0] = diffuse[0] + specular[0];
        to[1] = diffuse[1] + specular[1];
        to[2] = diffuse[2] + specular[2];
    }
}

static void draw_square(const job *j, const sheen_gbuffer *g, square *q)
{
    const unsigned n = (unsigned)g->samples_per_side, side = (unsigned)j->tile_px;
    const int x = g->x0_px + q->x0, y = g->y0_px + q->y0;
    sheen_tile *tile = &q->tile;
    if (!tile->count) {
        for (int row = 0; row < q->height; row++)
            clear(j, y + row, x, x + q->width);
        return;
    }
    sheen_tile_diffuse(tile, &j->shading, g->p_camera_obj);
    sheen_tile_specular(tile, &j->shading, g->p_camera_obj);
    if (n == 1 && j->composite_alone) {
        put_samples(j, q, x, y);
        return;
    }
    sums pixels[TILE_SAMPLES_PER_SIDE * TILE_SAMPLES_PER_SIDE];
    memset(pixels, 0, side * side * sizeof *pixels);
    for (int i = 0; i < tile->count; i++)
        add_sample(pixels + tile->y[i] / n * side + tile->x[i] / n, tile, i, j->options);
    for (int row = 0; row < q->height; row++)
        put_pixels(j, x, y + row, pixels + (unsigned)row * side, q->width);
}

// While one square is worked on, the memory fetches the next one's colours.
static void draw_squares(const job *j, const sheen_gbuffer *g)
{
    const int side = j->tile_px;
    const int n = (g->width_px + side - 1) / side * ((g->height_px + side - 1) / side);
    square squares[2];
    if (n)
        prepare_square(&squares[0], j, g, 0);
    for (int i = 0; i < n; i++) {
        if (i + 1 < n)
            prepare_square(&squares[(i + 1) % 2], j, g, i + 1);
        draw_square(j, g, &squares[i % 2]);
    }
}

// Bands of the picture, square after square while the hits are in the cache.
static void draw_bands(void *self, size_t begin, size_t end)
{
    job *j = self;
    const sheen_gbuffer *w = &j->first_hits->window;
    const size_t n = (size_t)w->samples_per_side;
    sheen_hit *hits = malloc((size_t)w->width_px * (size_t)j->first_hits->band_px * n * n * sizeof *hits);
    for (size_t i = begin; i < end; i++) {
        sheen_gbuffer band = sheen_first_hits_band(j->first_hits, i);
        band.hits = hits;
        if (!hits || sheen_first_hits_find(j->first_hits, hits, i, NULL)) {
            atomic_store(&j->failed, 1);
            break;
        }
        draw_squares(j, &band);
    }
    free(hits);
}

// What lies outside the window.
static void clear_rows(void *self, size_t begin, size_t end)
{
    const job *j = self;
    const sheen_gbuffer *g = &j->first_hits->window;
    for (int y = (int)begin; y < (int)end; y++) {
        const bool in_window = y >= g->y0_px && y < g->y0_px + g->height_px;
        const int width = j->width_px;
        clear(j, y, 0, in_window ? g->x0_px : width);
        if (in_window)
            clear(j, y, g->x0_px + g->width_px, width);
    }
}

static sheen_status room(sheen_image *layer, bool wanted, const sheen_camera *cam, int channels,
                         sheen_err *err)
{
    if (wanted && layer->data && layer->width_px == cam->width_px && layer->height_px == cam->height_px &&
        layer->n_channels == channels)
        return SHEEN_OK;
    sheen_image_release(layer);
    return wanted ? sheen_image_init(layer, cam->width_px, cam->height_px, channels, err) : SHEEN_OK;
}

static sheen_status make_layers(sheen_layers *out, const sheen_camera *cam, unsigned wanted, sheen_err *err)
{
    sheen_status s = room(&out->diffuse, (wanted & SHEEN_LAYER_DIFFUSE) != 0, cam, 3, err);
    if (!s)
        s = room(&out->specular, (wanted & SHEEN_LAYER_SPECULAR) != 0, cam, 3, err);
    if (!s)
        s = room(&out->composite, (wanted & SHEEN_LAYER_COMPOSITE) != 0, cam, 3, err);
    if (!s)
        s = room(&out->coverage, (wanted & SHEEN_LAYER_COVERAGE) != 0, cam, 1, err);
    if (!s)
        s = room(&out->holes, (wanted & SHEEN_LAYER_HOLES) != 0, cam, 1, err);
    return s;
}

sheen_status sheen_redraw(sheen_layers *layers, const sheen_drawing *d, const sheen_camera *cam,
                          const double rt_cam_obj[6], const double *rt_world_obj,
                          const sheen_draw_options *options, sheen_err *err)
{
    static const sheen_draw_options defaults = {0};
    const sheen_draw_options *o = options ? options : &defaults;
    const int samples = o->samples_per_side ? o->samples_per_side : DEFAULT_SAMPLES_PER_SIDE;
    if (!rt_world_obj)
        rt_world_obj = d->model->rt_world_obj;
    for (int i = 0; i < 6; i++)
        if (!isfinite(rt_world_obj[i]))
            return sheen_fail(err, SHEEN_EARG, "the object's pose under the lights is not finite");
    const int tile_px = samples < TILE_SAMPLES_PER_SIDE ? TILE_SAMPLES_PER_SIDE / samples : 1;
    const sheen_first_hits_view view = {.scene = d->scene,
                                        .mesh = &d->model->mesh,
                                        .cam = cam,
                                        .rt_cam_obj = rt_cam_obj,
                                        .samples_per_side = samples,
                                        .n_threads = o->n_threads};
    sheen_first_hits f;
    sheen_status s = sheen_first_hits_init(&f, &view, BAND_TILES * tile_px, err);
    if (s)
        return s;
    s = make_layers(layers, cam, o->layers ? o->layers : SHEEN_LAYERS_ALL, err);
    if (!s) {
        job j = {
            .first_hits = &f, .options = o, .out = layers, .width_px = cam->width_px, .tile_px = tile_px};
        j.composite_alone = o->layers == SHEEN_LAYER_COMPOSITE;
        atomic_init(&j.failed, 0);
        sheen_shading_init(&j.shading, d->model, d->scene, d->cells, &d->lamps, rt_world_obj);
        sheen_parallel_for((size_t)cam->height_px, 16, o->n_threads, clear_rows, &j);
        sheen_parallel_for(f.n_bands, 1, o->n_threads, draw_bands, &j);
        if (atomic_load(&j.failed))
            s = sheen_fail_memory(err, 16.0 * (double)f.window.width_px * f.band_px * samples * samples,
                                  "a band of the picture");
    }
    sheen_first_hits_release(&f);
    return s;
}

sheen_status sheen_draw(sheen_layers *out, const sheen_drawing *d, const sheen_camera *cam,
                        const double rt_cam_obj[6], const double *rt_world_obj,
                        const sheen_draw_options *options, sheen_err *err)
{
    *out = (sheen_layers){0};
    const sheen_status s = sheen_redraw(out, d, cam, rt_cam_obj, rt_world_obj, options, err);
    if (s)
        sheen_layers_release(out);
    return s;
}
