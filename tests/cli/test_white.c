// SPDX-License-Identifier: Apache-2.0
// test_white.c - the white beside the tags is found, and a light that is switched off ends a capture.
#include "cli/white.h"

#include <string.h>

#include <linux/videodev2.h>

#include "tests/support.h"

enum { W = 80, H = 60 };

// A white page with two black tags; the second stands partly outside of the picture.
static void draw(uint8_t *rgb, const uint8_t white[3])
{
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            const bool black = y >= 20 && y <= 40 && ((x >= 10 && x <= 30) || x >= 60);
            for (int c = 0; c < 3; c++)
                rgb[3 * (y * W + x) + c] = black ? 0 : white[c];
        }
}

static const sheen_tag_seen tags[] = {
    {.id = 0, .q_px = {{10, 20}, {30, 20}, {30, 40}, {10, 40}}},
    {.id = 1, .q_px = {{60, 20}, {80, 20}, {80, 40}, {60, 40}}},
};

static void the_white_is_that_of_the_paper(void **state)
{
    (void)state;
    static const uint8_t white[3] = {200, 180, 160};
    sheen_raster r;
    sheen_err err;
    float rgb[3];
    assert_ok(sheen_raster_init(&r, W, H, 3, 8, &err), err);
    draw(r.data, white);
    assert_true(sheen_cli_white_measure(rgb, &r, SHEEN_TRANSFER_LINEAR, tags, 2));
    for (int c = 0; c < 3; c++)
        assert_close(rgb[c], white[c] / 255.0, 1e-6);
    assert_true(sheen_cli_white_measure(rgb, &r, SHEEN_TRANSFER_SRGB, tags, 2));
    assert_close(rgb[0], sheen_transfer_decode(SHEEN_TRANSFER_SRGB, 200 / 255.0f), 1e-6);
    assert_false(sheen_cli_white_measure(rgb, &r, SHEEN_TRANSFER_SRGB, tags, 0));
    sheen_raster_release(&r);
}

static const char board[] = SHEEN_TEST_DATA "/penguin/board.json";

static void what_shows_no_board_is_counted(void **state)
{
    (void)state;
    static const uint8_t white[3] = {200, 180, 160};
    uint8_t picture[3 * W * H];
    sheen_cli_white w = {0};
    sheen_frame frame = {.data = picture, .size_bytes = sizeof picture, .extension = "raw"};
    sheen_err err;
    draw(picture, white);
    sheen_frame_info_init(&frame.info);
    frame.info.fourcc = V4L2_PIX_FMT_RGB24;
    frame.info.width_px = W;
    frame.info.height_px = H;
    frame.info.stride_bytes = 3 * W;
    assert_ok(sheen_cli_white_check(&w, &frame, &err), err); // no board: nothing is watched
    assert_true(!w.n_seen && !w.n_unseen);
    assert_ok(sheen_board_set_load(&w.boards, board, &err), err);
    assert_ok(sheen_tag_detector_new(&w.detector, w.boards.boards[0].family, &err), err);
    assert_ok(sheen_cli_white_check(&w, &frame, &err), err);
    assert_true(!w.n_seen && w.n_unseen == 1);
    frame.size_bytes--;
    assert_fails(sheen_cli_white_check(&w, &frame, &err), err, SHEEN_EFORMAT, "cut short");
    sheen_cli_white_release(&w);
}

int main(void)
{
    const struct CMUnitTest tests_[] = {
        cmocka_unit_test(the_white_is_that_of_the_paper),
        cmocka_unit_test(what_shows_no_board_is_counted),
    };
    return cmocka_run_group_tests(tests_, NULL, NULL);
}
