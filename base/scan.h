// SPDX-License-Identifier: Apache-2.0
// scan.h - reading text formats: lines and words of a piece of memory, never beyond its end.
//
// Words are separated by blanks and tabs, lines by LF, CR or CR LF.
#ifndef SHEEN_BASE_SCAN_H
#define SHEEN_BASE_SCAN_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_scan {
    const char *at, *end;
    size_t line; // number of the line last given by sheen_scan_line, from 1
} sheen_scan;

typedef struct sheen_word {
    const char *text; // not ended by a NUL
    size_t length;
} sheen_word;

// The next line as a scan of its own; false at the end of the text.
bool sheen_scan_line(sheen_scan *text, sheen_scan *line);

// The next word; false at the end of the line. On a whole text ends of lines count as blanks.
bool sheen_scan_word(sheen_scan *line, sheen_word *word);

// The rest of the line without blanks at its ends.
sheen_word sheen_scan_rest(sheen_scan *line);

bool sheen_word_is(const sheen_word *word, const char *text);

// The whole word as a number. False for anything else, also for what is not finite.
bool sheen_word_number(const sheen_word *word, double *out);
bool sheen_word_integer(const sheen_word *word, long long min, long long max, long long *out);

// The next word as a number.
bool sheen_scan_number(sheen_scan *line, double *out);

#ifdef __cplusplus
}
#endif
#endif
