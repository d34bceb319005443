// SPDX-License-Identifier: Apache-2.0
// camera_memory.h - cameras that claim what is not so: the options that put it right, remembered with the camera.
//
// A table of this person, ~/.config/sheen/cameras.json: {"schema": "sheen-cameras/1", "cameras": [{"camera":
// "046d:0825", "options": "transfer=srgb&range=full"}]}. A camera is named by vendor and product, by these and the serial
// number after a space, or as it calls itself.
#ifndef SHEEN_CLI_CAMERA_MEMORY_H
#define SHEEN_CLI_CAMERA_MEMORY_H

#include "base/file.h"

enum { SHEEN_CLI_OPTIONS_MAX = 160 };

// The options of the first entry that is this camera's, else those of the program's own table (v4l2_quirks.h); "" where
// nothing is known. identity: "046d:0825 SERIAL",
// or ""; name: as the camera calls itself, or "". EFORMAT.
sheen_status sheen_cli_camera_recall(char options[SHEEN_CLI_OPTIONS_MAX], const char *file,
                                     const char *identity, const char *name, sheen_err *err);
// Enters options ("" removes the entry) for the camera. EIO, EFORMAT (the file that is there).
sheen_status sheen_cli_camera_remember(const char *file, const char *camera, const char *options,
                                       sheen_err *err);
// Those of a URI's options that say what a camera claims wrongly: colorspace, transfer, matrix, range, and which
// exposures it has.
void sheen_cli_camera_claims(char options[SHEEN_CLI_OPTIONS_MAX], const char *uri);
// The URI with what is known of its camera put before its own options, which count more; with `keep` its own are
// remembered first. *noted: what is to be said of it, "" nothing. URIs of other kinds stay as they are.
sheen_status sheen_cli_camera_uri(char uri[SHEEN_PATH_MAX], char noted[240], const char *given, bool keep,
                                  sheen_err *err);

#endif
