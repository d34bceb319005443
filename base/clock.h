// SPDX-License-Identifier: Apache-2.0
// clock.h - CLOCK_MONOTONIC, the clock of frames' timestamps, as a number.
#ifndef SHEEN_BASE_CLOCK_H
#define SHEEN_BASE_CLOCK_H

#include <stdint.h>
#include <time.h>

static inline int64_t sheen_clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static inline int64_t sheen_clock_ms(void)
{
    return sheen_clock_ns() / 1000000;
}

#endif
