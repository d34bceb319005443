// SPDX-License-Identifier: Apache-2.0
// serial_port.h - a serial line to a machine that must not notice that somebody opened it: lines in, bytes out.
#ifndef SHEEN_CAPTURE_SERIAL_PORT_H
#define SHEEN_CAPTURE_SERIAL_PORT_H

#include <stddef.h>

#include "base/status.h"

enum { SHEEN_SERIAL_MAX_LINE = 256 };

typedef struct sheen_serial {
    int fd; // -1: closed
    char path[128];
    char waiting[1024]; // read, not yet given out
    size_t n_waiting;
    char line[SHEEN_SERIAL_MAX_LINE]; // the line being put together
    size_t n_line;
    int too_long; // its rest is thrown away
} sheen_serial;

// 8 data bits, no parity, one stop bit, no flow control, raw; alone (TIOCEXCL and a lock), and with HUPCL cleared, so that
// closing does not drop DTR and reset the board at the next opening. EARG (a rate that the port does not know), ENODEV,
// EACCESS (no permission, or another program has it), EIO.
sheen_status sheen_serial_open(sheen_serial *port, const char *path, int baud, sheen_err *err);
void sheen_serial_close(sheen_serial *port);

// ENODEV: unplugged. ETIMEOUT: nothing was taken for a second.
sheen_status sheen_serial_write(sheen_serial *port, const void *bytes, size_t n, sheen_err *err);
// The next line without its end, lent until the next call. Lines that are too long and bytes outside ASCII are dropped.
// ETIMEOUT, ENODEV.
sheen_status sheen_serial_read_line(sheen_serial *port, const char **line, size_t *length, int timeout_ms,
                                    sheen_err *err);

#endif
