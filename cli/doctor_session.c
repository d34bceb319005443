// SPDX-License-Identifier: Apache-2.0
// doctor_session.c - the disk that frames go to, and what is in a session.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>

#include "base/progress.h"
#include "base/session.h"
#include "cli/doctor.h"

enum { PROBE_BYTES = 1 << 20, N_PROBES = 16 };

static void check_speed(sheen_cli_findings *f, const char *folder)
{
    char path[SHEEN_PATH_MAX];
    sheen_err err;
    uint8_t *data = calloc(1, PROBE_BYTES);
    sheen_status s = data ? sheen_path_join(path, folder, ".sheen-doctor", &err)
                          : sheen_fail_memory(&err, PROBE_BYTES, "a measurement");
    const sheen_stopwatch begun = sheen_stopwatch_now();
    for (int i = 0; !s && i < N_PROBES; i++) {
        data[i] = 1; // no two the same
        s = sheen_file_write(path, data, PROBE_BYTES, &err);
    }
    const double took_s = sheen_stopwatch_now().wall_s - begun.wall_s;
    if (!s)
        s = sheen_file_remove(path, &err);
    free(data);
    const double speed = N_PROBES * PROBE_BYTES / 1e6 / took_s;
    if (s)
        sheen_cli_found(f, SHEEN_CLI_WRONG, "disk", "%s", err.msg);
    else
        sheen_cli_found(f, speed < 10 ? SHEEN_CLI_NOTE : SHEEN_CLI_FINE, "disk",
                        "takes %.0f MB/s in files of 1 MB, each safe before the next%s", speed,
                        speed < 10 ? ": stills are not lost to that, a recording at full rate would be" : "");
}

void sheen_cli_check_disk(sheen_cli_findings *f, const char *folder)
{
    struct statvfs v;
    if (statvfs(folder, &v)) {
        sheen_cli_found(f, SHEEN_CLI_WRONG, "disk", "there is no folder '%.200s'", folder);
        return;
    }
    const double free_gb = (double)v.f_bavail * (double)v.f_frsize / 1e9;
    if (free_gb < 1)
        sheen_cli_found(f, SHEEN_CLI_WRONG, "disk", "%.1f GB are free under '%.200s': make room", free_gb,
                        folder);
    else
        sheen_cli_found(f, SHEEN_CLI_FINE, "disk", "%.0f GB are free", free_gb);
    check_speed(f, folder);
}

static size_t count_damaged(const sheen_session *s, char first[64])
{
    size_t n = 0;
    for (size_t i = 0; i < s->n_frames; i++) {
        uint8_t *payload = NULL;
        size_t size_bytes;
        if (sheen_session_payload(&payload, &size_bytes, s, &s->frames[i], NULL) && !n++)
            memcpy(first, s->frames[i].name, 64);
        free(payload);
    }
    return n;
}

static void check_frames(sheen_cli_findings *f, const sheen_session *s)
{
    char first[64] = "";
    size_t n_unlocked = 0, n_devices = 0;
    const char *device = NULL;
    const size_t n_damaged = count_damaged(s, first);
    for (size_t i = 0; i < s->n_frames; i++) {
        const sheen_frame_info *g = &s->frames[i];
        n_unlocked += g->lock == SHEEN_LOCK_OFF;
        if (g->device[0] && (!device || strcmp(device, g->device) != 0)) {
            n_devices++;
            device = g->device;
        }
    }
    if (n_damaged)
        sheen_cli_found(f, SHEEN_CLI_WRONG, "session",
                        "%zu of its frames are damaged, the first is '%s': take or import them again",
                        n_damaged, first);
    else
        sheen_cli_found(f, SHEEN_CLI_FINE, "session",
                        "%zu input, %zu calibration, %zu test, %zu background frames, all whole",
                        sheen_session_count_role(s, SHEEN_ROLE_INPUT),
                        sheen_session_count_role(s, SHEEN_ROLE_CALIBRATION),
                        sheen_session_count_role(s, SHEEN_ROLE_TEST),
                        sheen_session_count_role(s, SHEEN_ROLE_BACKGROUND));
    if (n_unlocked)
        sheen_cli_found(f, SHEEN_CLI_NOTE, "session",
                        "%zu frames were recorded without the lock: their exposures may differ", n_unlocked);
    if (n_devices > 1)
        sheen_cli_found(f, SHEEN_CLI_NOTE, "session",
                        "its frames are of more than one camera, or of one at several ports; one camera "
                        "model stands for all");
}

void sheen_cli_check_session(sheen_cli_findings *f, const char *path)
{
    sheen_session s;
    sheen_err err;
    if (sheen_session_open(&s, path, &err)) {
        sheen_cli_found(f, SHEEN_CLI_WRONG, "session", "%s", err.msg);
        return;
    }
    check_frames(f, &s);
    if (!sheen_session_has(&s, SHEEN_SESSION_BOARD))
        sheen_cli_found(
            f, SHEEN_CLI_NOTE, "session",
            "it has no board.json: its light is not watched and --auto cannot choose (sheen import --board)");
    if (!sheen_session_has(&s, SHEEN_SESSION_CAMERA))
        sheen_cli_found(f, SHEEN_CLI_NOTE, "session", "its camera is not calibrated yet (sheen calibrate)");
    sheen_session_release(&s);
}
