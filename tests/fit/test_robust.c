// SPDX-License-Identifier: Apache-2.0
// test_robust.c - the M-estimator's functions against their formulas and each other.
#include <math.h>

#include "fit/robust.h"
#include "support.h"

static void rho_is_the_formula(void **state)
{
    (void)state;
    assert_close(sheen_loss_rho(SHEEN_LOSS_LORENTZIAN, 0.3, 0.1), log(1 + 9.0 / 2), 1e-12);
    assert_close(sheen_loss_rho(SHEEN_LOSS_QUARTIC, 0.3, 0.1), log(1 + 81.0 / 2), 1e-12);
    assert_close(sheen_loss_rho(SHEEN_LOSS_LORENTZIAN, 0, 0.1), 0, 0);
}

// weight = rho'(r) / r up to one constant for all r: compare ratios with finite differences.
static void weight_is_the_slope_over_the_residual(void **state)
{
    (void)state;
    static const sheen_loss losses[] = {SHEEN_LOSS_LORENTZIAN, SHEEN_LOSS_QUARTIC};
    for (size_t k = 0; k < 2; k++)
        for (double r = 0.02; r < 1; r += 0.07) {
            const double h = 1e-6, s = 0.1;
            const double slope = (sheen_loss_rho(losses[k], r + h, s) - sheen_loss_rho(losses[k], r - h, s)) /
                                 (2 * h);
            assert_close(sheen_loss_weight(losses[k], r, s), slope / r * s * s, 1e-6);
        }
    assert_close(sheen_loss_weight(SHEEN_LOSS_LORENTZIAN, 0, 0.1), 1, 0);
}

static void scale_is_sigma_in_spite_of_outliers(void **state)
{
    (void)state;
    enum { N = 20000 };
    static double r[N], scratch[N];
    uint64_t seed = 5;
    for (int i = 0; i < N; i++)
        r[i] = i % 10 ? 0.02 * test_random_normal(&seed) : 1 + test_random(&seed); // a tenth is nonsense
    assert_close(sheen_robust_scale(r, N, scratch), 0.02 * 1.17,
                 0.02 * 0.03); // median of a 90 % share: 1.17 sigma
    assert_close(sheen_robust_scale(r, 0, scratch), 0, 0);
    for (size_t n = 1; n < 60; n++) { // against counting, with ties
        size_t below = 0, above = 0;
        for (size_t i = 0; i < n; i++)
            r[i] = floor(8 * test_random(&seed));
        const double median = sheen_robust_scale(r, n, scratch) / 1.4826;
        for (size_t i = 0; i < n; i++) {
            below += r[i] < median - 1e-9;
            above += r[i] > median + 1e-9;
        }
        assert_true(below <= n / 2 && above < n - n / 2);
    }
}

static void mean_is_over_all_residuals(void **state)
{
    (void)state;
    const double r[2] = {0.1, 0};
    assert_close(sheen_loss_mean(SHEEN_LOSS_LORENTZIAN, r, 2, 0.1), 0.5 * log(1.5), 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rho_is_the_formula),
        cmocka_unit_test(weight_is_the_slope_over_the_residual),
        cmocka_unit_test(scale_is_sigma_in_spite_of_outliers),
        cmocka_unit_test(mean_is_over_all_residuals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
