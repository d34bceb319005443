// SPDX-License-Identifier: Apache-2.0
// serial_port.c - opens a tty through termios, gathers its bytes into lines.
#define _DEFAULT_SOURCE // cfmakeraw, flock
#include "capture/serial_port.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "base/clock.h"

static speed_t speed_of(int baud)
{
    static const struct {
        int baud;
        speed_t speed;
    } known[] = {{9600, B9600},     {19200, B19200},   {38400, B38400},   {57600, B57600},
                 {115200, B115200}, {230400, B230400}, {460800, B460800}, {921600, B921600}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (known[i].baud == baud)
            return known[i].speed;
    return B0;
}

static sheen_status gone(const sheen_serial *port, sheen_err *err)
{
    return sheen_fail(err, SHEEN_ENODEV, "the turntable at '%s' is gone: look at its cable and its power",
                      port->path);
}

static sheen_status open_failed(const char *path, int number, sheen_err *err)
{
    if (number == EACCES || number == EPERM)
        return sheen_fail(
            err, SHEEN_EACCESS,
            "no permission for the turntable '%s': 'usermod -aG dialout NAME', then log in again", path);
    if (number == EBUSY || number == EWOULDBLOCK)
        return sheen_fail(err, SHEEN_EACCESS, "another program uses the turntable '%s': close it", path);
    if (number == ENOENT || number == ENODEV || number == ENXIO || number == EIO)
        return sheen_fail(err, SHEEN_ENODEV,
                          "there is no turntable at '%s': 'sheen devices' lists what is plugged in", path);
    return sheen_fail(err, SHEEN_EIO, "cannot open the turntable '%s': %s", path, strerror(number));
}

static int configure(int fd, speed_t speed)
{
    struct termios t;
    if (flock(fd, LOCK_EX | LOCK_NB) || ioctl(fd, TIOCEXCL) || tcgetattr(fd, &t))
        return -1;
    cfmakeraw(&t);
    t.c_cflag &= (tcflag_t) ~(HUPCL | CSTOPB | CRTSCTS);
    t.c_cflag |= CLOCAL | CREAD;
    t.c_cc[VMIN] = 1;
    t.c_cc[VTIME] = 0;
    if (cfsetispeed(&t, speed) || cfsetospeed(&t, speed))
        return -1;
    return tcsetattr(fd, TCSANOW, &t);
}

sheen_status sheen_serial_open(sheen_serial *port, const char *path, int baud, sheen_err *err)
{
    const speed_t speed = speed_of(baud);
    *port = (sheen_serial){.fd = -1};
    if (speed == B0)
        return sheen_fail(err, SHEEN_EARG, "a serial line has no rate of %d baud: Grbl's is 115200", baud);
    if (snprintf(port->path, sizeof port->path, "%s", path) >= (int)sizeof port->path)
        return sheen_fail(err, SHEEN_EARG, "the turntable's path is too long: '%.60s...'", path);
    const int fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0)
        return open_failed(path, errno, err);
    if (configure(fd, speed)) {
        const int number = errno;
        close(fd);
        if (number == ENOTTY)
            return sheen_fail(err, SHEEN_EARG, "'%s' is not a serial line", path);
        return open_failed(path, number, err);
    }
    port->fd = fd;
    return SHEEN_OK;
}

void sheen_serial_close(sheen_serial *port)
{
    if (port->fd >= 0)
        close(port->fd);
    port->fd = -1;
}

sheen_status sheen_serial_write(sheen_serial *port, const void *bytes, size_t n, sheen_err *err)
{
    const char *next = bytes;
    while (n) {
        const ssize_t k = write(port->fd, next, n);
        if (k > 0) {
            next += k;
            n -= (size_t)k;
            continue;
        }
        struct pollfd p = {.fd = port->fd, .events = POLLOUT};
        if (k < 0 && errno != EAGAIN && errno != EINTR)
            return gone(port, err);
        if (poll(&p, 1, 1000) == 0)
            return sheen_fail(err, SHEEN_ETIMEOUT,
                              "the turntable at '%s' takes no commands: switch it off and on", port->path);
        if (p.revents & (POLLHUP | POLLERR | POLLNVAL))
            return gone(port, err);
    }
    return SHEEN_OK;
}

// True when `waiting` ended a line, which then stands in port->line.
static int gather(sheen_serial *port)
{
    size_t used = 0;
    int whole = 0;
    while (used < port->n_waiting && !whole) {
        const char c = port->waiting[used++];
        if (c == '\n' || c == '\r') {
            whole = port->n_line > 0 && !port->too_long;
            if (!whole)
                port->n_line = 0;
            port->too_long = 0;
        } else if (port->n_line + 1 >= sizeof port->line)
            port->too_long = 1;
        else if (c >= ' ' && c < 0x7f)
            port->line[port->n_line++] = c;
    }
    port->n_waiting -= used;
    memmove(port->waiting, port->waiting + used, port->n_waiting);
    return whole;
}

sheen_status sheen_serial_read_line(sheen_serial *port, const char **line, size_t *length, int timeout_ms,
                                    sheen_err *err)
{
    const int64_t end_ms = sheen_clock_ms() + timeout_ms;
    while (!gather(port)) {
        struct pollfd p = {.fd = port->fd, .events = POLLIN};
        const int64_t left_ms = end_ms - sheen_clock_ms();
        const int ready = poll(&p, 1, left_ms > 0 ? (int)left_ms : 0);
        if (ready < 0 && errno == EINTR)
            return sheen_fail(err, SHEEN_ETIMEOUT, "interrupted");
        if (ready == 0)
            return sheen_fail(err, SHEEN_ETIMEOUT, "the turntable at '%s' says nothing", port->path);
        const ssize_t n = read(port->fd, port->waiting + port->n_waiting,
                               sizeof port->waiting - port->n_waiting);
        if (n > 0)
            port->n_waiting += (size_t)n;
        else if (n == 0 || (errno != EAGAIN && errno != EINTR))
            return gone(port, err);
    }
    port->line[port->n_line] = '\0';
    *line = port->line;
    *length = port->n_line;
    port->n_line = 0;
    return SHEEN_OK;
}
