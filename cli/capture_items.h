// SPDX-License-Identifier: Apache-2.0
// capture_items.h - the list of objects of a batch: a table in CSV (RFC 4180).
//
//     name,code,mesh
//     cup-017,4006381333931,meshes/cup.ply
#ifndef SHEEN_CLI_CAPTURE_ITEMS_H
#define SHEEN_CLI_CAPTURE_ITEMS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/file.h"

enum { SHEEN_CLI_ITEM_NAME = 64, SHEEN_CLI_ITEM_CODE = 128, SHEEN_CLI_MAX_ITEMS = 10000 };

typedef struct sheen_cli_item {
    char name[SHEEN_CLI_ITEM_NAME]; // of its session: as a frame's name, which see
    char code[SHEEN_CLI_ITEM_CODE]; // what a scanner types; "": none
    char mesh[SHEEN_PATH_MAX];      // file, or ""
} sheen_cli_item;

typedef struct sheen_cli_items {
    sheen_cli_item *items;
    size_t n;
} sheen_cli_items;

// The first line names the columns, in any order: name, code, mesh; others are passed over. No two objects share a name or
// a code. EFORMAT (with the line), ENOMEM.
sheen_status sheen_cli_items_parse(sheen_cli_items *out, const void *data, size_t size_bytes, sheen_err *err);
sheen_status sheen_cli_items_load(sheen_cli_items *out, const char *path, sheen_err *err);
void sheen_cli_items_release(sheen_cli_items *items);

// The object with this code, else with this name; n where there is none.
size_t sheen_cli_items_find(const sheen_cli_items *items, const char *word);
// Adds one that is not on the list, named by its code with '_' for what a name may not hold; its index is the last. EARG,
// ENOMEM.
sheen_status sheen_cli_items_add(sheen_cli_items *items, const char *code, sheen_err *err);

#endif
