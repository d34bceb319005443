// SPDX-License-Identifier: Apache-2.0
// with_camera.c - runs a program that sees a fake camera:
//
//     with_camera SESSION|- PLAN PROGRAM [ARGUMENT...]
//
// The camera is /dev/video<node> (and behind FAKE_LINK); it delivers SESSION's frames in a loop, or (-) a flat picture as
// its settings make it. PLAN is what goes wrong, "node=42;rate=30;unplug_at=20" (fake_plan.c), or "".
#define _GNU_SOURCE // NOLINT: memfd_create
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <sys/mman.h>

#include "tests/fake/fake_parts.h"

static void put(FILE *out, const void *data, size_t size_bytes)
{
    if (fwrite(data, 1, size_bytes, out) != size_bytes) {
        perror("with_camera");
        exit(99);
    }
}

// The recording as one file without a name, which the program inherits.
static int hand_over(const fake_v4l2 *f)
{
    const int fd = memfd_create("recording", 0);
    FILE *out = fd < 0 ? NULL : fdopen(dup(fd), "wb");
    fake_recording r = {.n_frames = f->n_payloads,
                        .fourcc = f->fourcc,
                        .width_px = (uint32_t)f->width_px,
                        .height_px = (uint32_t)f->height_px,
                        .stride_bytes = (uint32_t)f->stride_bytes,
                        .color = f->color};
    memcpy(r.magic, FAKE_MAGIC, sizeof r.magic);
    if (!out)
        return -1;
    put(out, &r, sizeof r);
    uint64_t at_bytes = sizeof r + f->n_payloads * sizeof(fake_recorded_frame);
    for (size_t i = 0; i < f->n_payloads; i++) {
        const fake_recorded_frame g = {at_bytes, f->payload_bytes[i], f->recorded[i]};
        put(out, &g, sizeof g);
        at_bytes += g.size_bytes;
    }
    for (size_t i = 0; i < f->n_payloads; i++)
        put(out, f->payloads[i], f->payload_bytes[i]);
    return fclose(out) ? -1 : fd;
}

static int load(const char *path)
{
    fake_v4l2 f;
    sheen_session s;
    sheen_err err;
    char number[16];
    fake_v4l2_reset(&f);
    sheen_status st = sheen_session_open(&s, path, &err);
    if (!st) {
        st = fake_v4l2_play(&f, &s, &err);
        sheen_session_release(&s);
    }
    if (st) {
        fprintf(stderr, "with_camera: %s\n", err.msg);
        return -1;
    }
    const int fd = hand_over(&f);
    fake_v4l2_release(&f);
    snprintf(number, sizeof number, "%d", fd);
    return fd < 0 ? -1 : setenv(FAKE_ENV_FILE, number, 1);
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        fprintf(stderr, "usage: with_camera SESSION|- PLAN PROGRAM [ARGUMENT...]\n");
        return 2;
    }
    if (strcmp(argv[1], "-") != 0 && load(argv[1]))
        return 99;
    setenv(FAKE_ENV_PLAN, argv[2], 1);
    setenv("LD_PRELOAD", FAKE_LIBRARY, 1);
    execvp(argv[3], argv + 3);
    fprintf(stderr, "with_camera: cannot start '%s': %s\n", argv[3], strerror(errno));
    return 99;
}
