// SPDX-License-Identifier: Apache-2.0
// shutter.h - Enter and SIGUSR1 ask for one frame; "q" or the end of the terminal's input ends a capture.
#ifndef SHEEN_CLI_SHUTTER_H
#define SHEEN_CLI_SHUTTER_H

#include <stdbool.h>
#include <stdint.h>

// From now on SIGUSR1 asks for a frame.
void sheen_cli_shutter_open(void);
// For sheen_record_options.wanted, which see: the moment of the last request, once; or -1.
int64_t sheen_cli_shutter(void *unused);
// True once no more will be asked for.
bool sheen_cli_shutter_ended(void);

#endif
