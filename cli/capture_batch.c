// SPDX-License-Identifier: Apache-2.0
// capture_batch.c - objects one after the other: one key between them, a session each, and at the end what is to be done
// again. What is done is read from the sessions, so that a batch that ended anywhere goes on with the same command.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json_write.h"
#include "capture/import.h"
#include "cli/capture_items.h"
#include "cli/capture_job.h"
#include "cli/keys.h"
#include "cli/stages.h"

#define BATCH_FILE "batch.json"

// How an object stands.
typedef struct standing {
    size_t n_missing; // frames
    size_t n_unseen;  // frames in which the tags did not show the angle
    bool skipped;     // for now: at the next call it is asked for again
    char failed[200]; // why its last capture ended before its end
    char model[200];  // of --then run: "made", or why not
} standing;

typedef struct batch {
    sheen_cli *cli;
    sheen_cli_capture *args;
    const char *folder;
    sheen_cli_items items;
    standing *standings; // [items.n]
    bool any_code;       // the list was empty: whatever is scanned is an object
} batch;

static sheen_status session_path(char path[SHEEN_PATH_MAX], const batch *b, size_t i, sheen_err *err)
{
    char name[SHEEN_CLI_ITEM_NAME + 16];
    snprintf(name, sizeof name, "%s.session", b->items.items[i].name);
    return sheen_path_join(path, b->folder, name, err);
}

// What the session on the disk says of an object; none is one of which nothing is there.
static sheen_status look_up(batch *b, size_t i, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    standing *st = &b->standings[i];
    sheen_session s;
    sheen_status status = session_path(path, b, i, err);
    st->n_missing = (size_t)b->args->n_steps * (size_t)b->args->n_rounds;
    st->n_unseen = 0;
    if (status || !sheen_dir_exists(path))
        return status;
    if ((status = sheen_session_open(&s, path, err)))
        return status;
    st->n_missing = sheen_cli_capture_missing(b->args, &s);
    const bool sees = sheen_session_has(&s, SHEEN_SESSION_CAMERA) &&
                      sheen_session_has(&s, SHEEN_SESSION_BOARD);
    for (size_t k = 0; k < s.n_frames && sees; k++)
        st->n_unseen += isfinite(s.frames[k].table_asked_deg) && !isfinite(s.frames[k].table_measured_deg);
    sheen_session_release(&s);
    return SHEEN_OK;
}

static sheen_status look_up_all(batch *b, sheen_err *err)
{
    sheen_status s = SHEEN_OK;
    b->standings = calloc(b->items.n + 1, sizeof *b->standings);
    if (!b->standings)
        return sheen_fail_memory(err, (double)b->items.n * sizeof *b->standings, "a batch");
    for (size_t i = 0; i < b->items.n && !s; i++)
        s = look_up(b, i, err);
    return s;
}

static sheen_status add(batch *b, const char *code, sheen_err *err)
{
    standing *more = realloc(b->standings, (b->items.n + 2) * sizeof *more);
    if (!more)
        return sheen_fail_memory(err, (double)b->items.n * sizeof *more, "a batch");
    b->standings = more;
    const sheen_status s = sheen_cli_items_add(&b->items, code, err);
    if (s)
        return s;
    more[b->items.n - 1] = (standing){0};
    return look_up(b, b->items.n - 1, err);
}

static bool is_open(const standing *st)
{
    return st->n_missing && !st->skipped;
}

// The next object that the person is asked for; n: none.
static size_t next_open(const batch *b)
{
    size_t i = 0;
    while (i < b->items.n && !is_open(&b->standings[i]))
        i++;
    return i;
}

static size_t count_complete(const batch *b)
{
    size_t n = 0;
    for (size_t i = 0; i < b->items.n; i++)
        n += !b->standings[i].n_missing;
    return n;
}

