// SPDX-License-Identifier: Apache-2.0
// report.c - the page of a report: text, tables, pictures; written as HTML 5 with its style inside.
#include "base/report.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/image_file.h"

enum { MAX_TEXT_BYTES = 2000 };

static const char style[] =
    ":root{color-scheme:light dark;--ink:#1d2228;--soft:#68717c;--line:#d5dae0;--paper:#fff;--good:#1a7f37;"
    "--care:#b35900;--mark:#2563b0}"
    "@media(prefers-color-scheme:dark){:root{--ink:#e4e8ec;--soft:#9aa4af;--line:#3a424b;--paper:#15191d;"
    "--good:#4ac26b;--care:#f0a04b;--mark:#74a9f0}}"
    "body{font:15px/1.5 "
    "system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:960px;margin:2em "
    "auto;padding:0 1em}"
    "h1{font-size:1.5em;margin:0 0 .4em}h2{font-size:1.1em;margin:2em 0 .4em;border-top:1px solid "
    "var(--line);padding-top:.8em}"
    ".verdict{font-size:1.1em;border-left:4px solid var(--care);padding:.4em "
    ".8em}.good{border-color:var(--good)}"
    "table{border-collapse:collapse;margin:.6em 0;font-variant-numeric:tabular-nums}td,th{padding:.15em "
    ".7em;text-align:right;border-bottom:1px solid var(--line)}td:first-child,th:first-child{text-align:left}"
    "td:first-child{white-space:nowrap}.said td:last-child,.said th:last-child{text-align:left}"
    "th{font-weight:600;color:var(--soft)}.flow{display:flex;flex-wrap:wrap;gap:1em}figure{margin:.6em "
    "0;max-width:100%}figcaption{color:var(--soft);font-size:.9em}img,svg{max-width:100%;height:auto}"
    "svg text{fill:var(--ink);font:11px system-ui,sans-serif}.axis{stroke:var(--soft);fill:none}"
    ".grid{stroke:var(--line)}";

static void append(sheen_report *r, const char *text, size_t size_bytes)
{
    sheen_text_append(&r->text, text, size_bytes);
}

void sheen_report_raw(sheen_report *r, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    sheen_text_put_args(&r->text, fmt, args);
    va_end(args);
}

void sheen_report_escaped(sheen_report *r, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '&':
            append(r, "&amp;", 5);
            break;
        case '<':
            append(r, "&lt;", 4);
            break;
        case '>':
            append(r, "&gt;", 4);
            break;
        case '"':
            append(r, "&quot;", 6);
            break;
        default:
            append(r, text, 1);
        }
}

static void close_flow(sheen_report *r)
{
    if (r->in_table)
        sheen_report_raw(r, "</table>\n");
    if (r->in_flow)
        sheen_report_raw(r, "</div>\n");
    r->in_table = r->in_flow = false;
}

void sheen_report_flow(sheen_report *r)
{
    if (r->in_flow)
        return;
    close_flow(r);
    sheen_report_raw(r, "<div class=\"flow\">\n");
    r->in_flow = true;
}

void sheen_report_begin(sheen_report *r, const char *title, bool good, const char *verdict)
{
    sheen_report_raw(r, "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                        "<meta name=\"viewport\" content=\"width=device-width\">\n<title>");
    sheen_report_escaped(r, title);
    sheen_report_raw(r, "</title>\n<style>");
    append(r, style, sizeof style - 1);
    sheen_report_raw(r, "</style></head><body>\n<h1>");
    sheen_report_escaped(r, title);
    sheen_report_raw(r, "</h1>\n<p class=\"verdict%s\">", good ? " good" : "");
    sheen_report_escaped(r, verdict);
    sheen_report_raw(r, "</p>\n");
}

void sheen_report_section(sheen_report *r, const char *heading)
{
    close_flow(r);
    if (r->in_section)
        sheen_report_raw(r, "</section>\n");
    sheen_report_raw(r, "<section><h2>");
    sheen_report_escaped(r, heading);
    sheen_report_raw(r, "</h2>\n");
    r->in_section = true;
}

