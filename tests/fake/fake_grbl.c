// SPDX-License-Identifier: Apache-2.0
// fake_grbl.c - the board's main loop, its parser, its motion.
#define _GNU_SOURCE // ptsname_r, cfmakeraw
#include "tests/fake/fake_grbl.h"

#include <assert.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/status.h"

void fake_grbl_init(fake_grbl *f)
{
    *f = (fake_grbl){.n_axes = 3, .speed_factor = 1, .true_deg_per_unit = 1, .master = -1};
    f->settings[10] = 1;
    for (int i = 0; i < 3; i++) {
        f->settings[100 + i] = 250;
        f->settings[110 + i] = 72000;
        f->settings[120 + i] = 1000;
        f->settings[130 + i] = 200;
    }
    pthread_mutex_init(&f->lock, NULL);
}

static void say(fake_grbl *f, const char *fmt, ...) SHEEN_PRINTF(2, 3);

static void say(fake_grbl *f, const char *fmt, ...)
{
    char text[256];
    va_list args;
    if (f->faults.deaf || f->pulled)
        return;
    va_start(args, fmt);
    int n = vsnprintf(text, sizeof text - 2, fmt, args);
    va_end(args);
    memcpy(text + n, "\r\n", 2);
    n += 2;
    if (write(f->master, text, (size_t)n) != n)
        f->pulled = true;
}

static void answer(fake_grbl *f, int error)
{
    if (f->faults.noise)
        say(f, "\xc3\x28~garbage<|");
    if (!error && f->faults.swallows_ok) {
        f->faults.swallows_ok = false;
        return;
    }
    if (error)
        say(f, "error:%d", error);
    else
        say(f, "ok");
}

static void greet(fake_grbl *f)
{
    f->dwelling = false;
    f->n_line = 0;
    f->n_reports = 0;
    say(f, "%s", "");
    say(f, "%s", f->other_firmware ? "GrblHAL 1.1f ['$' or '$HELP' for help]" : "Grbl 1.1h ['$' for help]");
    if (f->state == FAKE_ALARM)
        say(f, "[MSG:'$H'|'$X' to unlock]");
}

static void power_up(fake_grbl *f)
{
    f->state = f->homing_lock ? FAKE_ALARM : FAKE_IDLE;
    f->units = f->target = 0;
    greet(f);
}

// The table follows its gear, less the play.
static void move_gear(fake_grbl *f, double delta_units)
{
    f->units += delta_units;
    if (f->faults.slip_at_move == f->n_moves && f->n_moves)
        return;
    f->gear_deg += delta_units * f->true_deg_per_unit;
    f->table_deg = fmax(f->gear_deg - f->play_deg / 2, fmin(f->gear_deg + f->play_deg / 2, f->table_deg));
}

static void pull(fake_grbl *f)
{
    f->pulled = true;
}

static void alarm_now(fake_grbl *f, int number)
{
    f->target = f->units;
    f->state = FAKE_ALARM;
    say(f, "ALARM:%d", number);
    if (number == 1)
        say(f, "[MSG:Reset to continue]");
}

static void half_way(fake_grbl *f)
{
    const fake_grbl_faults *w = &f->faults;
    const int n = f->n_moves;
    f->failed_half_way = true;
    if (n == w->cut_at_move)
        pull(f);
    else if (n == w->alarm_at_move)
        alarm_now(f, 1);
    else if (n == w->reset_at_move)
        power_up(f);
    else if (n == w->stop_at_move)
        f->target = f->units;
}

static void advance(fake_grbl *f)
{
    const int64_t now = sheen_clock_ns();
    const double dt_s = (double)(now - f->last_ns) * 1e-9;
    f->last_ns = now;
    if (f->dwelling && now >= f->dwell_end_ns) {
        f->dwelling = false;
        answer(f, 0);
    }
    if (f->state != FAKE_JOG && f->state != FAKE_RUN)
        return;
    // To the half-way point first: what happens there is not to be passed over in one stride of a busy machine.
    const double middle = (f->start + f->target) / 2;
    const double goal = f->failed_half_way ? f->target : middle, left = goal - f->units;
    if (f->faults.block_at_move == f->n_moves && f->failed_half_way)
        return;
    const double speed = fmin(f->feed_units_min, f->settings[110]) / 60 * f->speed_factor;
    const double step = fmin(fabs(left), speed * dt_s);
    move_gear(f, left > 0 ? step : -step);
    if (step == fabs(left))
        f->units = goal; // but for rounding it was
    if (!f->failed_half_way && f->units == middle)
        half_way(f);
    else if (f->state != FAKE_ALARM && f->units == f->target)
        f->state = FAKE_IDLE;
}

