// SPDX-License-Identifier: Apache-2.0
// detect_apriltag.c - tags through libapriltag 3.3: the one file that includes it.
//
// Settings, and why:
//   * min_white_black_diff 25 instead of 5: noise on flat tiles otherwise makes it 7 to 12 times slower, with
//     the same tags found;
//   * quad_sigma stays 0: with decimation 1 the library would blur the caller's picture in place;
//   * at most one corrected bit: with two, false tags appear (3 in 100 frames);
//   * decimation 1 up to 4 megapixels, since it reads tags half as large as decimation 2 does; beyond that the
//     smallest that brings the picture below.
//
// libapriltag puts (0,0) at the outer corner of the top-left pixel: half a pixel is subtracted here, once.
#include "calib/detect.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { FEW_TAGS = 4 };

static const double MAX_DECIMATED_PIXELS = 4e6;
static const double PIXEL_ORIGIN_PX = 0.5;

struct sheen_tag_detector {
    apriltag_family_t *family;
    apriltag_detector_t *detector;
};

static sheen_status check_family(const char *family, sheen_err *err)
{
    if (!strcmp(family, "tag36h11"))
        return SHEEN_OK;
    return sheen_fail(err, SHEEN_EUNSUP,
                      "tags of the family '%.23s' are not supported: use a board of 'tag36h11'", family);
}

sheen_status sheen_tag_detector_new(sheen_tag_detector **detector_out, const char *family, sheen_err *err)
{
    *detector_out = NULL;
    const sheen_status s = check_family(family, err);
    if (s)
        return s;
    sheen_tag_detector *d = calloc(1, sizeof *d);
    if (!d)
        return sheen_fail_memory(err, sizeof *d, "a tag detector");
    d->family = tag36h11_create();
    d->detector = apriltag_detector_create();
    if (!d->family || !d->detector) {
        sheen_tag_detector_free(&d);
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory for a tag detector");
    }
    d->detector->nthreads = 1;
    d->detector->quad_sigma = 0;
    d->detector->qtp.min_white_black_diff = 25;
    apriltag_detector_add_family_bits(d->detector, d->family, 1);
    *detector_out = d;
    return SHEEN_OK;
}

void sheen_tag_detector_free(sheen_tag_detector **detector)
{
    sheen_tag_detector *d = *detector;
    *detector = NULL;
    if (!d)
        return;
    if (d->detector)
        apriltag_detector_destroy(d->detector);
    if (d->family)
        tag36h11_destroy(d->family);
    free(d);
}

static int by_id(const void *a, const void *b)
{
    const sheen_tag_seen *left = a, *right = b;
    return (left->id > right->id) - (left->id < right->id);
}

// Drops every tag whose id occurs twice: one of them is not what it claims, and nothing says which.
static size_t drop_duplicates(sheen_tag_seen *tags, size_t n)
{
    size_t kept = 0;
    for (size_t i = 0; i < n;) {
        size_t same = 1;
        while (i + same < n && tags[i + same].id == tags[i].id)
            same++;
        if (same == 1)
            tags[kept++] = tags[i];
        i += same;
    }
    return kept;
}

// What detecting needs, beside the detector.
typedef struct picture {
    const uint8_t *grey;
    int width_px, height_px;
    const sheen_board_set *boards;
} picture;

// Fills in what was seen of a tag that is printed on one of the boards; false for any other.
static bool take(sheen_tag_seen *seen, const apriltag_detection_t *detection, const sheen_board_set *boards)
{
    const sheen_board_tag *tag = NULL;
    size_t i_board = 0;
    for (; i_board < boards->n_boards; i_board++)
        if ((tag = sheen_board_find_tag(&boards->boards[i_board], detection->id)))
            break;
    if (!tag || !tag->printed || detection->hamming > 1)
        return false;
    seen->id = tag->id;
    seen->i_board = (int)i_board;
    memcpy(seen->p_board, tag->corners_board, sizeof seen->p_board);
    // libapriltag's corners run lower left, lower right, upper right, upper left
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 2; k++)
            seen->q_px[i][k] = detection->p[3 - i][k] - PIXEL_ORIGIN_PX;
    return true;
}