// Which object stands on the table: one key for the next on the list. *out = n: the person ends it.
static sheen_status ask_object(size_t *out, batch *b, sheen_err *err)
{
    char prompt[400], line[SHEEN_CLI_ITEM_CODE], before[SHEEN_CLI_ITEM_CODE] = "";
    for (;;) {
        const size_t next = next_open(b);
        *out = b->items.n;
        if (next == b->items.n && !b->any_code)
            return SHEEN_OK;
        if (next == b->items.n)
            snprintf(prompt, sizeof prompt,
                     "[%zu done] put an object on the table and scan its code (q ends):", count_complete(b));
        else
            snprintf(
                prompt, sizeof prompt,
                "[%zu of %zu done] put '%s' on the table and press Enter (or scan another; s skips it, q "
                "ends):",
                count_complete(b), b->items.n, b->items.items[next].name);
        sheen_status s = sheen_cli_ask(line, sizeof line, b->cli, prompt, err);
        if (s || !strcmp(line, "q"))
            return s;
        const size_t found = *line ? sheen_cli_items_find(&b->items, line) : next;
        if (next < b->items.n && !strcmp(line, "s"))
            b->standings[next].skipped = true;
        else if (found < b->items.n && b->standings[found].n_missing) {
            *out = found;
            return SHEEN_OK;
        } else if (found < b->items.n)
            sheen_cli_warn(b->cli, "'%s' is complete already", b->items.items[found].name);
        else if (*line && (b->any_code || !strcmp(line, before))) {
            if ((s = add(b, line, err)))
                return s;
            *out = b->items.n - 1;
            return SHEEN_OK;
        } else if (*line)
            sheen_cli_warn(b->cli, "'%s' is not on the list; again, and it is added", line);
        snprintf(before, sizeof before, "%s", line);
    }
}

// The mesh that the list names, where the session has none.
static sheen_status bring_mesh(const batch *b, size_t i, const char *path, sheen_err *err)
{
    sheen_session s;
    sheen_import_report r;
    const sheen_import_options o = {.mesh = b->items.items[i].mesh};
    if (!*o.mesh)
        return SHEEN_OK;
    sheen_status st = sheen_session_create(&s, path, SHEEN_MOVING_OBJECT, err);
    if (!st && !sheen_session_mesh_file(&s))
        st = sheen_import(&s, &o, &r, err);
    sheen_session_release(&s);
    return st;
}

static sheen_status capture(batch *b, size_t i, sheen_err *err)
{
    char path[SHEEN_PATH_MAX];
    sheen_err why = {0};
    const sheen_record_options o = b->args->o;
    sheen_status s = session_path(path, b, i, err);
    if (s)
        return s;
    sheen_json_open(&b->cli->out, NULL, '{');
    s = bring_mesh(b, i, path, &why);
    if (!s)
        s = sheen_cli_capture_session(b->cli, b->args, path, &why);
    sheen_json_close(&b->cli->out);
    b->args->o = o;
    snprintf(b->standings[i].failed, sizeof b->standings[i].failed, "%.*s", s ? 199 : 0, why.msg);
    if (s)
        sheen_cli_warn(b->cli, "'%s': %s", b->items.items[i].name, why.msg);
    return look_up(b, i, err);
}

static sheen_status capture_all(batch *b, sheen_err *err)
{
    sheen_status s;
    size_t i;
    sheen_json_open(&b->cli->out, "captures", '[');
    while (!(s = ask_object(&i, b, err)) && i < b->items.n)
        if ((s = capture(b, i, err)) || sheen_cli_interrupted())
            break;
    sheen_json_close(&b->cli->out);
    return s == SHEEN_ECANCEL ? SHEEN_OK : s; // what is there is still said
}

// The models of all objects that are complete. What fails there is no fault of the capture.
static void run_all(batch *b)
{
    const sheen_cli_run_options o = {0};
    sheen_json_open(&b->cli->out, "models", '[');
    for (size_t i = 0; i < b->items.n && !sheen_cli_interrupted(); i++) {
        char path[SHEEN_PATH_MAX];
        sheen_err why = {0};
        if (b->standings[i].n_missing)
            continue;
        sheen_cli_say(b->cli, "\nmodel of '%s'", b->items.items[i].name);
        sheen_json_open(&b->cli->out, NULL, '{');
        sheen_status s = session_path(path, b, i, &why);
        if (!s)
            s = sheen_cli_run_stages(b->cli, path, &o, &why);
        sheen_json_close(&b->cli->out);
        snprintf(b->standings[i].model, sizeof b->standings[i].model, "%.199s", s ? why.msg : "made");
        if (s)
            sheen_cli_warn(b->cli, "'%s' is recorded, but no model was made: %s", b->items.items[i].name,
                           why.msg);
    }
    sheen_json_close(&b->cli->out);
}