static void report(fake_grbl *f)
{
    static const char *const names[] = {"Idle", "Jog", "Run", "Hold:0", "Alarm", "Door:1", "Check", "Sleep"};
    char axes[128] = "", offset[64] = "";
    const double unit = f->settings[13] > 0 ? 1 / 25.4 : 1;
    const double x = (f->units - (f->reports_work ? f->work_offset : 0)) * unit;
    for (int i = 0; i < f->n_axes; i++)
        snprintf(axes + strlen(axes), sizeof axes - strlen(axes), "%s%.3f", i ? "," : "", i ? 0.0 : x);
    if (f->n_reports++ % (f->state == FAKE_IDLE ? 10 : 30) == 0)
        snprintf(offset, sizeof offset, "|WCO:%.3f,0.000,0.000", f->work_offset * unit);
    say(f, "<%s|%s:%s|FS:%.0f,0%s>", names[f->state], f->reports_work ? "WPos" : "MPos", axes,
        f->state == FAKE_JOG ? f->feed_units_min : 0, offset);
}

static void start_move(fake_grbl *f, double target, double feed, int state)
{
    f->n_moves++;
    f->failed_half_way = false;
    f->start = f->units;
    f->target = round(target * f->settings[100]) / f->settings[100];
    f->feed_units_min = feed;
    if (f->target != f->units)
        f->state = state;
}

// Words of a block: their letters and numbers. 0 or Grbl's error.
static int read_words(const char *text, double value[26], int count[26], bool modes[100])
{
    while (*text) {
        char *end;
        const int letter = *text - 'A';
        if (letter < 0 || letter >= 26)
            return 1;
        const double x = strtod(text + 1, &end);
        if (end == text + 1)
            return 2;
        text = end;
        if (letter == 'G' - 'A') {
            if (x < 0 || x >= 100 || x != floor(x))
                return 20;
            modes[(int)x] = true;
        } else
            count[letter]++;
        value[letter] = x;
    }
    return 0;
}

static int jog(fake_grbl *f, const char *text)
{
    double value[26] = {0};
    int count[26] = {0};
    bool modes[100] = {false};
    if (f->state != FAKE_IDLE && f->state != FAKE_JOG)
        return 8;
    if (text[0] != '=')
        return 3;
    const int error = read_words(text + 1, value, count, modes);
    if (error)
        return error;
    for (int i = 0; i < 100; i++)
        if (modes[i] && i != 20 && i != 21 && i != 53 && i != 90 && i != 91)
            return 16;
    for (int i = 0; i < 26; i++)
        if (count[i] && !strchr("XYZFN", 'A' + i))
            return i < 3 ? 20 : 16; // A, B, C: axes that it has not
    if (!count['X' - 'A'] && !count['Y' - 'A'] && !count['Z' - 'A'])
        return 26;
    if (!count['F' - 'A'])
        return 22;
    const double unit = modes[20] ? 25.4 : 1;
    const double from = f->state == FAKE_JOG ? f->target : f->units;
    double target = value['X' - 'A'] * unit;
    if (modes[91])
        target += from;
    else if (!modes[53])
        target += f->work_offset;
    if (f->settings[20] > 0 && (target > 0 || target < -f->settings[130]))
        return 15;
    if (count['X' - 'A'])
        start_move(f, target, value['F' - 'A'] * unit, FAKE_JOG);
    return 0;
}

static int store(fake_grbl *f, const char *text)
{
    char *end;
    if (f->state != FAKE_IDLE && f->state != FAKE_ALARM)
        return 8;
    const double number = strtod(text, &end);
    if (end == text)
        return 2;
    if (*end != '=')
        return 3;
    const char *value_text = end + 1;
    const double value = strtod(value_text, &end);
    if (end == value_text || *end)
        return 2;
    if (value < 0)
        return 4;
    if (number < 0 || number >= 140 || number != floor(number))
        return 3;
    if (number == 20 && value > 0 && !(f->settings[22] > 0))
        return 10;
    f->settings[(int)number] = value;
    return 0;
}

