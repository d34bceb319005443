// SPDX-License-Identifier: Apache-2.0
// capture_items.c - reads the list of a batch's objects.
#include "cli/capture_items.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/session.h"

enum { MAX_BYTES = 4 << 20, MAX_COLUMNS = 64, NAME = 0, CODE, MESH, N_KNOWN };

typedef struct reader {
    const char *at, *end;
    int line;
} reader;

// One field, without its quotes; *last: its line ends here. False: too long for `out`, or a quote that does not end.
static bool read_field(char *out, size_t size_bytes, bool *last, reader *r)
{
    size_t n = 0;
    bool quoted = r->at < r->end && *r->at == '"', fits = true;
    r->at += quoted;
    for (; r->at < r->end; r->at++) {
        char c = *r->at;
        if (quoted && c == '"') {
            if (r->at + 1 < r->end && r->at[1] == '"')
                r->at++;
            else {
                quoted = false;
                continue;
            }
        } else if (!quoted && (c == ',' || c == '\n'))
            break;
        else if (c == '\r')
            continue;
        r->line += c == '\n';
        fits = fits && c && n + 1 < size_bytes;
        if (fits)
            out[n++] = c;
    }
    out[n] = '\0';
    *last = r->at == r->end || *r->at == '\n';
    if (r->at < r->end) {
        r->line += *r->at == '\n';
        r->at++;
    }
    return fits && !quoted;
}

static sheen_status read_heading(int known[MAX_COLUMNS], int *n_columns, reader *r, sheen_err *err)
{
    static const char *const names[N_KNOWN] = {"name", "code", "mesh"};
    char word[64];
    bool last = false, named = false;
    for (*n_columns = 0; !last; (*n_columns)++) {
        if (*n_columns == MAX_COLUMNS || !read_field(word, sizeof word, &last, r))
            return sheen_fail(err, SHEEN_EFORMAT, "line 1 does not name the columns");
        known[*n_columns] = N_KNOWN;
        for (int k = 0; k < N_KNOWN; k++)
            if (!strcmp(word, names[k]))
                known[*n_columns] = k;
        named = named || known[*n_columns] == NAME;
    }
    return named ? SHEEN_OK : sheen_fail(err, SHEEN_EFORMAT, "line 1 names no column 'name'");
}

static sheen_cli_item *grow(sheen_cli_items *items)
{
    if (items->n >= SHEEN_CLI_MAX_ITEMS)
        return NULL;
    sheen_cli_item *more = realloc(items->items, (items->n + 1) * sizeof *more);
    if (!more)
        return NULL;
    items->items = more;
    more[items->n] = (sheen_cli_item){{0}, {0}, {0}};
    return &more[items->n];
}

static sheen_status check_item(const sheen_cli_items *items, const sheen_cli_item *item, int line,
                               sheen_err *err)
{
    if (!sheen_frame_name_ok(item->name))
        return sheen_fail(err, SHEEN_EFORMAT,
                          "line %d: '%.60s' is no name: 1 to 60 of letters, digits, '.', '_' and '-'", line,
                          item->name);
    for (size_t i = 0; i < items->n; i++)
        if (!strcmp(items->items[i].name, item->name) ||
            (*item->code && !strcmp(items->items[i].code, item->code)))
            return sheen_fail(err, SHEEN_EFORMAT, "line %d: '%.60s' has the name or the code of '%.60s'",
                              line, item->name, items->items[i].name);
    return SHEEN_OK;
}

static sheen_status read_items(sheen_cli_items *out, reader *r, sheen_err *err)
{
    int known[MAX_COLUMNS], n_columns;
    sheen_status s = read_heading(known, &n_columns, r, err);
    while (!s && r->at < r->end) {
        const int line = r->line;
        char passed_over[SHEEN_PATH_MAX];
        sheen_cli_item *item = grow(out);
        if (!item)
            return sheen_fail(err, SHEEN_ENOMEM, "no memory for more than %zu objects", out->n);
        char *const fields[N_KNOWN + 1] = {item->name, item->code, item->mesh, passed_over};
        const size_t sizes[N_KNOWN + 1] = {sizeof item->name, sizeof item->code, sizeof item->mesh,
                                           sizeof passed_over};
        bool last = false, empty = true;
        for (int c = 0; !last; c++) {
            const int k = c < n_columns ? known[c] : N_KNOWN;
            if (!read_field(fields[k], sizes[k], &last, r))
                return sheen_fail(err, SHEEN_EFORMAT, "line %d: a field is too long, or a quote does not end",
                                  line);
            empty = empty && last && c == 0 && !*fields[k];
        }
        if (empty)
            continue;
        if (!(s = check_item(out, item, line, err)))
            out->n++;
    }
    return s;
}

sheen_status sheen_cli_items_parse(sheen_cli_items *out, const void *data, size_t size_bytes, sheen_err *err)
{
    static const char mark[3] = {'\xef', '\xbb', '\xbf'}; // spreadsheets write it before UTF-8
    reader r = {.at = data, .end = (const char *)data + size_bytes, .line = 1};
    *out = (sheen_cli_items){0};
    if (size_bytes >= sizeof mark && !memcmp(data, mark, sizeof mark))
        r.at += sizeof mark;
    const sheen_status s = read_items(out, &r, err);
    if (s)
        sheen_cli_items_release(out);
    return s;
}

sheen_status sheen_cli_items_load(sheen_cli_items *out, const char *path, sheen_err *err)
{
    uint8_t *data;
    size_t size_bytes;
    sheen_status s = sheen_file_read(&data, &size_bytes, path, MAX_BYTES, err);
    if (s)
        return s;
    s = sheen_cli_items_parse(out, data, size_bytes, err);
    free(data);
    return s ? sheen_wrap(err, s, "cannot read the list '%.200s'", path) : s;
}

void sheen_cli_items_release(sheen_cli_items *items)
{
    free(items->items);
    *items = (sheen_cli_items){0};
}

size_t sheen_cli_items_find(const sheen_cli_items *items, const char *word)
{
    for (size_t i = 0; i < items->n; i++)
        if (*items->items[i].code && !strcmp(items->items[i].code, word))
            return i;
    for (size_t i = 0; i < items->n; i++)
        if (!strcmp(items->items[i].name, word))
            return i;
    return items->n;
}

sheen_status sheen_cli_items_add(sheen_cli_items *items, const char *code, sheen_err *err)
{
    sheen_cli_item *item = grow(items);
    if (!item)
        return sheen_fail(err, SHEEN_ENOMEM, "no memory for more than %zu objects", items->n);
    snprintf(item->code, sizeof item->code, "%s", code);
    snprintf(item->name, sizeof item->name, "%.60s", code);
    for (char *c = item->name; *c; c++) {
        const char one[2] = {*c, '\0'};
        if (!sheen_frame_name_ok(one) && (*c != '.' || c == item->name))
            *c = '_';
    }
    if (!sheen_frame_name_ok(item->name) || sheen_cli_items_find(items, item->name) < items->n)
        return sheen_fail(err, SHEEN_EARG, "'%.60s' gives no name that is free", code);
    items->n++;
    return SHEEN_OK;
}
