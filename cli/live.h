// SPDX-License-Identifier: Apache-2.0
// live.h - a calibration made live: takes a frame when the board is still and sharp, and says where to hold it next.
#ifndef SHEEN_CLI_LIVE_H
#define SHEEN_CLI_LIVE_H

#include "base/session.h"
#include "cli/cli.h"

typedef struct sheen_live_options {
    const char *device; // URI
    double accuracy_px; // largest uncertainty over the image to stop at
    int max_frames;
} sheen_live_options;

// Records calibration frames into the session until the accuracy or max_frames is reached, the source ends, or the
// person stops it. The session must have a board. *n_taken: frames recorded.
sheen_status sheen_cli_live(sheen_cli *cli, sheen_session *s, const sheen_live_options *options,
                            size_t *n_taken, sheen_err *err);

#endif