static int system_command(fake_grbl *f, const char *text)
{
    if (text[0] == 'J')
        return jog(f, text + 1);
    if (!strcmp(text, "$")) {
        if (f->state == FAKE_RUN || f->state == FAKE_HOLD)
            return 8;
        static const int listed[] = {0,   1,   10,  13,  20,  21,  22,  100, 101, 102,
                                     110, 111, 112, 120, 121, 122, 130, 131, 132};
        for (size_t i = 0; i < sizeof listed / sizeof *listed; i++)
            say(f, "$%d=%.3f", listed[i], f->settings[listed[i]]);
        return 0;
    }
    if (!strcmp(text, "X")) {
        if (f->faults.door)
            return 13;
        if (f->state == FAKE_ALARM) {
            say(f, "[MSG:Caution: Unlocked]");
            f->state = FAKE_IDLE;
        }
        return 0;
    }
    if (f->state != FAKE_IDLE && f->state != FAKE_ALARM)
        return 8;
    if (!strcmp(text, "H")) {
        if (!(f->settings[22] > 0))
            return 5;
        move_gear(f, -f->units);
        f->units = f->target = 0;
        f->state = FAKE_IDLE;
        return 0;
    }
    if (!strcmp(text, "SLP")) {
        say(f, "[MSG:Sleeping]");
        f->state = FAKE_SLEEP;
        return 0;
    }
    if (!strcmp(text, "I")) {
        say(f, "[VER:1.1h.20190830:]");
        say(f, "[OPT:V,15,128]");
        return 0;
    }
    return store(f, text);
}

// True: answered later.
static bool gcode(fake_grbl *f, const char *text, int *error)
{
    double value[26] = {0};
    int count[26] = {0};
    bool modes[100] = {false};
    if ((*error = read_words(text, value, count, modes)))
        return false;
    if (modes[4]) {
        if (!count['P' - 'A'])
            *error = 28;
        else {
            f->dwelling = true;
            f->dwell_end_ns = sheen_clock_ns() + (int64_t)(value['P' - 'A'] * 1e9);
            return true;
        }
        return false;
    }
    for (int i = 0; i < 100; i++)
        if (modes[i] && i > 1 && (i < 17 || i > 21) && (i < 53 || i > 59) && i != 90 && i != 91 && i != 94)
            *error = 20;
    if (!*error && count['X' - 'A'])
        start_move(f, value['X' - 'A'] + f->work_offset, modes[1] ? value['F' - 'A'] : f->settings[110],
                   FAKE_RUN);
    return false;
}

static void execute(fake_grbl *f)
{
    int error = 0;
    f->line[f->n_line] = '\0';
    f->n_lines++;
    if (f->n_lines == f->faults.cut_at_line) {
        pull(f);
        return;
    }
    if (f->overflow)
        error = 11;
    else if (f->line[0] == '$')
        error = f->line[1]
                    ? system_command(f, f->line + 1)
                    : (say(f, "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]"), 0);
    else if (f->line[0] && (f->state == FAKE_ALARM || f->state == FAKE_JOG))
        error = 9;
    else if (f->line[0] && gcode(f, f->line, &error))
        return;
    answer(f, error);
}

static void cancel_motion(fake_grbl *f)
{
    if (f->faults.ignores_cancel)
        return;
    f->target = f->units;
    f->state = FAKE_IDLE;
}

static void reset(fake_grbl *f)
{
    const bool moved = f->state == FAKE_JOG || f->state == FAKE_RUN;
    f->target = f->units;
    if (moved) {
        f->state = FAKE_ALARM;
        say(f, "ALARM:3");
    } else if (f->state != FAKE_ALARM)
        f->state = FAKE_IDLE;
    greet(f);
}

static bool realtime(fake_grbl *f, unsigned char c)
{
    if (c == '?')
        report(f);
    else if (c == 0x18)
        reset(f);
    else if (c == 0x85) {
        if (f->state == FAKE_JOG)
            cancel_motion(f);
    } else if (c == '!') {
        if (f->state == FAKE_JOG)
            cancel_motion(f);
        else if (f->state == FAKE_IDLE || f->state == FAKE_RUN)
            f->state = FAKE_HOLD;
    } else if (c == '~') {
        if (f->state == FAKE_HOLD)
            f->state = f->target != f->units ? FAKE_RUN : FAKE_IDLE;
    } else if (c < 0x80)
        return false;
    return true;
}

