// SPDX-License-Identifier: Apache-2.0
// commands.h - the commands, each in its file cmd_<name>.c.
#ifndef SHEEN_CLI_COMMANDS_H
#define SHEEN_CLI_COMMANDS_H

#include "cli/cmd.h"

extern const sheen_command sheen_cmd_board;
extern const sheen_command sheen_cmd_devices;
extern const sheen_command sheen_cmd_doctor;
extern const sheen_command sheen_cmd_capture;
extern const sheen_command sheen_cmd_import;
extern const sheen_command sheen_cmd_calibrate;
extern const sheen_command sheen_cmd_pose;
extern const sheen_command sheen_cmd_register;
extern const sheen_command sheen_cmd_fit;
extern const sheen_command sheen_cmd_render;
extern const sheen_command sheen_cmd_eval;
extern const sheen_command sheen_cmd_export;
extern const sheen_command sheen_cmd_view;
extern const sheen_command sheen_cmd_run;
extern const sheen_command sheen_cmd_turntable;

#endif
