// SPDX-License-Identifier: Apache-2.0
// hook.h - --hook: a command that is run at each step of a capture, as gphoto2 runs its hook script.
#ifndef SHEEN_CLI_HOOK_H
#define SHEEN_CLI_HOOK_H

#include "base/session.h"

// Runs `command` by the shell with ACTION ("init", "download", "stop") and ARGUMENT (a file, or "") in its environment,
// and waits for its end. A NULL command does nothing. EIO where it cannot be run or does not end with 0.
sheen_status sheen_cli_hook(const char *command, const char *action, const char *argument, sheen_err *err);
// The same at a frame that is safe on the disk: "download", with its file.
sheen_status sheen_cli_hook_frame(const char *command, const sheen_session *s, const sheen_frame_info *f,
                                  sheen_err *err);

#endif
