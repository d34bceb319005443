// SPDX-License-Identifier: Apache-2.0
// board_picture.c - projects a grid of places on the board into every photograph and takes the median.
#include "fit/board_picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/pose3.h"
#include "base/vec.h"

enum { SIDE = 384, MAX_VIEWS = 64 };

typedef struct job {
    const sheen_photos *photos;
    const sheen_scene *scene;
    sheen_surroundings *out;
    uint8_t *known; // [SIDE * SIDE]
    sheen_Rt Rt_obj_world;
    sheen_Rt *Rt_cam_obj;   // [n_views]
    float (*camera_obj)[3]; // [n_views]
    size_t n_views;
    float offset_m;
} job;

// Where there are more photographs than are asked: every n-th.
static const sheen_photo *photo_of(const job *j, size_t view)
{
    return &j->photos->photos[view * j->photos->count / j->n_views];
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// Colours in which the photographs show a row of places; n[i] of them for place i.
static void sample_row(const job *j, const double (*p_obj)[3], float (*rgb)[MAX_VIEWS][3], int n[SIDE])
{
    float points[SIDE * 3];
    uint8_t occluded[SIDE];
    for (int i = 0; i < SIDE; i++)
        for (int k = 0; k < 3; k++)
            points[3 * i + k] = (float)p_obj[i][k];
    for (size_t v = 0; v < j->n_views; v++) {
        double p_cam[SIDE * 3], q_px[SIDE * 2];
        for (int i = 0; i < SIDE; i++)
            sheen_Rt_point(p_cam + 3 * i, &j->Rt_cam_obj[v], p_obj[i]);
        if (sheen_camera_project(&j->photos->cam, q_px, NULL, p_cam, SIDE, NULL))
            continue;
        sheen_scene_occluded(j->scene, occluded, points, SIDE, j->camera_obj[v], j->offset_m);
        for (int i = 0; i < SIDE; i++)
            if (!occluded[i] && fabs(q_px[2 * i]) < 1e6 && fabs(q_px[2 * i + 1]) < 1e6 &&
                sheen_image_bilinear(rgb[i][n[i]], &photo_of(j, v)->image, q_px[2 * i], q_px[2 * i + 1]))
                n[i]++;
    }
}

static void fill_rows(void *self, size_t begin, size_t end)
{
    const job *j = self;
    static const size_t row_bytes = SIDE * sizeof(float[MAX_VIEWS][3]);
    float(*rgb)[MAX_VIEWS][3] = malloc(row_bytes);
    if (!rgb)
        return; // the row stays unknown and is filled from its neighbours
    for (size_t y = begin; y < end; y++) {
        double p_obj[SIDE][3];
        int n[SIDE] = {0};
        for (int x = 0; x < SIDE; x++) {
            const double p_world[3] = {j->out->board_x0_m + x * j->out->board_pitch_m,
                                       j->out->board_y0_m + (double)y * j->out->board_pitch_m, 0};
            sheen_Rt_point(p_obj[x], &j->Rt_obj_world, p_world);
        }
        sample_row(j, (const double(*)[3])p_obj, rgb, n);
        for (int x = 0; x < SIDE; x++) {
            float *out = sheen_image_at(&j->out->board, x, (int)y);
            j->known[y * SIDE + (size_t)x] = n[x] > 0;
            for (int c = 0; c < 3 && n[x]; c++) {
                float values[MAX_VIEWS] = {0};
                for (int v = 0; v < n[x]; v++)
                    values[v] = rgb[x][v][c];
                qsort(values, (size_t)n[x], sizeof *values, compare_floats);
                out[c] = values[n[x] / 2];
            }
        }
    }
    free(rgb);
}

// Unknown places take the mean of their known neighbours, ring by ring, until none is left.
static void fill_unknown(sheen_image *img, uint8_t *known)
{
    for (int round = 0, left = 1; left && round < SIDE; round++) {
        left = 0;
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) {
                float sum[3] = {0, 0, 0};
                int n = 0;
                if (known[y * SIDE + x])
                    continue;
                for (int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < SIDE; v++)
                    for (int u = x > 0 ? x - 1 : 0; u <= x + 1 && u < SIDE; u++)
                        if (known[v * SIDE + u] == 1) {
                            for (int c = 0; c < 3; c++)
                                sum[c] += sheen_image_at(img, u, v)[c];
                            n++;
                        }
                left = 1;
                if (!n)
                    continue;
                for (int c = 0; c < 3; c++)
                    sheen_image_at(img, x, y)[c] = sum[c] / (float)n;
                known[y * SIDE + x] = 2; // counts from the next round on
            }
        for (int i = 0; i < SIDE * SIDE; i++)
            known[i] = known[i] != 0;
    }
}

