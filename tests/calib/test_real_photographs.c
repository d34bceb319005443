// SPDX-License-Identifier: Apache-2.0
// Real photographs that others published, with what they found in them. They are not part of the project: where
// SHEEN_TEST_PHOTOS names their folder they are used (its sub-folders are named below), otherwise this is skipped.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image_file.h"
#include "base/json.h"
#include "calib/calibrate_session.h"
#include "calib/saddles.h"
#include "support.h"
#include "support_board.h"

static void path_of(char out[TEST_PATH_MAX], const char *file)
{
    const char *folder = getenv("SHEEN_TEST_PHOTOS");
    if (!folder) {
        test_skip("SHEEN_TEST_PHOTOS names no folder of photographs");
        return;
    }
    snprintf(out, TEST_PATH_MAX, "%s/%s", folder, file);
}

// A webcam's pictures of a chessboard of 10 x 10 corners, found by mrgingham; mrcal reached 0.176 and 0.269 px rms.
static void webcam_boards_fit_as_well_as_mrcal(void **state)
{
    static const struct {
        const char *file;
        int size_px[2];
        double reference_px;
    } sets[] = {{"C1_photonvision_lifecam/derived_mrcal/corners_480.vnl", {640, 480}, 0.176},
                {"C1_photonvision_lifecam/derived_mrcal/corners_1280.vnl", {1280, 720}, 0.269}};
    for (size_t i = 0; i < 2; i++) {
        sheen_err err;
        sheen_board board;
        sheen_calibration c;
        char vnl[TEST_PATH_MAX], json[TEST_PATH_MAX];
        const sheen_calibrate_options options = {.lensmodel = "opencv5"};
        path_of(vnl, sets[i].file);
        test_scratch_file(json, *state, "board.json");
        test_board_make(&board, 11, 11, 0.0254, 0.7, 0, 0);
        test_board_save(&board, json);
        assert_ok(sheen_calibrate_table(&c, vnl, sets[i].size_px, json, &options, &err), err);
        print_message("%s: %.3f px rms (reference %.3f), %d of %d corners are outliers\n", sets[i].file,
                      c.rms_px, sets[i].reference_px, c.n_outliers, c.n_corners);
        assert_true(c.rms_px <= sets[i].reference_px);
        sheen_calibration_release(&c);
        sheen_board_release(&board);
    }
}

// One frame: how many of the published tags are found, and how far corners are from the published ones.
static void compare_frame(const sheen_json *published, const char *png, const sheen_board *board,
                          sheen_tag_detector *detector, int counts[2], double *worst_px)
{
    sheen_err err;
    sheen_raster raster;
    sheen_tag_seen *tags;
    size_t n;
    sheen_board one = *board;
    const sheen_board_set set = {.boards = &one, .n_boards = 1};
    assert_ok(sheen_raster_load(&raster, png, &err), err);
    uint8_t *grey = malloc((size_t)raster.width_px * (size_t)raster.height_px);
    assert_non_null(grey);
    sheen_raster_grey(grey, &raster, SHEEN_TRANSFER_SRGB);
    assert_ok(sheen_tags_detect(&tags, &n, detector, grey, raster.width_px, raster.height_px, &set, &err),
              err);
    for (int id = 0; id <= 10; id++) {
        char key[16];
        double yx[8];
        snprintf(key, sizeof key, "%d", id);
        const sheen_json *tag = sheen_json_get(published, key);
        if (!tag)
            continue;
        counts[0]++;
        assert_ok(sheen_json_numbers(tag, "tag_corners", yx, 8, &err), err);
        for (size_t i = 0; i < n; i++)
            if (tags[i].id == id) {
                counts[1]++;
                for (int k = 0; k < 4; k++)
                    *worst_px = fmax(*worst_px, hypot(tags[i].q_px[3 - k][0] + 0.5 - yx[2 * k + 1],
                                                      tags[i].q_px[3 - k][1] + 0.5 - yx[2 * k]));
            }
    }
    free(tags);
    free(grey);
    sheen_raster_release(&raster);
}

static void every_published_tag_is_found(void **state)
{
    (void)state;
    sheen_err err;
    sheen_json *root;
    const sheen_json *frames;
    sheen_board board;
    sheen_tag_detector *detector;
    char path[TEST_PATH_MAX], file[64];
    int counts[2] = {0}, n_frames = 0;
    double worst_px = 0;
    path_of(path, "B1_visp_rbt/apriltag_data.json");
    assert_ok(sheen_json_load(&root, path, &err), err);
    assert_ok(sheen_json_array(root, "detections", &frames, &err), err);
    test_board_make(&board, 6, 4, 0.12, 0.79, 0, 0); // ids 0 to 11; where they are does not matter here
    assert_ok(sheen_tag_detector_new(&detector, board.family, &err), err);
    for (size_t i = 0; i < sheen_json_count(frames); i++) {
        snprintf(file, sizeof file, "B1_visp_rbt/color/color_image_%04zu.png", i);
        path_of(path, file);
        if (!sheen_file_exists(path))
            continue;
        n_frames++;
        compare_frame(sheen_json_at(frames, i), path, &board, detector, counts, &worst_px);
    }
    print_message("tags in %d video frames: %d of %d published ones, corners within %.2f px\n", n_frames,
                  counts[1], counts[0], worst_px);
    assert_true(n_frames > 0);
    assert_int_equal(counts[0], counts[1]);
    assert_true(worst_px < 3);
    sheen_json_free(&root);
    sheen_tag_detector_free(&detector);
    sheen_board_release(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(webcam_boards_fit_as_well_as_mrcal, test_scratch_setup,
                                        test_scratch_teardown),
        cmocka_unit_test(every_published_tag_is_found),
    };
    return test_result(cmocka_run_group_tests(tests, NULL, NULL));
}