void sheen_report_text(sheen_report *r, const char *fmt, ...)
{
    char text[MAX_TEXT_BYTES];
    va_list args;
    va_start(args, fmt);
    vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    close_flow(r);
    sheen_report_raw(r, "<p>");
    sheen_report_escaped(r, text);
    sheen_report_raw(r, "</p>\n");
}

// Cells of a row, parted by '|'; numbers that are not finite become a dash.
static void write_cells(sheen_report *r, char *cells, const char *tag)
{
    sheen_report_raw(r, "<tr>");
    for (char *cell = cells; cell;) {
        char *next = strchr(cell, '|');
        if (next)
            *next++ = 0;
        const bool none = !strcmp(cell, "nan") || !strcmp(cell, "-nan") || !strcmp(cell, "inf");
        sheen_report_raw(r, "<%s>", tag);
        sheen_report_escaped(r, none ? "\xe2\x80\x93" : cell);
        sheen_report_raw(r, "</%s>", tag);
        cell = next;
    }
    sheen_report_raw(r, "</tr>\n");
}

void sheen_report_table(sheen_report *r, const char *headings)
{
    char cells[MAX_TEXT_BYTES];
    snprintf(cells, sizeof cells, "%s", headings);
    close_flow(r);
    const char *last = strrchr(headings, '|'); // words are read from the left
    sheen_report_raw(r, last && !strcmp(last, "|remark") ? "<table class=said>\n" : "<table>\n");
    r->in_table = true;
    write_cells(r, cells, "th");
}

void sheen_report_row(sheen_report *r, const char *fmt, ...)
{
    char cells[MAX_TEXT_BYTES];
    va_list args;
    va_start(args, fmt);
    vsnprintf(cells, sizeof cells, fmt, args);
    va_end(args);
    write_cells(r, cells, "td");
}

// RFC 4648
static void append_base64(sheen_report *r, const uint8_t *data, size_t size_bytes)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size_bytes; i += 3) {
        const uint32_t a = data[i], b = i + 1 < size_bytes ? data[i + 1] : 0,
                       c = i + 2 < size_bytes ? data[i + 2] : 0, bits = a << 16 | b << 8 | c;
        char four[4] = {digits[bits >> 18], digits[bits >> 12 & 63], '=', '='};
        if (i + 1 < size_bytes)
            four[2] = digits[bits >> 6 & 63];
        if (i + 2 < size_bytes)
            four[3] = digits[bits & 63];
        append(r, four, 4);
    }
}

sheen_status sheen_report_picture(sheen_report *r, const sheen_raster *picture, int width_px,
                                  const char *caption, sheen_err *err)
{
    uint8_t *png = NULL;
    size_t size_bytes = 0;
    const sheen_status s = sheen_png_encode(&png, &size_bytes, picture, err);
    if (s)
        return s;
    sheen_report_flow(r);
    sheen_report_raw(r, "<figure><img width=\"%d\" alt=\"", width_px > 0 ? width_px : picture->width_px);
    sheen_report_escaped(r, caption);
    sheen_report_raw(r, "\" src=\"data:image/png;base64,");
    append_base64(r, png, size_bytes);
    sheen_report_raw(r, "\"><figcaption>");
    sheen_report_escaped(r, caption);
    sheen_report_raw(r, "</figcaption></figure>\n");
    free(png);
    return SHEEN_OK;
}

void sheen_report_release(sheen_report *r)
{
    sheen_text_release(&r->text);
    *r = (sheen_report){0};
}

sheen_status sheen_report_save(sheen_report *r, const char *path, sheen_err *err)
{
    close_flow(r);
    sheen_report_raw(r, "%s</body></html>\n", r->in_section ? "</section>\n" : "");
    const sheen_status s = sheen_text_save(&r->text, path, err);
    sheen_report_release(r);
    return s;
}
