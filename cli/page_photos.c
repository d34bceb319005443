// SPDX-License-Identifier: Apache-2.0
// page_photos.c - photographs beside a page's drawings: straightened, small, with the poses that they were taken from.
#include "cli/page_photos.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/camera_undistort.h"
#include "base/image_file.h"
#include "base/pose3.h"
#include "render/page.h"

enum { QUALITY = 80 };

sheen_status sheen_page_photos_open(sheen_page_photos *out, const sheen_session *s, size_t most,
                                    sheen_err *err)
{
    *out = (sheen_page_photos){.count = 0};
    const sheen_status st = sheen_poses_load(&out->poses, s, err);
    if (st)
        return st;
    size_t n_inputs = 0;
    most = most < SHEEN_PAGE_MAX_PHOTOS ? most : SHEEN_PAGE_MAX_PHOTOS;
    for (int round = 0; round < 2; round++) { // first counted, then chosen
        size_t i_input = 0;
        for (size_t i = 0; i < out->poses.n_poses; i++) {
            const sheen_frame_info *f = sheen_session_find(s, out->poses.poses[i].name);
            if (!f || f->role != SHEEN_ROLE_INPUT || !out->poses.poses[i].found)
                continue;
            if (round && out->count < most && i_input * most >= out->count * n_inputs)
                out->i_pose[out->count++] = i;
            i_input++;
        }
        n_inputs = i_input;
    }
    return SHEEN_OK;
}

void sheen_page_photos_close(sheen_page_photos *p)
{
    sheen_poses_release(&p->poses);
    p->count = 0;
}

sheen_status sheen_page_jpeg(uint8_t **jpeg, size_t *jpeg_bytes, const sheen_image *lin, sheen_err *err)
{
    sheen_raster r;
    sheen_status st = sheen_raster_from_linear(&r, lin, err);
    if (st)
        return st;
    st = sheen_jpeg_encode(jpeg, jpeg_bytes, &r, QUALITY, err);
    sheen_raster_release(&r);
    return st;
}

sheen_status sheen_page_photo(uint8_t **jpeg, size_t *jpeg_bytes, const sheen_page_photos *p, size_t i,
                              const sheen_session *s, const sheen_camera *cam, int width_px, sheen_err *err)
{
    sheen_image lin, straight = {0};
    sheen_camera pinhole;
    const sheen_frame_info *f = sheen_session_find(s, p->poses.poses[p->i_pose[i]].name);
    *jpeg = NULL;
    if (!f)
        return sheen_fail(err, SHEEN_EDATA, "the photograph is gone from the session");
    width_px = width_px < cam->width_px ? width_px : cam->width_px;
    const int height_px = (int)((double)width_px * cam->height_px / cam->width_px + 0.5);
    const double f_px = cam->intrinsics[0] * width_px / cam->width_px;
    const double fxycxy[4] = {f_px, f_px, (width_px - 1) / 2.0, (height_px - 1) / 2.0};
    sheen_status st = sheen_camera_opencv(&pinhole, width_px, height_px, fxycxy, NULL, 0, err);
    if (st || (st = sheen_session_image(&lin, s, f, err)))
        return st;
    st = sheen_image_undistort(&straight, &lin, cam, &pinhole, 0, err);
    if (!st)
        st = sheen_page_jpeg(jpeg, jpeg_bytes, &straight, err);
    sheen_image_release(&straight);
    sheen_image_release(&lin);
    return st;
}

static sheen_status put_source(sheen_json_writer *w, const sheen_page_photos *p, size_t i,
                               const sheen_session *s, const sheen_camera *cam, bool inside, int width_px,
                               sheen_err *err)
{
    static const char scheme[] = "data:image/jpeg;base64,";
    char name[32];
    uint8_t *jpeg;
    size_t jpeg_bytes;
    if (!inside) {
        snprintf(name, sizeof name, "photo/%zu", i);
        sheen_json_put_string(w, "src", name);
        return SHEEN_OK;
    }
    const sheen_status st = sheen_page_photo(&jpeg, &jpeg_bytes, p, i, s, cam, width_px, err);
    if (st)
        return st;
    char *text = malloc(sizeof scheme + 4 * (jpeg_bytes / 3 + 1));
    if (text) {
        memcpy(text, scheme, sizeof scheme - 1);
        *sheen_put_base64(text + sizeof scheme - 1, jpeg, jpeg_bytes) = 0;
        sheen_json_put_string(w, "src", text);
    }
    free(text);
    free(jpeg);
    return text ? SHEEN_OK : sheen_fail_memory(err, 2.0 * (double)jpeg_bytes, "a page's photographs");
}

sheen_status sheen_page_more(char **json, const sheen_page_photos *p, const sheen_session *s,
                             const sheen_cli_view *v, const double look_deg[2], bool inside, int width_px,
                             sheen_err *err)
{
    sheen_json_writer w = {0};
    sheen_status st = SHEEN_OK;
    *json = NULL;
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_numbers(&w, "first_view_deg", look_deg, 2);
    if (!inside)
        sheen_json_put_string(&w, "state", "state");
    sheen_json_put_number(&w, "photograph_aspect", (double)v->camera.width_px / v->camera.height_px);
    sheen_json_open(&w, "photographs", '[');
    for (size_t i = 0; !st && i < p->count; i++) {
        const sheen_frame_pose *pose = &p->poses.poses[p->i_pose[i]];
        double rt_cam_obj[6];
        sheen_rt_compose(rt_cam_obj, pose->rt_cam_board, v->rt_board_obj);
        sheen_json_open(&w, NULL, '{');
        sheen_json_put_string(&w, "name", pose->name);
        sheen_json_put_numbers(&w, "rt_cam_obj", rt_cam_obj, 6);
        st = put_source(&w, p, i, s, &v->camera, inside, width_px, err);
        sheen_json_close(&w);
    }
    sheen_json_close(&w);
    sheen_json_close(&w);
    const char *text = sheen_json_text(&w);
    if (!st && (!text || !(*json = malloc(strlen(text) + 1))))
        st = sheen_fail_memory(err, 1e5, "a page");
    if (!st)
        memcpy(*json, text, strlen(text) + 1);
    sheen_json_writer_release(&w);
    return st;
}
