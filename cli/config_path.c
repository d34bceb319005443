// SPDX-License-Identifier: Apache-2.0
// config_path.c - the folder for settings, by the XDG base directory specification.
#include "cli/config_path.h"

#include <stdlib.h>

sheen_status sheen_cli_config_path(char path[SHEEN_PATH_MAX], const char *file, sheen_err *err)
{
    const char *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    const bool is_named = config && *config;
    char dir[SHEEN_PATH_MAX];
    const char *parent = home && *home ? home : ".";
    const sheen_status s = is_named ? sheen_path_join(dir, config, "sheen", err)
                                    : sheen_path_join(dir, parent, ".config/sheen", err);
    return s ? s : sheen_path_join(path, dir, file, err);
}
