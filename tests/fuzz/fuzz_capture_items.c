// SPDX-License-Identifier: Apache-2.0
// fuzz_capture_items.c - any bytes as a batch's list: names that a session may have, texts that end, nobody twice.
#include <stdlib.h>
#include <string.h>

#include "base/session.h"
#include "cli/capture_items.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_cli_items items;
    if (sheen_cli_items_parse(&items, data, size_bytes, NULL))
        return 0;
    for (size_t i = 0; i < items.n; i++) {
        const sheen_cli_item *item = &items.items[i];
        if (!sheen_frame_name_ok(item->name) || !memchr(item->code, 0, sizeof item->code) ||
            !memchr(item->mesh, 0, sizeof item->mesh) || sheen_cli_items_find(&items, item->name) == items.n)
            abort();
    }
    sheen_cli_items_release(&items);
    return 0;
}
