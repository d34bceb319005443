// SPDX-License-Identifier: Apache-2.0
// pictures.h - picture files named on a command line, or found in folders named there.
#ifndef SHEEN_CLI_PICTURES_H
#define SHEEN_CLI_PICTURES_H

#include <stddef.h>

#include "base/file.h"

typedef struct sheen_cli_picture_list {
    char (*paths)[SHEEN_PATH_MAX];
    size_t n;
} sheen_cli_picture_list;

// Each of args is a file, taken as it is, or a folder, whose pictures are taken in the order of their names. EDATA:
// none in them. Release after failure, too.
sheen_status sheen_cli_pictures(sheen_cli_picture_list *list, const char *const *args, size_t n,
                                sheen_err *err);
void sheen_cli_pictures_release(sheen_cli_picture_list *list);

#endif
