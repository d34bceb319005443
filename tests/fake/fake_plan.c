// SPDX-License-Identifier: Apache-2.0
// fake_plan.c - reads a plan: what goes wrong with the fake camera and when, and what kind of camera it is.
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fake/fake_parts.h"

typedef enum kind { INT, UINT32, INT64, MASK, REAL, BOOL, ERRNO, REQUEST, RATE, MS } kind;

typedef struct entry {
    const char *key;
    kind kind;
    size_t at;
} entry;

#define FAULT(name, kind)                                                                                    \
    {                                                                                                        \
#name, kind, offsetof(fake_v4l2, faults.name)                                                        \
    }

static const entry entries[] = {
    {"node", INT, offsetof(fake_v4l2, node)},
    {"rate", RATE, offsetof(fake_v4l2, interval_ns)},
    {"width", INT, offsetof(fake_v4l2, width_px)},
    {"height", INT, offsetof(fake_v4l2, height_px)},
    FAULT(fail_call, INT),
    FAULT(fail_errno, ERRNO),
    FAULT(fail_request, REQUEST),
    FAULT(fail_request_errno, ERRNO),
    FAULT(dropped, MASK),
    FAULT(flagged, MASK),
    FAULT(cut, MASK),
    FAULT(corrupt, MASK),
    FAULT(swapped, MASK),
    FAULT(stall_at, INT64),
    FAULT(unplug_at, INT64),
    {"return_after_ms", MS, offsetof(fake_v4l2, faults.return_after_ns)},
    FAULT(return_node, INT),
    FAULT(first_sequence, UINT32),
    FAULT(sequence_stands, BOOL),
    FAULT(lag_frames, INT),
    FAULT(forgetful, UINT32),
    FAULT(deaf, BOOL),
    FAULT(auto_white_at, INT64),
    FAULT(flicker, REAL),
    FAULT(light_off_at, INT64),
    FAULT(stamps_end, BOOL),
    FAULT(stamps_none, BOOL),
    FAULT(ramp, BOOL),
    FAULT(covered, BOOL),
    FAULT(gamma, REAL),
    FAULT(vignette, REAL),
    FAULT(black, INT),
    FAULT(no_exposure, BOOL),
    FAULT(no_capture, BOOL),
};

static const struct {
    const char *name;
    unsigned long value;
} words[] = {
    {"EIO", EIO},
    {"ENODEV", ENODEV},
    {"EINTR", EINTR},
    {"EAGAIN", EAGAIN},
    {"ENOSPC", ENOSPC},
    {"EBUSY", EBUSY},
    {"EINVAL", EINVAL},
    {"EACCES", EACCES},
    {"OPEN", 0},
    {"S_FMT", VIDIOC_S_FMT},
    {"REQBUFS", VIDIOC_REQBUFS},
    {"QBUF", VIDIOC_QBUF},
    {"DQBUF", VIDIOC_DQBUF},
    {"STREAMON", VIDIOC_STREAMON},
    {"S_CTRL", VIDIOC_S_CTRL},
    {"G_CTRL", VIDIOC_G_CTRL},
};

static bool parse_word(unsigned long *out, const char *text)
{
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcmp(words[i].name, text)) {
            *out = words[i].value;
            return true;
        }
    return false;
}

// Frames by their numbers, "3,7,8".
static bool parse_mask(uint64_t *mask, const char *text)
{
    char *end;
    for (*mask = 0;; text = end + 1) {
        const unsigned long i = strtoul(text, &end, 10);
        if (end == text || i > 63)
            return false;
        *mask |= (uint64_t)1 << i;
        if (*end != ',')
            return !*end;
    }
}

static bool set(fake_v4l2 *f, const entry *e, const char *text)
{
    void *at = (char *)f + e->at;
    char *end;
    const double x = strtod(text, &end);
    const bool number = end != text && !*end;
    unsigned long word = 0;
    switch (e->kind) {
    case INT:
        *(int *)at = (int)x;
        return number;
    case UINT32:
        *(uint32_t *)at = (uint32_t)x;
        return number && x >= 0;
    case INT64:
        *(int64_t *)at = (int64_t)x;
        return number;
    case REAL:
        *(double *)at = x;
        return number;
    case BOOL:
        *(bool *)at = x != 0;
        return number;
    case MS:
        *(int64_t *)at = (int64_t)(1e6 * x);
        return number;
    case RATE:
        *(int64_t *)at = (int64_t)(1e6 / x) * 1000; // as V4L2 states it: in microseconds
        return number && x > 0.01 && x <= 1000;
    case MASK:
        return parse_mask(at, text);
    case ERRNO:
        *(int *)at = parse_word(&word, text) ? (int)word : 0;
        return word != 0;
    case REQUEST:
        return parse_word(at, text);
    }
    return false;
}

const char *fake_v4l2_plan(fake_v4l2 *f, const char *text)
{
    while (*text) {
        char key[256];
        const size_t n = strcspn(text, ";");
        if (n >= sizeof key)
            return "one of its entries is too long";
        memcpy(key, text, n);
        key[n] = 0;
        text += n + (text[n] == ';');
        char *value = strchr(key, '=');
        bool known = false;
        if (!value)
            return "an entry has no '='";
        *value++ = 0;
        for (size_t i = 0; i < sizeof entries / sizeof *entries && !known; i++)
            if (!strcmp(entries[i].key, key)) {
                known = true;
                if (!set(f, &entries[i], value))
                    return "a value is not understood";
            }
        if (!known)
            return "a key is not known";
    }
    if (!f->n_payloads)
        f->stride_bytes = 3 * f->width_px;
    return NULL;
}
