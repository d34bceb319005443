// SPDX-License-Identifier: Apache-2.0
// usbip_camera.c - the simulated camera at the kernel's vhci_hcd, over the USB/IP protocol and without a network:
//
//     usbip_camera SESSION|- PORT [deaf | table=TTY]      until it is killed: then the camera is unplugged
//
// table=TTY: a Grbl controller with a turntable is at the other end of that serial line, and the camera sees it: SESSION's
// frames are one turn of it. Without power (while the line hangs up) the table stays where it is.
//
// See Documentation/usb/usbip_protocol.rst of the kernel: 48 bytes of header in big-endian numbers, then data.
#include <arpa/inet.h>
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <sys/socket.h>

#include "tests/fake/fake_grbl.h"
#include "tests/vm/uvc_camera.h"

enum { CMD_SUBMIT = 1, CMD_UNLINK, RET_SUBMIT, RET_UNLINK, MAX_PENDING = 64, HIGH_SPEED = 3 };

typedef struct header {
    uint32_t command, seqnum, devid, direction, ep;
    uint32_t a, b, c, d,
        e; // submit: flags, length, start, packets, interval; its answer: status, length, ...
    uint8_t setup[8];
} header;

static struct {
    header requests[MAX_PENDING];
    int n;
} pending; // bulk requests that wait for data, in their order

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void give_up(const char *what)
{
    perror(what);
    exit(1);
}

static void get(int fd, void *data, size_t size)
{
    for (size_t n = 0; n < size;) {
        const ssize_t k = read(fd, (uint8_t *)data + n, size - n);
        if (k <= 0)
            give_up("usbip camera: the host is gone");
        n += (size_t)k;
    }
}

static void put(int fd, const void *data, size_t size)
{
    for (size_t n = 0; n < size;) {
        const ssize_t k = write(fd, (const uint8_t *)data + n, size - n);
        if (k <= 0)
            give_up("usbip camera: the host is gone");
        n += (size_t)k;
    }
}

static void answer(int fd, const header *request, int32_t status, const void *data, size_t size,
                   uint32_t length)
{
    header h = {.command = htonl(request->command == CMD_SUBMIT ? RET_SUBMIT : RET_UNLINK),
                .seqnum = htonl(request->seqnum),
                .a = htonl((uint32_t)status),
                .b = htonl(length)};
    put(fd, &h, sizeof h);
    put(fd, data, size);
}

static void serve_control(int fd, uvc_camera *c, const header *h)
{
    uint8_t data[4096] = {0};
    const bool in = h->setup[0] & 0x80;
    if (h->b > sizeof data)
        give_up("usbip camera: a request too long");
    if (!in)
        get(fd, data, h->b);
    const int n = uvc_camera_setup(c, h->setup, data, now_ns());
    answer(fd, h, n < 0 ? -EPIPE : 0, data, in && n > 0 ? (size_t)n : 0, n < 0 ? 0 : in ? (uint32_t)n : h->b);
}

static void serve_unlink(int fd, const header *h)
{
    int32_t status = 0;
    for (int i = 0; i < pending.n; i++)
        if (pending.requests[i].seqnum == h->a) {
            status = -ECONNRESET;
            memmove(&pending.requests[i], &pending.requests[i + 1],
                    (size_t)(--pending.n - i) * sizeof(header));
        }
    answer(fd, h, status, NULL, 0, 0);
}

static void serve(int fd, uvc_camera *c)
{
    header h;
    get(fd, &h, sizeof h);
    uint32_t *words = &h.command;
    for (int i = 0; i < 10; i++)
        words[i] = ntohl(words[i]);
    if (h.command == CMD_UNLINK)
        serve_unlink(fd, &h);
    else if (h.ep == 0)
        serve_control(fd, c, &h);
    else if (pending.n < MAX_PENDING)
        pending.requests[pending.n++] = h;
    else
        give_up("usbip camera: too many requests");
}

static void send_due(int fd, uvc_camera *c)
{
    static uint8_t data[UVC_TRANSFER_BYTES];
    while (pending.n) {
        const header h = pending.requests[0];
        const size_t room = h.b < sizeof data ? h.b : sizeof data;
        const size_t n = uvc_camera_transfer(c, data, room, now_ns());
        if (!n)
            return;
        memmove(pending.requests, pending.requests + 1, (size_t)--pending.n * sizeof h);
        answer(fd, &h, 0, data, n, (uint32_t)n);
    }
}

static int attach(const char *port)
{
    int ends[2];
    FILE *f = fopen("/sys/devices/platform/vhci_hcd.0/attach", "w");
    if (!f || socketpair(AF_UNIX, SOCK_STREAM, 0, ends))
        give_up("usbip camera: no vhci_hcd");
    if (fprintf(f, "%s %d %d %d", port, ends[1], 1 << 16 | 2, HIGH_SPEED) < 0 || fclose(f))
        give_up("usbip camera: not attached");
    close(ends[1]); // the kernel has it
    return ends[0];
}

typedef struct table {
    fake_grbl board;
    const char *tty;
} table;

// Powers the board whenever its line is there.
static void *run_table(void *self)
{
    table *t = self;
    for (;;) {
        if (fake_grbl_start_at(&t->board, t->tty))
            pthread_join(t->board.thread, NULL);
        poll(NULL, 0, 200);
    }
    return NULL;
}

static size_t picture_of_table(void *self, size_t n)
{
    table *t = self;
    const double turns = fake_grbl_table_deg(&t->board, NULL) / 360;
    return (size_t)lround((turns - floor(turns)) * (double)n) % n;
}

int main(int argc, char **argv)
{
    uvc_camera c;
    if (argc < 3 || !uvc_camera_init(&c, argv[1]))
        return 2;
    c.deaf = argc > 3 && !strcmp(argv[3], "deaf");
    static table turning;
    if (argc > 3 && !strncmp(argv[3], "table=", 6)) {
        pthread_t thread;
        fake_grbl_init(&turning.board);
        turning.tty = argv[3] + 6;
        c.choose = picture_of_table;
        c.choose_self = &turning;
        if (pthread_create(&thread, NULL, run_table, &turning))
            give_up("usbip camera: no thread");
    }
    const int fd = attach(argv[2]);
    for (;;) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};
        const int64_t left_ns = c.next_ns - now_ns();
        const int timeout_ms = !pending.n || !c.streaming ? -1
                               : left_ns > 0              ? (int)(left_ns / 1000000) + 1
                                                          : 0;
        if (poll(&wait, 1, timeout_ms) < 0)
            give_up("usbip camera");
        if (wait.revents)
            serve(fd, &c);
        send_due(fd, &c);
    }
}
