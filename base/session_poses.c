// SPDX-License-Identifier: Apache-2.0
// session_poses.c - poses.json and registration.json to and from memory.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/board.h"
#include "base/json_write.h"
#include "base/session_private.h"

enum { POSES_VERSION = 1, REGISTRATION_VERSION = 1 };
static const size_t poses_max_bytes = (size_t)256 << 20;
static const size_t poses_max_count = 1000000;
static const size_t registration_max_bytes = (size_t)1 << 20;

const char *const sheen_poses_inputs[] = {SHEEN_SESSION_CAMERA, SHEEN_SESSION_BOARD, "frames:input",
                                          "frames:test", NULL};

static sheen_status parse_measured(sheen_frame_pose *p, const sheen_json *v, sheen_err *err)
{
    sheen_status s = sheen_json_numbers(v, "rt_cam_board", p->rt_cam_board, 6, err);
    if (!s && sheen_json_get(v, "covariance"))
        s = sheen_json_numbers(v, "covariance", p->covariance, 36, err);
    if (!s && sheen_json_get(v, "n_points"))
        s = sheen_json_int(v, "n_points", 0, 1000000, &p->n_points, err);
    if (!s && sheen_json_get(v, "n_outliers"))
        s = sheen_json_int(v, "n_outliers", 0, 1000000, &p->n_outliers, err);
    p->rms_px = sheen_json_value_number(sheen_json_get(v, "rms_px"), (double)NAN);
    return s;
}

static sheen_status parse_pose(sheen_frame_pose *p, const sheen_json *v, sheen_err *err)
{
    const char *name;
    *p = (sheen_frame_pose){.rms_px = (double)NAN};
    sheen_status s = sheen_json_string(v, "name", &name, err);
    if (s)
        return s;
    if (!sheen_frame_name_ok(name))
        return sheen_fail(err, SHEEN_EFORMAT, "'%.60s' is no name of a frame", name);
    snprintf(p->name, sizeof p->name, "%s", name);
    s = sheen_json_bool(v, "found", &p->found, err);
    if (!s && p->found)
        s = parse_measured(p, v, err);
    snprintf(p->reason, sizeof p->reason, "%s", sheen_json_value_string(sheen_json_get(v, "reason"), ""));
    return s ? sheen_wrap(err, s, "pose of '%s'", p->name) : SHEEN_OK;
}

static int compare_poses(const void *a, const void *b)
{
    return strcmp(((const sheen_frame_pose *)a)->name, ((const sheen_frame_pose *)b)->name);
}

static sheen_status parse_list(sheen_poses *out, const sheen_json *list, sheen_err *err)
{
    const size_t n = sheen_json_count(list);
    if (n > poses_max_count)
        return sheen_fail(err, SHEEN_EFORMAT, "%zu poses are more than the %zu that are read", n,
                          poses_max_count);
    out->poses = calloc(n + 1, sizeof *out->poses);
    if (!out->poses)
        return sheen_fail_memory(err, (double)n * sizeof *out->poses, "poses");
    for (size_t i = 0; i < n; i++) {
        const sheen_status s = parse_pose(&out->poses[i], sheen_json_at(list, i), err);
        if (s)
            return s;
    }
    out->n_poses = n;
    qsort(out->poses, n, sizeof *out->poses, compare_poses);
    for (size_t i = 1; i < n; i++)
        if (!compare_poses(&out->poses[i - 1], &out->poses[i]))
            return sheen_fail(err, SHEEN_EFORMAT, "frame '%s' has two poses", out->poses[i].name);
    return SHEEN_OK;
}

