// SPDX-License-Identifier: Apache-2.0
// measure.h - sheen capture --dark, --flat, --response: the camera is measured instead of frames recorded.
#ifndef SHEEN_CLI_MEASURE_H
#define SHEEN_CLI_MEASURE_H

#include "capture/measure.h"
#include "cli/cli.h"

// What is asked for.
typedef struct sheen_cli_measure {
    bool dark, flat, response; // one of them
    int bracket;               // with dark: one for each exposure of such a bracket; 0: one
} sheen_cli_measure;

// The camera goes on under the settings of the session's last frame that was taken by it under the lock, and the person is
// told. *followed false: there is none. As sheen_source_follow.
sheen_status sheen_cli_follow(sheen_cli *cli, const sheen_session *s, sheen_source *src, bool covered,
                              bool *followed, sheen_err *err);

// Measures, stores, and says what came of it. Exit code 3 where a response disagrees with its exposures.
sheen_status sheen_cli_measure_camera(sheen_cli *cli, const sheen_cli_measure *what, const sheen_session *s,
                                      sheen_source *src, const sheen_record_options *o, sheen_err *err);

#endif
