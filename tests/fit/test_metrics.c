// SPDX-License-Identifier: Apache-2.0
// test_metrics.c - PSNR by hand, and the Stanford-ORB measures against a computation made apart from this program.
#include <math.h>
#include <stdlib.h>

#include "fit/metrics.h"
#include "support.h"

static void fill(sheen_image *img, int width_px, int height_px, float value)
{
    sheen_err err;
    assert_ok(sheen_image_init(img, width_px, height_px, 3, &err), err);
    for (int i = 0; i < 3 * width_px * height_px; i++)
        img->data[i] = value;
}

static void psnr_of_a_constant_difference(void **state)
{
    (void)state;
    sheen_image a, b;
    fill(&a, 8, 4, 0.30f);
    fill(&b, 8, 4, 0.20f);
    const sheen_psnr p = sheen_psnr_of(&a, &b, NULL);
    assert_close(p.linear_db, 20, 1e-4);
    // sRGB codes of 0.30 and 0.20 are 0.58383 and 0.48453
    assert_close(p.srgb_db, -20 * log10(0.583831 - 0.484529), 1e-3);
    assert_int_equal(p.n_pixels, 32);
    sheen_image_release(&a);
    sheen_image_release(&b);
}

static void psnr_counts_selected_pixels_and_clips(void **state)
{
    (void)state;
    sheen_image a, b;
    uint8_t select[6] = {0, 1, 0, 0, 0, 1};
    fill(&a, 3, 2, 0);
    fill(&b, 3, 2, 0);
    a.data[3 * 0] = 1;    // not selected
    a.data[3 * 1] = 5;    // clipped to 1 ...
    b.data[3 * 1] = 7;    // ... as is this
    a.data[3 * 5] = 0.6f; // 0.6 in one of 6 values
    const sheen_psnr p = sheen_psnr_of(&a, &b, select);
    assert_int_equal(p.n_pixels, 2);
    assert_close(p.linear_db, -10 * log10(0.36 / 6), 1e-5);
    for (int i = 0; i < 6; i++)
        select[i] = 0;
    assert_true(isnan(sheen_psnr_of(&a, &b, select).linear_db));
    sheen_image_release(&a);
    sheen_image_release(&b);
}

enum { W = 37, H = 29 };

static void make_pair(sheen_image *rendered, sheen_image *photo, uint8_t *mask)
{
    fill(rendered, W, H, 0);
    fill(photo, W, H, 0);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            mask[y * W + x] = (x - 18) * (x - 18) + (y - 14) * (y - 14) < 12.3 * 12.3;
            for (int c = 0; c < 3; c++) {
                const float ramp = (float)((x * 7 + y * 13 + c * 29) % 64) / 64.0f;
                sheen_image_at(photo, x, y)[c] = ramp * (c == 0 ? 1.6f : 0.9f);
                sheen_image_at(rendered, x, y)[c] = ramp * 0.5f +
                                                    (float)((x * 3 + y * 5 + c * 11) % 16) / 64.0f;
            }
        }
}

// Expected figures: NumPy, with OpenCV's erosion and filter, written from the benchmark's definition.
static void orb_agrees_with_an_independent_computation(void **state)
{
    (void)state;
    sheen_image rendered, photo;
    uint8_t mask[W * H];
    sheen_orb orb;
    sheen_err err;
    make_pair(&rendered, &photo, mask);
    assert_ok(sheen_orb_of(&orb, &rendered, &photo, mask, &err), err);
    assert_close(orb.hdr_db, 19.311539, 1e-4);
    assert_close(orb.ldr_db, 23.669936, 1e-4);
    assert_close(orb.ssim, 0.9502644, 1e-5);
    // A factor on a channel does not matter, a picture of zeros scores no less than flat grey
    for (int i = 0; i < W * H; i++)
        rendered.data[3 * i + 1] *= 3;
    sheen_orb scaled;
    assert_ok(sheen_orb_of(&scaled, &rendered, &photo, mask, &err), err);
    assert_close(scaled.ldr_db, orb.ldr_db, 1e-4);
    sheen_image_release(&rendered);
    fill(&rendered, W, H, 0);
    assert_ok(sheen_orb_of(&scaled, &rendered, &photo, mask, &err), err);
    assert_true(scaled.ldr_db > 0 && scaled.ldr_db < orb.ldr_db);
    sheen_image_release(&rendered);
    sheen_image_release(&photo);
}

static void orb_wants_an_object(void **state)
{
    (void)state;
    sheen_image a, b;
    uint8_t mask[100] = {0};
    sheen_orb orb;
    sheen_err err;
    fill(&a, 10, 10, 0.5f);
    fill(&b, 10, 10, 0.5f);
    mask[55] = 1; // eroded away
    assert_fails(sheen_orb_of(&orb, &a, &b, mask, &err), err, SHEEN_EDATA, "too small");
    sheen_image_release(&a);
    sheen_image_release(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(psnr_of_a_constant_difference),
        cmocka_unit_test(psnr_counts_selected_pixels_and_clips),
        cmocka_unit_test(orb_agrees_with_an_independent_computation),
        cmocka_unit_test(orb_wants_an_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