static sheen_status parse_board(sheen_board_place *b, const sheen_json *v, sheen_err *err)
{
    const char *name;
    sheen_status s = sheen_json_string(v, "name", &name, err);
    if (!s)
        s = sheen_json_bool(v, "found", &b->found, err);
    if (!s && b->found)
        s = sheen_json_numbers(v, "rt_ref_board", b->rt_ref_board, 6, err);
    if (!s && b->found)
        s = sheen_json_numbers(v, "covariance", b->covariance, 36, err);
    if (!s)
        s = sheen_json_int(v, "n_frames", 0, 1000000, &b->n_frames, err);
    if (!s)
        s = sheen_json_int(v, "n_moved", 0, 1000000, &b->n_moved, err);
    if (!s)
        snprintf(b->name, sizeof b->name, "%.*s", (int)sizeof b->name - 1, name);
    snprintf(b->reason, sizeof b->reason, "%s", sheen_json_value_string(sheen_json_get(v, "reason"), ""));
    return s;
}

static sheen_status parse_boards(sheen_poses *out, const sheen_json *root, sheen_err *err)
{
    const sheen_json *list;
    sheen_status s = SHEEN_OK;
    if (!sheen_json_get(root, "boards"))
        return SHEEN_OK;
    s = sheen_json_array(root, "boards", &list, err);
    if (s)
        return s;
    const size_t n = sheen_json_count(list);
    if (n > SHEEN_BOARD_SET_MAX)
        return sheen_fail(err, SHEEN_EFORMAT, "%zu boards are more than the %d that are read", n,
                          (int)SHEEN_BOARD_SET_MAX);
    out->boards = calloc(n + 1, sizeof *out->boards);
    if (!out->boards)
        return sheen_fail_memory(err, (double)n * sizeof *out->boards, "boards");
    out->n_boards = n;
    for (size_t i = 0; i < n && !s; i++)
        s = parse_board(&out->boards[i], sheen_json_at(list, i), err);
    return s;
}

sheen_status sheen_poses_parse(sheen_poses *out, const void *data, size_t size_bytes, sheen_err *err)
{
    *out = (sheen_poses){0};
    sheen_json *root = NULL;
    const sheen_json *list;
    sheen_status s = sheen_json_parse(&root, data, size_bytes, err);
    if (!s)
        s = sheen_json_schema(root, "sheen-poses", POSES_VERSION, NULL, err);
    if (!s)
        s = sheen_json_bool(root, "imported", &out->imported, err);
    if (!s)
        s = sheen_json_array(root, "frames", &list, err);
    if (!s)
        s = parse_list(out, list, err);
    if (!s)
        s = parse_boards(out, root, err);
    sheen_json_free(&root);
    if (s)
        sheen_poses_release(out);
    return s;
}

sheen_status sheen_poses_load(sheen_poses *out, const sheen_session *s, sheen_err *err)
{
    *out = (sheen_poses){0};
    char path[SHEEN_PATH_MAX];
    uint8_t *data;
    size_t size_bytes;
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_POSES, err);
    if (!st && !sheen_file_exists(path))
        return sheen_fail(err, SHEEN_EDATA, "session '%s' has no poses yet: run 'sheen pose' or import them",
                          s->path);
    if (!st)
        st = sheen_file_read(&data, &size_bytes, path, poses_max_bytes, err);
    if (st)
        return st;
    st = sheen_poses_parse(out, data, size_bytes, err);
    free(data);
    return st ? sheen_wrap(err, st, "cannot read '%s'", path) : SHEEN_OK;
}

static void write_pose(sheen_json_writer *w, const sheen_frame_pose *p, bool imported)
{
    sheen_json_open(w, NULL, '{');
    sheen_json_put_string(w, "name", p->name);
    sheen_json_put_bool(w, "found", p->found);
    if (p->found) {
        sheen_json_put_numbers(w, "rt_cam_board", p->rt_cam_board, 6);
        if (!imported) {
            sheen_json_put_numbers(w, "covariance", p->covariance, 36);
            sheen_json_put_number(w, "rms_px", p->rms_px);
            sheen_json_put_int(w, "n_points", p->n_points);
            sheen_json_put_int(w, "n_outliers", p->n_outliers);
        }
    }
    if (p->reason[0] || !p->found)
        sheen_json_put_string(w, "reason", p->reason);
    sheen_json_close(w);
}

