// SPDX-License-Identifier: Apache-2.0
// page_html.c - the viewer with a packed model in it: one HTML file that asks for nothing else.
#include "render/page.h"

#include <stdlib.h>
#include <string.h>

char *sheen_put_base64(char *to, const uint8_t *data, size_t size_bytes)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=";
    enum { PADDING = 64 };
    for (size_t i = 0; i < size_bytes; i += 3) {
        const uint32_t a = data[i], b = i + 1 < size_bytes ? data[i + 1] : 0,
                       c = i + 2 < size_bytes ? data[i + 2] : 0, bits = a << 16 | b << 8 | c;
        *to++ = digits[bits >> 18];
        *to++ = digits[bits >> 12 & 63];
        *to++ = digits[i + 1 < size_bytes ? bits >> 6 & 63 : PADDING];
        *to++ = digits[i + 2 < size_bytes ? bits & 63 : PADDING];
    }
    return to;
}

enum { LONGEST_ENTITY = 6 };

// Safe inside an element and inside a quoted attribute; control characters become spaces.
static char *put_escaped(char *to, const char *text)
{
    for (; *text; text++) {
        const char *entity = *text == '&'    ? "&amp;"
                             : *text == '<'  ? "&lt;"
                             : *text == '>'  ? "&gt;"
                             : *text == '"'  ? "&quot;"
                             : *text == '\'' ? "&#39;"
                                             : NULL;
        while (entity && *entity)
            *to++ = *entity++;
        if (!entity) {
            *to = *text;
            if ((unsigned char)*to < 32)
                *to = ' ';
            to++;
        }
    }
    return to;
}

// JSON inside a script element: no '<' may start a tag there.
static char *put_json(char *to, const char *json)
{
    static const char escaped[] = "\\u003c";
    for (; *json; json++)
        if (*json == '<') {
            memcpy(to, escaped, sizeof escaped - 1);
            to += sizeof escaped - 1;
        } else {
            *to++ = *json;
        }
    return to;
}

static char *put_part(char *to, int part, const sheen_page *page, const sheen_page_words *words)
{
    switch (part) {
    case 0:
        return put_escaped(to, words->sources);
    case 1:
        return put_escaped(to, words->title);
    case 2:
        return put_json(to, words->more_json);
    case 3:
        return sheen_put_base64(to, page->geometry, page->geometry_bytes);
    case 4:
        return sheen_put_base64(to, page->texture, page->texture_bytes);
    default:
        return sheen_put_base64(to, page->board, page->board_bytes);
    }
}

sheen_status sheen_page_html(char **text, size_t *size_bytes, const sheen_page *page, const char *html,
                             const sheen_page_words *words, sheen_err *err)
{
    static const char *const marks[] = {"@SHEEN_SOURCES@",  "@SHEEN_TITLE@",   "@SHEEN_MORE@",
                                        "@SHEEN_GEOMETRY@", "@SHEEN_TEXTURE@", "@SHEEN_BOARD@"};
    enum { N_PARTS = sizeof marks / sizeof *marks };
    *text = NULL;
    *size_bytes = 0;
    const size_t n_words = strlen(words->title) + strlen(words->sources) + strlen(words->more_json);
    const size_t room_bytes = strlen(html) + LONGEST_ENTITY * n_words +
                              4 * (page->geometry_bytes + page->texture_bytes + page->board_bytes + 9) / 3 +
                              9;
    char *room = malloc(room_bytes), *to = room;
    if (!room)
        return sheen_fail_memory(err, (double)room_bytes, "a page");
    for (int part = 0; part < N_PARTS; part++) {
        const char *mark = strstr(html, marks[part]);
        if (!mark) {
            free(room);
            return sheen_fail(err, SHEEN_EARG, "the viewer has no mark '%s'", marks[part]);
        }
        const size_t n = (size_t)(mark - html);
        memcpy(to, html, n);
        to = put_part(to + n, part, page, words);
        html = mark + strlen(marks[part]);
    }
    const size_t n = strlen(html);
    memcpy(to, html, n + 1);
    *size_bytes = (size_t)(to - room) + n;
    *text = room;
    return SHEEN_OK;
}
