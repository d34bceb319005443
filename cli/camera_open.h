// SPDX-License-Identifier: Apache-2.0
// camera_open.h - the one way in which every command opens the camera that a person names.
#ifndef SHEEN_CLI_CAMERA_OPEN_H
#define SHEEN_CLI_CAMERA_OPEN_H

#include "capture/source.h"
#include "cli/cli.h"

// Opens a camera's URI with what is known of that camera (camera_memory.h), which is said; with `keep` the URI's own
// options are remembered for it first. *src is the caller's to close. Errors as sheen_source_open and
// sheen_cli_camera_uri.
sheen_status sheen_cli_camera_open(sheen_cli *cli, sheen_source **src, const char *uri, bool keep,
                                   sheen_err *err);

#endif