// Mean of the picture's rim: the table beyond it.
static void set_table(sheen_surroundings *s)
{
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < SIDE; i++)
        for (int c = 0; c < 3; c++)
            sum[c] += (double)sheen_image_at(&s->board, i, 0)[c] +
                      (double)sheen_image_at(&s->board, i, SIDE - 1)[c] +
                      (double)sheen_image_at(&s->board, 0, i)[c] +
                      (double)sheen_image_at(&s->board, SIDE - 1, i)[c];
    for (int c = 0; c < 3; c++)
        s->table_rgb[c] = sum[c] / (4 * SIDE);
}

static sheen_status allocate(job *j, sheen_err *err)
{
    j->known = calloc((size_t)SIDE * SIDE, 1);
    j->Rt_cam_obj = calloc(j->n_views + 1, sizeof *j->Rt_cam_obj);
    j->camera_obj = calloc(j->n_views + 1, sizeof *j->camera_obj);
    if (!j->known || !j->Rt_cam_obj || !j->camera_obj)
        return sheen_fail_memory(err, SIDE * SIDE, "the board's picture");
    return sheen_image_init(&j->out->board, SIDE, SIDE, 3, err);
}

sheen_status sheen_board_picture_make(sheen_surroundings *out, const sheen_photos *photos,
                                      const sheen_mesh *mesh, const sheen_scene *scene, int n_threads,
                                      sheen_err *err)
{
    float centre_obj[3], radius_m;
    double centre_world[3];
    sheen_Rt Rt_world_obj;
    job j = {.photos = photos, .scene = scene, .out = out};
    j.n_views = photos->count < MAX_VIEWS ? photos->count : MAX_VIEWS;
    sheen_status s = allocate(&j, err);
    if (s)
        goto done;
    sheen_Rt_from_rt(&Rt_world_obj, photos->photos[0].rt_world_obj);
    sheen_Rt_invert(&j.Rt_obj_world, &Rt_world_obj);
    sheen_mesh_sphere(mesh, centre_obj, &radius_m);
    const double centre[3] = {(double)centre_obj[0], (double)centre_obj[1], (double)centre_obj[2]};
    sheen_Rt_point(centre_world, &Rt_world_obj, centre);
    out->board_pitch_m = 10 * (double)radius_m / SIDE;
    out->board_x0_m = centre_world[0] - 5 * (double)radius_m;
    out->board_y0_m = centre_world[1] - 5 * (double)radius_m;
    j.offset_m = 1e-4f * radius_m;
    for (size_t v = 0; v < j.n_views; v++) {
        sheen_Rt Rt_obj_cam;
        sheen_Rt_from_rt(&j.Rt_cam_obj[v], photo_of(&j, v)->rt_cam_obj);
        sheen_Rt_invert(&Rt_obj_cam, &j.Rt_cam_obj[v]);
        for (int k = 0; k < 3; k++)
            j.camera_obj[v][k] = (float)Rt_obj_cam.t[k];
    }
    sheen_parallel_for(SIDE, 8, n_threads, fill_rows, &j);
    size_t n_known = 0;
    for (size_t i = 0; i < (size_t)SIDE * SIDE; i++)
        n_known += j.known[i];
    if (!n_known) {
        s = sheen_fail(err, SHEEN_EDATA, "no photograph shows the plane that the object stands on");
        goto done;
    }
    fill_unknown(&out->board, j.known);
    set_table(out);

done:
    free(j.known);
    free(j.Rt_cam_obj);
    free(j.camera_obj);
    if (s)
        sheen_image_release(&out->board);
    return s;
}
