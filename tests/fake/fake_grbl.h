// SPDX-License-Identifier: Apache-2.0
// fake_grbl.h - a Grbl 1.1 controller with a turntable on its X axis, at the other end of a pseudo-terminal.
//
// A thread of its own plays the board: it parses as Grbl does (doc/markdown and doc/csv of gnea/grbl; test_turntable.c
// holds the list of what was compared), moves in real time, and fails as it was told to. The table behind it has its own
// true gear ratio, direction and play, which nobody tells the program.
#ifndef SHEEN_TESTS_FAKE_FAKE_GRBL_H
#define SHEEN_TESTS_FAKE_FAKE_GRBL_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

// What goes wrong, once; all zero: nothing. Moves are counted from 1 over the life of the board.
typedef struct fake_grbl_faults {
    int cut_at_line;     // the cable is pulled as the n-th line arrives (from 1, since the last plugging in)
    int cut_at_move;     // ... half-way through the n-th move
    int alarm_at_move;   // a limit switch closes half-way
    int reset_at_move;   // the board loses power for a moment half-way
    int block_at_move;   // the move never ends
    int slip_at_move;    // the motor loses steps: the table stays where it is, the controller counts on
    int stop_at_move;    // somebody presses the stop button: the move ends half-way
    bool deaf;           // says nothing at all
    bool swallows_ok;    // the next ok is never sent
    bool noise;          // garbage before each answer
    bool ignores_cancel; // goes on in spite of a jog cancel
    bool door;           // the safety door is open
} fake_grbl_faults;

typedef struct fake_grbl {
    fake_grbl_faults faults; // may be changed between commands
    // The board. Set before fake_grbl_start; power_up sets what a power-up does.
    double settings[140];
    int n_axes;
    bool reports_work, homing_lock, resets_on_open, other_firmware;
    double work_offset;
    double speed_factor; // moves take so many times less time
    // The table.
    double true_deg_per_unit, play_deg;
    // State.
    int state, n_lines, n_moves;
    double units, target, feed_units_min, start;
    double gear_deg, table_deg;
    int n_reports;
    bool dwelling, opened, failed_half_way;
    int64_t dwell_end_ns, last_ns;
    char line[96];
    int n_line;
    bool overflow;
    int comment;
    int master;
    char path[64];
    bool quit, pulled, is_port;
    pthread_t thread;
    pthread_mutex_t lock;
} fake_grbl;

enum { FAKE_IDLE, FAKE_JOG, FAKE_RUN, FAKE_HOLD, FAKE_ALARM, FAKE_DOOR, FAKE_CHECK, FAKE_SLEEP };

// Three axes, 1 degree a unit, 1200 units a second, Grbl's defaults.
void fake_grbl_init(fake_grbl *f);
// Plugs it in: f->path is there, and the thread runs.
void fake_grbl_start(fake_grbl *f);
// The same at a serial line that is there, as a USB gadget's (/dev/ttyGS0). It ends by itself when the line hangs up: the
// board is without power then, and fake_grbl_stop tidies up. False: it cannot be opened (yet).
bool fake_grbl_start_at(fake_grbl *f, const char *path);
// Pulls the cable (where no fault did already) and ends the thread; the table stays where it is. Then it may be started
// again, powered up anew.
void fake_grbl_stop(fake_grbl *f);
// Where the table really stands, degrees; and whether it moves.
double fake_grbl_table_deg(fake_grbl *f, bool *moving);
// Turns the table from outside, by hand.
void fake_grbl_push(fake_grbl *f, double delta_deg);

#endif
