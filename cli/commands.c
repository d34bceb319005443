// SPDX-License-Identifier: Apache-2.0
// commands.c - the table of commands, in the order of the help.
#include "cli/cmd.h"

#include <stddef.h>

#include "cli/commands.h"

const sheen_command *const sheen_commands[] = {
    // clang-format off
    &sheen_cmd_board,
    &sheen_cmd_devices,
    &sheen_cmd_turntable,
    &sheen_cmd_capture,
    &sheen_cmd_import,
    &sheen_cmd_calibrate,
    &sheen_cmd_pose,
    &sheen_cmd_register,
    &sheen_cmd_fit,
    &sheen_cmd_render,
    &sheen_cmd_eval,
    &sheen_cmd_export,
    &sheen_cmd_view,
    &sheen_cmd_run,
    &sheen_cmd_doctor,
    NULL,
    // clang-format on
};
