// SPDX-License-Identifier: Apache-2.0
// test_capture_items.c - lists of objects as people and spreadsheets write them.
#include "cli/capture_items.h"

#include <string.h>

#include "tests/support.h"

static sheen_status parse(sheen_cli_items *out, const char *text, sheen_err *err)
{
    return sheen_cli_items_parse(out, text, strlen(text), err);
}

static void reads_columns_in_any_order(void **state)
{
    (void)state;
    sheen_cli_items items;
    sheen_err err;
    assert_ok(parse(&items,
                    "\xef\xbb\xbf"
                    "code,remark,name,mesh\r\n4006,\"a, \"\"b\"\"\nc\",cup-1,m/cup.ply\r\n\r\n,,jug",
                    &err),
              err);
    assert_int_equal(items.n, 2);
    assert_string_equal(items.items[0].name, "cup-1");
    assert_string_equal(items.items[0].code, "4006");
    assert_string_equal(items.items[0].mesh, "m/cup.ply");
    assert_string_equal(items.items[1].name, "jug");
    assert_int_equal(sheen_cli_items_find(&items, "4006"), 0);
    assert_int_equal(sheen_cli_items_find(&items, "jug"), 1);
    assert_int_equal(sheen_cli_items_find(&items, "none"), 2);
    assert_ok(sheen_cli_items_add(&items, "A/7 b", &err), err);
    assert_string_equal(items.items[2].name, "A_7_b");
    assert_fails(sheen_cli_items_add(&items, "jug", &err), err, SHEEN_EARG, "no name that is free");
    sheen_cli_items_release(&items);
}

static void says_what_is_wrong(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"", "no column 'name'"},
        {"title,code\n", "no column 'name'"},
        {"name\na/b\n", "line 2: 'a/b' is no name"},
        {"name\na\nb\na\n", "line 4: 'a' has the name"},
        {"name,code\na,1\nb,1\n", "line 3: 'b' has the name or the code of 'a'"},
        {"name\n\"a\n", "line 2: a field is too long"},
        {"name,code\n,5\n", "line 2: '' is no name"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sheen_cli_items items;
        sheen_err err;
        assert_fails(parse(&items, cases[i].text, &err), err, SHEEN_EFORMAT, cases[i].words);
        assert_null(items.items);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_columns_in_any_order),
        cmocka_unit_test(says_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
