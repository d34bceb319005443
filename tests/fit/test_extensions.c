// SPDX-License-Identifier: Apache-2.0
// test_extensions.c - switches by name.
#include "fit/extensions.h"
#include "support.h"

#include <string.h>

static void every_name_is_its_own_bit(void **state)
{
    (void)state;
    sheen_extensions all = 0;
    for (int e = 0; e < SHEEN_EXTENSION_COUNT; e++) {
        sheen_extensions one;
        sheen_err err;
        assert_ok(sheen_extensions_parse(&one, sheen_extension_name((sheen_extension)e), &err), err);
        for (int k = 0; k < SHEEN_EXTENSION_COUNT; k++)
            assert_int_equal(sheen_extension_in(one, (sheen_extension)k), k != e);
        assert_int_equal(all & one, 0);
        all |= one;
    }
}

static void lists_and_what_is_no_name(void **state)
{
    (void)state;
    sheen_extensions both, align;
    sheen_err err;
    assert_ok(sheen_extensions_parse(&both, "poses,exposures", &err), err);
    assert_ok(sheen_extensions_parse(&align, "align", &err), err);
    assert_int_equal(both, align);
    assert_ok(sheen_extensions_parse(&both, "", &err), err);
    assert_int_equal(both, 0);
    static const char *const wrong[] = {"lamp", "lampss", ",", "lamps,,tail", "lamps, tail"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(sheen_extensions_parse(&both, wrong[i], &err), SHEEN_EARG);
        assert_non_null(strstr(err.msg, "regions"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_name_is_its_own_bit),
        cmocka_unit_test(lists_and_what_is_no_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
