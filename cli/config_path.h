// SPDX-License-Identifier: Apache-2.0
// config_path.h - where what is remembered for one person stands.
#ifndef SHEEN_CLI_CONFIG_PATH_H
#define SHEEN_CLI_CONFIG_PATH_H

#include "base/file.h"

// A file in $XDG_CONFIG_HOME/sheen, else in ~/.config/sheen. EARG: too long.
sheen_status sheen_cli_config_path(char path[SHEEN_PATH_MAX], const char *file, sheen_err *err);

#endif
