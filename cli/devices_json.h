// SPDX-License-Identifier: Apache-2.0
// devices_json.h - a camera as `sheen devices --json` and the doctor's bundle describe it.
#ifndef SHEEN_CLI_DEVICES_JSON_H
#define SHEEN_CLI_DEVICES_JSON_H

#include "base/json_write.h"
#include "capture/devices.h"

// An object; in an array.
void sheen_cli_put_device(sheen_json_writer *w, const sheen_device *d);

#endif