static void receive(fake_grbl *f, unsigned char c)
{
    if (realtime(f, c))
        return;
    if (c == '\n' || c == '\r') {
        execute(f);
        f->n_line = f->comment = 0;
        f->overflow = false;
    } else if (f->comment) {
        if (f->comment == '(' && c == ')')
            f->comment = 0;
    } else if (c == '(' || c == ';')
        f->comment = c;
    else if (c <= ' ' || c == '/')
        return;
    else if (f->n_line >= 79)
        f->overflow = true;
    else
        f->line[f->n_line++] = (char)(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
}

// Somebody opened the port: boards with a bootloader start anew, unless the last one left DTR alone.
static void notice_opening(fake_grbl *f, bool is_open)
{
    struct termios t;
    if (is_open && !f->opened && f->resets_on_open)
        power_up(f);
    if (f->opened && !is_open && !tcgetattr(f->master, &t))
        f->resets_on_open = f->resets_on_open && (t.c_cflag & HUPCL);
    f->opened = is_open;
}

static void *play(void *self)
{
    fake_grbl *f = self;
    for (;;) {
        unsigned char bytes[64];
        ssize_t n = 0;
        struct pollfd p = {.fd = f->master, .events = POLLIN};
        poll(&p, 1, 1);
        pthread_mutex_lock(&f->lock);
        const bool over = f->quit || f->pulled;
        if (!over) {
            if (!f->is_port)
                notice_opening(f, !(p.revents & POLLHUP));
            if (p.revents & POLLIN && !f->dwelling)
                n = read(f->master, bytes, sizeof bytes);
            if (f->is_port && p.revents & (POLLHUP | POLLERR))
                pull(f);
            for (ssize_t i = 0; i < n && !f->pulled; i++)
                receive(f, bytes[i]);
            advance(f);
        } else {
            close(f->master);
            f->master = -1;
        }
        pthread_mutex_unlock(&f->lock);
        if (over)
            return NULL;
        if (p.revents & POLLHUP)
            poll(NULL, 0, 1);
    }
}

static void begin(fake_grbl *f)
{
    f->quit = f->pulled = f->opened = false;
    f->n_lines = 0;
    f->state = f->homing_lock ? FAKE_ALARM : FAKE_IDLE;
    f->units = f->target = 0;
    f->last_ns = sheen_clock_ns();
    if (pthread_create(&f->thread, NULL, play, f))
        abort();
}

bool fake_grbl_start_at(fake_grbl *f, const char *path)
{
    struct termios t;
    f->is_port = true;
    f->master = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (f->master < 0)
        return false;
    if (tcgetattr(f->master, &t)) {
        close(f->master);
        return false;
    }
    cfmakeraw(&t);
    t.c_cflag |= CLOCAL;
    tcsetattr(f->master, TCSANOW, &t);
    tcflush(f->master, TCIOFLUSH);
    begin(f);
    return true;
}

void fake_grbl_start(fake_grbl *f)
{
    f->master = posix_openpt(O_RDWR | O_NOCTTY);
    assert(f->master >= 0);
    if (grantpt(f->master) || unlockpt(f->master) || ptsname_r(f->master, f->path, sizeof f->path))
        abort();
    // Only once a slave was open does the master tell when it is closed.
    const int slave = open(f->path, O_RDWR | O_NOCTTY);
    struct termios t;
    if (slave < 0 || tcgetattr(slave, &t))
        abort();
    cfmakeraw(&t);
    t.c_cflag |= HUPCL;
    tcsetattr(slave, TCSANOW, &t);
    close(slave);
    begin(f);
}

void fake_grbl_stop(fake_grbl *f)
{
    pthread_mutex_lock(&f->lock);
    f->quit = true;
    pthread_mutex_unlock(&f->lock);
    pthread_join(f->thread, NULL);
}

double fake_grbl_table_deg(fake_grbl *f, bool *moving)
{
    pthread_mutex_lock(&f->lock);
    const double deg = f->table_deg;
    if (moving)
        *moving = f->state == FAKE_JOG || f->state == FAKE_RUN;
    pthread_mutex_unlock(&f->lock);
    return deg;
}

void fake_grbl_push(fake_grbl *f, double delta_deg)
{
    pthread_mutex_lock(&f->lock);
    f->table_deg += delta_deg;
    f->gear_deg += delta_deg;
    pthread_mutex_unlock(&f->lock);
}
