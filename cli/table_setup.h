// SPDX-License-Identifier: Apache-2.0
// table_setup.h - what a turntable really does, measured from the tags: degrees a unit, direction, play, axis.
#ifndef SHEEN_CLI_TABLE_SETUP_H
#define SHEEN_CLI_TABLE_SETUP_H

#include "capture/turntable.h"
#include "pose/turntable_axis.h"

typedef struct sheen_cli_setup {
    // The board's pose now that the table stands.
    sheen_status (*observe)(void *self, sheen_turntable_pose *pose, sheen_err *err);
    void *self;
} sheen_cli_setup;

typedef struct sheen_cli_setup_result {
    sheen_table_config config; // as it was, with what was measured
    double sigma_share;        // one standard deviation of degrees a unit, in parts of it
    double rms_deg, worst_deg; // of the steps beside the line
    double sigma_axis_deg;
} sheen_cli_setup_result;

// Turns the table, which was opened with `config` whose backlash_deg is 0 and direction 1: a few degrees, then a turn in
// twelve steps, then back and forth. EDATA: it does not turn, or not about one axis; and what table and observe report.
sheen_status sheen_cli_table_setup(sheen_cli_setup_result *out, sheen_table *table,
                                   const sheen_table_config *config, const sheen_cli_setup *setup,
                                   sheen_err *err);

#endif
