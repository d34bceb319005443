// SPDX-License-Identifier: Apache-2.0
// pictures.c - lists pictures by the endings that image files have.
#include "cli/pictures.h"

#include <stdio.h>
#include <stdlib.h>
#include <strings.h>

void sheen_cli_pictures_release(sheen_cli_picture_list *list)
{
    free(list->paths);
    *list = (sheen_cli_picture_list){0};
}

static sheen_status list_add(sheen_cli_picture_list *list, const char *folder, const char *name,
                             sheen_err *err)
{
    char(*paths)[SHEEN_PATH_MAX] = realloc(list->paths, (list->n + 1) * sizeof *paths);
    if (!paths)
        return sheen_fail_memory(err, (double)(list->n + 1) * sizeof *paths, "a list of pictures");
    list->paths = paths;
    const sheen_status s = folder ? sheen_path_join(paths[list->n], folder, name, err)
                                  : sheen_path_join(paths[list->n], ".", name, err);
    if (!s && !folder && snprintf(paths[list->n], SHEEN_PATH_MAX, "%s", name) >= SHEEN_PATH_MAX)
        return sheen_fail(err, SHEEN_EARG, "the path is too long");
    list->n += !s;
    return s;
}

static sheen_status list_folder(sheen_cli_picture_list *list, const char *folder, sheen_err *err)
{
    static const char *const endings[] = {"jpg", "jpeg", "png", "tif", "tiff", "exr"};
    sheen_names names;
    sheen_status s = sheen_dir_list(&names, folder, NULL, err);
    if (s)
        return s;
    for (size_t i = 0; i < names.count && !s; i++)
        for (size_t e = 0; e < sizeof endings / sizeof *endings && !s; e++)
            if (!strcasecmp(sheen_path_extension(names.names[i]), endings[e]))
                s = list_add(list, folder, names.names[i], err);
    sheen_names_release(&names);
    return s;
}

sheen_status sheen_cli_pictures(sheen_cli_picture_list *list, const char *const *args, size_t n,
                                sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    *list = (sheen_cli_picture_list){0};
    for (size_t i = 0; i < n && !s; i++)
        s = sheen_dir_exists(args[i]) ? list_folder(list, args[i], err) : list_add(list, NULL, args[i], err);
    if (!s && !list->n)
        s = sheen_fail(err, SHEEN_EDATA, "there are no pictures in '%s'", args[0]);
    return s;
}
