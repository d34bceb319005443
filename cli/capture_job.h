// SPDX-License-Identifier: Apache-2.0
// capture_job.h - one capture: what the person asked for, and the parts that carry it out.
//
//     cmd_capture.c     reads the command line
//     capture_job.c     one session, from any source
//     capture_turns.c   its frames by a turntable
//     capture_batch.c   one session after the other, an object each
#ifndef SHEEN_CLI_CAPTURE_JOB_H
#define SHEEN_CLI_CAPTURE_JOB_H

#include "capture/record.h"
#include "cli/cli.h"
#include "cli/measure.h"

typedef struct sheen_cli_capture {
    const char *device, *hook, *turntable, *turntable_file;
    const char *batch; // file of the objects
    const char *like;  // session that a new one takes its camera, board and mesh from
    int n_steps, n_rounds;
    bool background; // --background: the first round begins with the empty table
    bool choose;     // --auto
    sheen_cli_measure measure;
    bool remember; // --remember
    bool then_run; // --then run
    double spread_deg, max_blur_px, max_motion_px;
    sheen_record_options o;
    sheen_moving moved;
    bool by_hand; // a camera without --count: a frame for each Enter or SIGUSR1
} sheen_cli_capture;

// Records into the session at `path`, makes it where there is none, and says the result. The camera and the turntable are
// opened for it and closed again.
sheen_status sheen_cli_capture_session(sheen_cli *cli, sheen_cli_capture *a, const char *path,
                                       sheen_err *err);

// The recording alone, with the policy in a->o where a->turntable is set, else with the one that the arguments ask for.
sheen_status sheen_cli_capture_record(sheen_cli *cli, sheen_cli_capture *a, sheen_session *s,
                                      sheen_source *src, sheen_record_report *r, sheen_err *err);
// Turns and records what is missing of the rounds.
sheen_status sheen_cli_capture_turns(sheen_cli *cli, sheen_cli_capture *a, sheen_session *s,
                                     sheen_source *src, sheen_record_report *r, sheen_err *err);
// How many frames of the rounds a session has not.
size_t sheen_cli_capture_missing(const sheen_cli_capture *a, const sheen_session *s);

// Every object of a->batch that is not complete, in sessions below `folder`. limit_missed is set where some are to be
// done again.
sheen_status sheen_cli_capture_batch(sheen_cli *cli, sheen_cli_capture *a, const char *folder,
                                     sheen_err *err);

#endif
