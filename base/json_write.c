// SPDX-License-Identifier: Apache-2.0
// json_write.c - writing JSON into a growing buffer: two spaces a level, short arrays on one line.
#include "base/json_write.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void append(sheen_json_writer *w, const char *text, size_t n)
{
    sheen_text_append(&w->text, text, n);
}

static void append_text(sheen_json_writer *w, const char *text)
{
    append(w, text, strlen(text));
}

static void append_quoted(sheen_json_writer *w, const char *text)
{
    append(w, "\"", 1);
    for (const char *c = text; *c; c++) {
        char escaped[8];
        if (*c == '"' || *c == '\\')
            snprintf(escaped, sizeof escaped, "\\%c", *c);
        else if ((unsigned char)*c < 0x20)
            snprintf(escaped, sizeof escaped, "\\u%04x", (unsigned)(unsigned char)*c);
        else
            snprintf(escaped, sizeof escaped, "%c", *c);
        append_text(w, escaped);
    }
    append(w, "\"", 1);
}

static void new_line(sheen_json_writer *w)
{
    append(w, "\n", 1);
    for (int i = 0; i < w->depth; i++)
        append(w, "  ", 2);
}

static void begin_value(sheen_json_writer *w, const char *key)
{
    assert(!w->depth || (w->closers[w->depth - 1] == '}') == (key != NULL));
    if (w->depth) {
        if (w->has_member[w->depth])
            append(w, ",", 1);
        w->has_member[w->depth] = true;
        new_line(w);
    }
    if (key) {
        append_quoted(w, key);
        append(w, ": ", 2);
    }
}

void sheen_json_open(sheen_json_writer *w, const char *key, char bracket)
{
    assert(w->depth < (int)sizeof w->closers);
    begin_value(w, key);
    append(w, &bracket, 1);
    w->closers[w->depth++] = bracket == '{' ? '}' : ']';
    w->has_member[w->depth] = false;
}

void sheen_json_close(sheen_json_writer *w)
{
    assert(w->depth > 0);
    const bool had = w->has_member[w->depth];
    w->depth--;
    if (had)
        new_line(w);
    append(w, &w->closers[w->depth], 1);
}

// The shortest of %.15g and %.17g that reads back as the same double.
static void append_number(sheen_json_writer *w, double x)
{
    char text[40];
    if (!isfinite(x)) {
        append_text(w, "null");
        return;
    }
    snprintf(text, sizeof text, "%.15g", x);
    if (strtod(text, NULL) != x)
        snprintf(text, sizeof text, "%.17g", x);
    append_text(w, text);
}

void sheen_json_put_number(sheen_json_writer *w, const char *key, double x)
{
    begin_value(w, key);
    append_number(w, x);
}

void sheen_json_put_int(sheen_json_writer *w, const char *key, long long x)
{
    char text[32];
    begin_value(w, key);
    snprintf(text, sizeof text, "%lld", x);
    append_text(w, text);
}

void sheen_json_put_string(sheen_json_writer *w, const char *key, const char *text)
{
    begin_value(w, key);
    if (text)
        append_quoted(w, text);
    else
        append_text(w, "null");
}

void sheen_json_put_bool(sheen_json_writer *w, const char *key, bool x)
{
    begin_value(w, key);
    append_text(w, x ? "true" : "false");
}

void sheen_json_put_numbers(sheen_json_writer *w, const char *key, const double *x, size_t n)
{
    begin_value(w, key);
    append(w, "[", 1);
    for (size_t i = 0; i < n; i++) {
        if (i)
            append(w, ", ", 2);
        append_number(w, x[i]);
    }
    append(w, "]", 1);
}

const char *sheen_json_text(sheen_json_writer *w)
{
    return sheen_text_string(&w->text);
}

sheen_status sheen_json_save(sheen_json_writer *w, const char *path, sheen_err *err)
{
    assert(!w->depth);
    append(w, "\n", 1);
    const sheen_status s = sheen_text_save(&w->text, path, err);
    sheen_json_writer_release(w);
    return s;
}

void sheen_json_writer_release(sheen_json_writer *w)
{
    sheen_text_release(&w->text);
    *w = (sheen_json_writer){0};
}
