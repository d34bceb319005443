// SPDX-License-Identifier: Apache-2.0
// doctor.h - what `sheen doctor` looks at, a function a part of the station; each adds what it found.
#ifndef SHEEN_CLI_DOCTOR_H
#define SHEEN_CLI_DOCTOR_H

#include "capture/devices.h"

typedef enum sheen_cli_severity {
    SHEEN_CLI_FINE,
    SHEEN_CLI_NOTE,  // works, could be better
    SHEEN_CLI_WRONG, // stands in the way
} sheen_cli_severity;

typedef struct sheen_cli_finding {
    sheen_cli_severity severity;
    char about[160]; // "camera '/dev/video0'"
    char text[400];  // what was found, and what to do about it
} sheen_cli_finding;

enum { SHEEN_CLI_MAX_FINDINGS = 128 };
typedef struct sheen_cli_findings {
    sheen_cli_finding findings[SHEEN_CLI_MAX_FINDINGS]; // beyond: left out
    size_t n_findings, n_wrong;
} sheen_cli_findings;

void sheen_cli_found(sheen_cli_findings *f, sheen_cli_severity severity, const char *about, const char *fmt,
                     ...) SHEEN_PRINTF(4, 5);

// Each camera by itself and against the others.
void sheen_cli_check_cameras(sheen_cli_findings *f, const sheen_device *devices, size_t n_devices);
// The machine: drivers, udev, programs that are in the way, memory. `root` is put before /sys, /proc, /run, /etc and so
// on: "" but in tests. n_devices: how many cameras were found.
void sheen_cli_check_machine(sheen_cli_findings *f, const char *root, size_t n_devices);
// The disk under a folder: room, and how fast it takes frames (writes 16 MB there, and removes them).
void sheen_cli_check_disk(sheen_cli_findings *f, const char *folder);
// A session: whether it can be read, its frames are whole, and what it still lacks.
void sheen_cli_check_session(sheen_cli_findings *f, const char *path);

#endif