static void write_boards(sheen_json_writer *w, const sheen_poses *p)
{
    sheen_json_open(w, "boards", '[');
    for (size_t i = 0; i < p->n_boards; i++) {
        const sheen_board_place *b = &p->boards[i];
        sheen_json_open(w, NULL, '{');
        sheen_json_put_string(w, "name", b->name);
        sheen_json_put_bool(w, "found", b->found);
        if (b->found) {
            sheen_json_put_numbers(w, "rt_ref_board", b->rt_ref_board, 6);
            sheen_json_put_numbers(w, "covariance", b->covariance, 36);
        }
        sheen_json_put_int(w, "n_frames", b->n_frames);
        sheen_json_put_int(w, "n_moved", b->n_moved);
        if (b->reason[0])
            sheen_json_put_string(w, "reason", b->reason);
        sheen_json_close(w);
    }
    sheen_json_close(w);
}

sheen_status sheen_poses_save(const sheen_poses *p, const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_POSES, err);
    if (st)
        return st;
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-poses/1");
    sheen_json_put_bool(&w, "imported", p->imported);
    if (!p->imported)
        st = sheen_stamp_write(&w, s, sheen_poses_inputs, err);
    if (st) {
        sheen_json_writer_release(&w);
        return st;
    }
    if (p->n_boards)
        write_boards(&w, p);
    sheen_json_open(&w, "frames", '[');
    for (size_t i = 0; i < p->n_poses; i++)
        write_pose(&w, &p->poses[i], p->imported);
    sheen_json_close(&w);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}

void sheen_poses_release(sheen_poses *p)
{
    if (!p)
        return;
    free(p->poses);
    free(p->boards);
    p->poses = NULL;
    p->boards = NULL;
    p->n_poses = p->n_boards = 0;
}

// The list need not be sorted: whoever makes one may keep the order of the frames.
const sheen_frame_pose *sheen_poses_find(const sheen_poses *p, const char *name)
{
    for (size_t i = 0; i < p->n_poses; i++)
        if (!strcmp(p->poses[i].name, name))
            return &p->poses[i];
    return NULL;
}

sheen_status sheen_registration_load(double rt_board_obj[6], const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    uint8_t *data;
    size_t size_bytes;
    double rt[6] = {0};
    sheen_json *root = NULL;
    sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_REGISTRATION, err);
    if (st)
        return st;
    if (sheen_file_exists(path)) {
        st = sheen_file_read(&data, &size_bytes, path, registration_max_bytes, err);
        if (st)
            return st;
        st = sheen_json_parse(&root, data, size_bytes, err);
        free(data);
        if (!st)
            st = sheen_json_schema(root, "sheen-registration", REGISTRATION_VERSION, NULL, err);
        if (!st)
            st = sheen_json_numbers(root, "rt_board_obj", rt, 6, err);
        sheen_json_free(&root);
        if (st)
            return sheen_wrap(err, st, "cannot read '%s'", path);
    }
    memcpy(rt_board_obj, rt, sizeof rt);
    return SHEEN_OK;
}

sheen_status sheen_registration_save(const double rt_board_obj[6], const sheen_session *s, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    const sheen_status st = sheen_session_path(path, s, SHEEN_SESSION_REGISTRATION, err);
    if (st)
        return st;
    for (int i = 0; i < 6; i++)
        if (!isfinite(rt_board_obj[i]))
            return sheen_fail(err, SHEEN_EARG, "a registration that is not finite cannot be saved");
    sheen_json_writer w = {0};
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-registration/1");
    sheen_json_put_numbers(&w, "rt_board_obj", rt_board_obj, 6);
    sheen_json_close(&w);
    return sheen_json_save(&w, path, err);
}
