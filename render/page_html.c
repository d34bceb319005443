// SPDX-License-Identifier: Apache-2.0
// page_html.c - the viewer with a packed model in it: one HTML file that asks for nothing else.
#include "render/page.h"

#include <stdlib.h>
#include <string.h>

static const char *const marks[] = {"@SHEEN_TITLE@", "@SHEEN_GEOMETRY@", "@SHEEN_TEXTURE@"};

// RFC 4648. Returns the end of what was written: 4 characters for each 3 bytes begun.
static char *put_base64(char *to, const uint8_t *data, size_t size_bytes)
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

sheen_status sheen_page_html(char **text, size_t *size_bytes, const sheen_page *page, const char *html,
                             const char *title, sheen_err *err)
{
    *text = NULL;
    *size_bytes = 0;
    const size_t room_bytes = strlen(html) + LONGEST_ENTITY * strlen(title) +
                              4 * ((page->geometry_bytes + 2) / 3 + (page->texture_bytes + 2) / 3) + 1;
    char *room = malloc(room_bytes), *to = room;
    if (!room)
        return sheen_fail_memory(err, (double)room_bytes, "a page");
    for (int part = 0; part < 3; part++) {
        const char *mark = strstr(html, marks[part]);
        if (!mark) {
            free(room);
            return sheen_fail(err, SHEEN_EARG, "the viewer has no mark '%s'", marks[part]);
        }
        const size_t n = (size_t)(mark - html);
        memcpy(to, html, n);
        to += n;
        html = mark + strlen(marks[part]);
        if (part == 0)
            to = put_escaped(to, title);
        else
            to = part == 1 ? put_base64(to, page->geometry, page->geometry_bytes)
                           : put_base64(to, page->texture, page->texture_bytes);
    }
    const size_t n = strlen(html);
    memcpy(to, html, n + 1);
    *size_bytes = (size_t)(to - room) + n;
    *text = room;
    return SHEEN_OK;
}
