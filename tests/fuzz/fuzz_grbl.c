// SPDX-License-Identifier: Apache-2.0
// fuzz_grbl.c - any bytes as a controller's line and as a turntable's file: what is read is in range and its text ends.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "capture/grbl_protocol.h"
#include "capture/turntable_config.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    sheen_grbl_line line;
    sheen_table_config c;
    sheen_grbl_line_parse(&line, (const char *)data, size_bytes);
    if (!memchr(line.text, 0, sizeof line.text) || line.number < 0 || !isfinite(line.value))
        abort();
    if (line.n_machine > SHEEN_GRBL_MAX_AXES || line.n_work > SHEEN_GRBL_MAX_AXES ||
        line.n_offset > SHEEN_GRBL_MAX_AXES)
        abort();
    for (int i = 0; i < line.n_machine; i++)
        if (!isfinite(line.machine[i]))
            abort();
    if (!*sheen_grbl_state_name(line.state))
        abort();
    if (!sheen_table_config_parse(&c, data, size_bytes, NULL) &&
        (!(c.degrees_per_unit > 0) || abs(c.direction) != 1 || sheen_grbl_axis_index(c.axis) < 0))
        abort();
    return 0;
}
