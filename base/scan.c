// SPDX-License-Identifier: Apache-2.0
// scan.c - lines, words and numbers of a text in memory.
#include "base/scan.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool ends_line(char c)
{
    return c == '\n' || c == '\r';
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || ends_line(c);
}

bool sheen_scan_line(sheen_scan *text, sheen_scan *line)
{
    if (text->at == text->end)
        return false;
    const char *end = text->at;
    while (end < text->end && !ends_line(*end))
        end++;
    *line = (sheen_scan){text->at, end, ++text->line};
    if (end < text->end)
        end += *end == '\r' && end + 1 < text->end && end[1] == '\n' ? 2 : 1;
    text->at = end;
    return true;
}

bool sheen_scan_word(sheen_scan *line, sheen_word *word)
{
    while (line->at < line->end && is_blank(*line->at))
        line->at++;
    const char *begin = line->at;
    while (line->at < line->end && !is_blank(*line->at))
        line->at++;
    *word = (sheen_word){begin, (size_t)(line->at - begin)};
    return word->length > 0;
}

sheen_word sheen_scan_rest(sheen_scan *line)
{
    while (line->at < line->end && is_blank(*line->at))
        line->at++;
    const char *begin = line->at, *end = line->end;
    while (end > begin && is_blank(end[-1]))
        end--;
    line->at = line->end;
    return (sheen_word){begin, (size_t)(end - begin)};
}

bool sheen_word_is(const sheen_word *word, const char *text)
{
    return strlen(text) == word->length && !memcmp(word->text, text, word->length);
}

// strtod and strtoll want a NUL; no number that a program writes is longer than this.
enum { MAX_NUMBER = 63 };

static bool copy_number(char out[MAX_NUMBER + 1], const sheen_word *word)
{
    if (!word->length || word->length > MAX_NUMBER)
        return false;
    memcpy(out, word->text, word->length);
    out[word->length] = 0;
    return true;
}

bool sheen_word_number(const sheen_word *word, double *out)
{
    char text[MAX_NUMBER + 1], *end;
    if (!copy_number(text, word))
        return false;
    const double x = strtod(text, &end);
    if (*end || end == text || !isfinite(x))
        return false;
    *out = x;
    return true;
}

bool sheen_word_integer(const sheen_word *word, long long min, long long max, long long *out)
{
    char text[MAX_NUMBER + 1], *end;
    if (!copy_number(text, word))
        return false;
    errno = 0;
    const long long x = strtoll(text, &end, 10);
    if (*end || end == text || errno || x < min || x > max)
        return false;
    *out = x;
    return true;
}

bool sheen_scan_number(sheen_scan *line, double *out)
{
    sheen_word word;
    return sheen_scan_word(line, &word) && sheen_word_number(&word, out);
}
