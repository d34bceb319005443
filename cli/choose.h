// SPDX-License-Identifier: Apache-2.0
// choose.h - --auto: a frame is taken when the board is in view, the picture sharp and still, and the viewpoint new.
#ifndef SHEEN_CLI_CHOOSE_H
#define SHEEN_CLI_CHOOSE_H

#include "base/board.h"
#include "base/session.h"
#include "calib/detect.h"
#include "calib/view_sphere.h"
#include "capture/record.h"

typedef struct sheen_cli_choose {
    // Set by the caller.
    double spread_rad;    // a view is new this far from all others
    double max_motion_px; // of the tags, within a thirtieth of a second
    double max_blur_px;   // of the tags' edges, 10 % to 90 %
    // Told what is missing, at most once a second and only what is new. NULL: nobody is.
    void (*hint)(void *self, const char *text);
    void *hint_self;
    // State; zero to begin with.
    sheen_board_set boards;
    sheen_tag_detector *detector;
    sheen_camera *camera; // NULL: not calibrated yet
    sheen_view_sphere sphere;
    sheen_tag_seen *before; // in the frame before
    size_t n_before;
    int64_t before_ns, hinted_ns;
    int last_hint;
    bool by_hand;      // Enter or SIGUSR1 wants the next one, whatever it shows
    bool has_view;     // of the frame that is being taken
    double v_board[3]; // its view
} sheen_cli_choose;

// Reads the session's board (which it must have: EARG) and camera, and where its input frames were taken from, so that
// an interrupted capture goes on with what is missing.
sheen_status sheen_cli_choose_init(sheen_cli_choose *c, const sheen_session *s, sheen_err *err);
void sheen_cli_choose_release(sheen_cli_choose *c);

// For sheen_record_policy; self is the sheen_cli_choose. The ring covered ends the recording (EEND).
sheen_status sheen_cli_choose_ask(void *self, int64_t *since_ns, sheen_err *err);
sheen_status sheen_cli_choose_look(void *self, sheen_frame *frame, sheen_verdict *verdict, sheen_err *err);
// What is still missing, for a person: "7 views, nothing from behind yet". True: nothing is.
bool sheen_cli_choose_missing(char text[120], const sheen_cli_choose *c);

#endif
