// SPDX-License-Identifier: Apache-2.0
// white.h - watches the light of a capture by the white of the board.
#ifndef SHEEN_CLI_WHITE_H
#define SHEEN_CLI_WHITE_H

#include "base/board.h"
#include "base/session.h"
#include "calib/detect.h"
#include "capture/drift.h"
#include "capture/source.h"

typedef struct sheen_cli_white {
    sheen_board_set boards;
    sheen_tag_detector *detector;
    sheen_drift drift;
    size_t n_seen, n_unseen; // frames that showed the board, and that did not
} sheen_cli_white;

// Reads the session's board. Where it has none, nothing is watched (detector NULL), which is success.
sheen_status sheen_cli_white_init(sheen_cli_white *w, const sheen_session *s, sheen_err *err);
void sheen_cli_white_release(sheen_cli_white *w);
// For sheen_record_options.check; check_self is the sheen_cli_white. EDATA where the light has changed.
sheen_status sheen_cli_white_check(void *self, const sheen_frame *frame, sheen_err *err);

// The median light of the white about the tags, in linear RGB. False where no tag was seen.
bool sheen_cli_white_measure(float rgb[3], const sheen_raster *r, sheen_transfer transfer,
                             const sheen_tag_seen *tags, size_t n_tags);

#endif
