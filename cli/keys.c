// SPDX-License-Identifier: Apache-2.0
// keys.c - a terminal without its line buffer (termios), asked in passing; signals and echo stay as they are.
#include "cli/keys.h"

#include <poll.h>
#include <stdio.h>
#include <termios.h>
#include <unistd.h>

enum { LOOK_MS = 100 };

static struct {
    bool open;
    struct termios found;
    bool stop, quit, pause;
} keys;

static void set_single(bool single)
{
    struct termios t = keys.found;
    if (single)
        t.c_lflag &= ~(tcflag_t)ICANON;
    tcsetattr(STDIN_FILENO, TCSANOW, &t);
}

void sheen_cli_keys_open(void)
{
    keys.stop = keys.quit = keys.pause = false;
    keys.open = isatty(STDIN_FILENO) && !tcgetattr(STDIN_FILENO, &keys.found);
    if (!keys.open)
        return;
    tcflush(STDIN_FILENO, TCIFLUSH);
    set_single(true);
}

void sheen_cli_keys_close(void)
{
    if (keys.open)
        set_single(false);
    keys.open = false;
}

// Takes in what was pressed; waits so long for it.
static void read_keys(int timeout_ms)
{
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    if (!keys.open) {
        poll(NULL, 0, timeout_ms);
        return;
    }
    for (; poll(&input, 1, timeout_ms) > 0; timeout_ms = 0) {
        char c;
        if (read(STDIN_FILENO, &c, 1) != 1) { // hung up: nobody is there any more
            keys.open = false;
            return;
        }
        keys.stop = keys.stop || c == 's';
        keys.quit = keys.quit || c == 'q';
        if (c == 'p' || c == ' ')
            keys.pause = !keys.pause;
    }
}

bool sheen_cli_keys_stopped(void)
{
    read_keys(0);
    return keys.stop || sheen_cli_interrupted();
}

sheen_status sheen_cli_keys_between(sheen_cli *cli, sheen_err *err)
{
    bool said = false;
    while (!sheen_cli_keys_stopped() && !keys.quit && keys.pause) {
        if (!said)
            sheen_cli_warn(cli, "paused; p goes on, q ends");
        said = true;
        read_keys(LOOK_MS);
    }
    if (keys.stop || keys.quit || sheen_cli_interrupted())
        return sheen_fail(err, SHEEN_ECANCEL, "ended by the person");
    if (said)
        sheen_cli_warn(cli, "it goes on");
    return SHEEN_OK;
}

sheen_status sheen_cli_ask(char *line, size_t size_bytes, sheen_cli *cli, const char *prompt, sheen_err *err)
{
    size_t n = 0;
    char c = 0;
    ssize_t got;
    sheen_cli_clear_bar(cli);
    fprintf(stderr, "%s ", prompt);
    if (keys.open)
        set_single(false);
    while ((got = read(STDIN_FILENO, &c, 1)) == 1 && c != '\n')
        if (n + 1 < size_bytes && c != '\r')
            line[n++] = c;
    line[n] = '\0';
    if (keys.open)
        set_single(true);
    if (sheen_cli_interrupted() || (got < 1 && !n))
        return sheen_fail(err, SHEEN_ECANCEL, "nobody answered");
    return SHEEN_OK;
}