static sheen_status detect_at(sheen_tag_seen **tags_out, size_t *n_out, sheen_tag_detector *d,
                              const picture *p, int decimation, sheen_err *err)
{
    // the library takes a pointer to mutable bytes and, with these settings, leaves them alone
    image_u8_t image = {.width = p->width_px, .height = p->height_px, .stride = p->width_px};
    memcpy(&image.buf, &p->grey, sizeof p->grey);
    d->detector->quad_decimate = (float)decimation;
    zarray_t *found = apriltag_detector_detect(d->detector, &image);
    if (!found)
        return sheen_fail(err, SHEEN_ENOMEM, "out of memory while looking for tags");
    const int n_found = zarray_size(found);
    sheen_tag_seen *tags = calloc((size_t)n_found + 1, sizeof *tags);
    size_t n = 0;
    for (int i = 0; tags && i < n_found; i++) {
        apriltag_detection_t *detection;
        zarray_get(found, i, &detection);
        n += take(&tags[n], detection, p->boards);
    }
    apriltag_detections_destroy(found);
    if (!tags)
        return sheen_fail_memory(err, (double)n_found * sizeof *tags, "tags");
    qsort(tags, n, sizeof *tags, by_id);
    *tags_out = tags;
    *n_out = drop_duplicates(tags, n);
    return SHEEN_OK;
}

sheen_status sheen_tags_detect(sheen_tag_seen **tags_out, size_t *n_out, sheen_tag_detector *detector,
                               const uint8_t *grey, int width_px, int height_px,
                               const sheen_board_set *boards, sheen_err *err)
{
    *tags_out = NULL;
    *n_out = 0;
    if (width_px < 8 || height_px < 8)
        return SHEEN_OK; // no room for a tag
    const picture p = {.grey = grey, .width_px = width_px, .height_px = height_px, .boards = boards};
    int decimation = 1;
    while ((double)width_px * height_px > MAX_DECIMATED_PIXELS * decimation * decimation)
        decimation++;
    const sheen_status s = detect_at(tags_out, n_out, detector, &p, decimation, err);
    if (s || decimation == 1 || *n_out >= FEW_TAGS)
        return s;
    free(*tags_out); // small tags in a large picture
    *tags_out = NULL;
    *n_out = 0;
    return detect_at(tags_out, n_out, detector, &p, 1, err);
}

sheen_status sheen_tag_picture_get(sheen_tag_picture *out, const char *family, int id, sheen_err *err)
{
    *out = (sheen_tag_picture){0};
    sheen_status s = check_family(family, err);
    if (s)
        return s;
    apriltag_family_t *f = tag36h11_create();
    const int n_ids = f ? (int)f->ncodes : 0;
    image_u8_t *image = f && id >= 0 && id < n_ids ? apriltag_to_image(f, id) : NULL;
    if (!f)
        s = sheen_fail(err, SHEEN_ENOMEM, "out of memory for a family of tags");
    else if (id < 0 || id >= n_ids)
        s = sheen_fail(err, SHEEN_EARG, "the family '%s' has no tag %d: its ids are 0 to %d", family, id,
                       n_ids - 1);
    else if (!image || f->width_at_border > SHEEN_TAG_MAX_CELLS)
        s = sheen_fail(err, SHEEN_ENOMEM, "out of memory for a picture of tag %d", id);
    else {
        const int rim = (f->total_width - f->width_at_border) / 2;
        out->side = f->width_at_border;
        for (int row = 0; row < out->side; row++)
            for (int col = 0; col < out->side; col++)
                out->white[row][col] = image->buf[(row + rim) * image->stride + col + rim] > 127;
    }
    if (image)
        free(image->buf);
    free(image);
    if (f)
        tag36h11_destroy(f);
    return s;
}
