// SPDX-License-Identifier: Apache-2.0
// v4l2_quirks.h - cameras that are known to claim what is not so.
#ifndef SHEEN_CAPTURE_V4L2_QUIRKS_H
#define SHEEN_CAPTURE_V4L2_QUIRKS_H

// The options (v4l2_options.h) that put a camera's claims right, NULL where nothing is known against them. identity:
// "046d:0825 SERIAL", or ""; name: as the camera calls itself, or "". The text is the program's.
const char *sheen_v4l2_quirk(const char *identity, const char *name);

#endif
