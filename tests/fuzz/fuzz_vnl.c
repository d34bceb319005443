// SPDX-License-Identifier: Apache-2.0
// fuzz_vnl.c - any bytes as a table of corners, for a grid of 3 x 2.
#include <math.h>
#include <stdlib.h>

#include "calib/vnl.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_err err;
    sheen_vnl vnl;
    if (sheen_vnl_parse(&vnl, data, size_bytes, 3, 2, &err))
        return 0;
    for (size_t i = 0; i < vnl.n_frames; i++) {
        const sheen_vnl_frame *frame = &vnl.frames[i];
        size_t n_found = 0;
        for (int k = 0; frame->corners && k < 6; k++) {
            const double *c = frame->corners + 3 * k;
            if (!isfinite(c[0]) || !isfinite(c[1]) || !(c[2] >= 0 && c[2] <= 1))
                abort();
            n_found += c[2] > 0;
        }
        if (n_found != frame->n_found || !frame->file[0])
            abort();
    }
    sheen_vnl_release(&vnl);
    return 0;
}