// What is to be done about an object; "": nothing.
static void remedy(char text[300], const batch *b, size_t i)
{
    const standing *st = &b->standings[i];
    const size_t n_all = (size_t)b->args->n_steps * (size_t)b->args->n_rounds;
    *text = '\0';
    if (st->n_missing == n_all)
        snprintf(text, 300, "not begun%s%s", *st->failed ? ": " : "", st->failed);
    else if (st->n_missing)
        snprintf(text, 300, "%zu of %zu frames missing%s%s", st->n_missing, n_all, *st->failed ? ": " : "",
                 st->failed);
    else if (st->n_unseen)
        snprintf(text, 300, "in %zu of %zu frames the tags could not be seen: look whether they matter",
                 st->n_unseen, n_all);
    else if (*st->model && strcmp(st->model, "made") != 0)
        snprintf(text, 300, "no model: %s", st->model);
}

// Says what is to be done again, and writes it into the folder.
static sheen_status sum_up(batch *b, sheen_err *err)
{
    char path[SHEEN_PATH_MAX], what[300];
    sheen_json_writer w = {0};
    size_t n_again = 0;
    sheen_json_open(&w, NULL, '{');
    sheen_json_put_string(&w, "schema", "sheen-batch/1");
    sheen_json_open(&w, "objects", '[');
    for (size_t i = 0; i < b->items.n; i++) {
        const standing *st = &b->standings[i];
        remedy(what, b, i);
        n_again += *what != '\0';
        sheen_json_open(&w, NULL, '{');
        sheen_json_put_string(&w, "name", b->items.items[i].name);
        sheen_json_put_string(&w, "code", *b->items.items[i].code ? b->items.items[i].code : NULL);
        sheen_json_put_int(&w, "missing_frames", (long long)st->n_missing);
        sheen_json_put_int(&w, "unseen_frames", (long long)st->n_unseen);
        sheen_json_put_string(&w, "model", *st->model ? st->model : NULL);
        sheen_json_put_string(&w, "remedy", *what ? what : NULL);
        sheen_json_close(&w);
        if (*what)
            sheen_cli_say(b->cli, "%s%-24s %s", n_again == 1 ? "\nto be looked at:\n" : "",
                          b->items.items[i].name, what);
    }
    sheen_json_close(&w);
    sheen_json_close(&w);
    const size_t n_complete = count_complete(b);
    sheen_cli_say(b->cli, "\n%zu of %zu objects are complete%s", n_complete, b->items.n,
                  n_complete < b->items.n ? "; the same command goes on with the others" : "");
    sheen_json_put_int(&b->cli->out, "objects", (long long)b->items.n);
    sheen_json_put_int(&b->cli->out, "complete", (long long)n_complete);
    sheen_json_put_int(&b->cli->out, "to_be_looked_at", (long long)n_again);
    b->cli->limit_missed = b->cli->limit_missed || n_again;
    const sheen_status s = sheen_path_join(path, b->folder, BATCH_FILE, err);
    if (!s)
        return sheen_json_save(&w, path, err);
    sheen_json_writer_release(&w);
    return s;
}

sheen_status sheen_cli_capture_batch(sheen_cli *cli, sheen_cli_capture *a, const char *folder, sheen_err *err)
{
    batch b = {.cli = cli, .args = a, .folder = folder};
    sheen_status s = sheen_cli_items_load(&b.items, a->batch, err);
    b.any_code = !b.items.n;
    if (!s)
        s = sheen_dir_make(folder, err);
    if (!s)
        s = look_up_all(&b, err);
    if (!s && !(s = capture_all(&b, err)) && a->then_run)
        run_all(&b);
    if (!s)
        s = sum_up(&b, err);
    if (!s && sheen_cli_interrupted())
        s = sheen_fail(err, SHEEN_ECANCEL, "the batch was ended; the same command goes on from there");
    sheen_cli_items_release(&b.items);
    free(b.standings);
    return s;
}
