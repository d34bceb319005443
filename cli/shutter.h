// SPDX-License-Identifier: Apache-2.0
// shutter.h - Enter and SIGUSR1 ask for one frame; "q" or the end of the terminal's input ends a capture.
#ifndef SHEEN_CLI_SHUTTER_H
#define SHEEN_CLI_SHUTTER_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

// From now on SIGUSR1 asks for a frame.
void sheen_cli_shutter_open(void);
// The moment of the last request (CLOCK_MONOTONIC nanoseconds), once; or -1.
int64_t sheen_cli_shutter(void);
// For sheen_record_policy.ask: a frame for each request, until no more will come (EEND). self is not looked at.
sheen_status sheen_cli_shutter_ask(void *self, int64_t *since_ns, sheen_err *err);
// True once no more will be asked for.
bool sheen_cli_shutter_ended(void);

#endif
