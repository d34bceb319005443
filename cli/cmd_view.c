// SPDX-License-Identifier: Apache-2.0
// cmd_view.c - sheen view: the exported page, served on this machine, with the photographs; it follows the session.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "cli/commands.h"
#include "cli/export.h"
#include "cli/page_photos.h"
#include "cli/serve_here.h"
#include "cli/viewer_html.h"

enum { PHOTO_WIDTH_PX = 1600, QUANTIZER = 2 };

typedef struct viewing {
    const char *path; // of the session
    char state[128];  // of its model, as the page asks for it; "" where there is none
    char *page;       // made for that state
    size_t page_bytes;
    sheen_camera camera;
    sheen_page_photos photos;
    sheen_session session; // open where there is a page
    bool open;
    int n_threads;
} viewing;

static void forget(viewing *v)
{
    free(v->page);
    v->page = NULL;
    if (v->open) {
        sheen_page_photos_close(&v->photos);
        sheen_session_release(&v->session);
    }
    v->open = false;
}

// Which model stands in the session now.
static void look_at_model(char state[128], const char *session)
{
    char path[SHEEN_PATH_MAX];
    struct stat st;
    sheen_err ignored;
    state[0] = 0;
    if (!sheen_path_join(path, session, SHEEN_SESSION_MODEL "/model.json", &ignored) && !stat(path, &st))
        snprintf(state, 128, "%lld-%lld-%lld.%09ld", (long long)st.st_ino, (long long)st.st_size,
                 (long long)st.st_mtim.tv_sec, st.st_mtim.tv_nsec);
}

static sheen_status make_page(viewing *v, const sheen_cli_view *model, sheen_err *err)
{
    const sheen_page_options options = {.quantizer = QUANTIZER, .n_threads = v->n_threads};
    const sheen_export_args no_title = {.title = NULL};
    char title[256], *more = NULL;
    double look_deg[2];
    sheen_page page = {0};
    sheen_page_view view;
    sheen_export_page_view(&view, model);
    sheen_export_title(title, &no_title, &v->session);
    sheen_status st = sheen_export_first_view(look_deg, model, &v->session, err);
    if (!st)
        st = sheen_page_photos_open(&v->photos, &v->session, SHEEN_PAGE_MAX_PHOTOS, err);
    if (!st)
        st = sheen_page_more(&more, &v->photos, &v->session, model, look_deg, false, 0, err);
    if (!st)
        st = sheen_page_pack(&page, &model->model, &view, &options, err);
    if (!st) {
        const sheen_page_words words = {
            .title = title, .sources = " 'self'; connect-src 'self'", .more_json = more};
        st = sheen_page_html(&v->page, &v->page_bytes, &page, sheen_viewer_html, &words, err);
    }
    sheen_page_release(&page);
    free(more);
    return st;
}

static sheen_status load(viewing *v, sheen_err *err)
{
    sheen_cli_view model;
    sheen_status st = sheen_session_open(&v->session, v->path, err);
    if (st)
        return st;
    v->open = true;
    v->photos = (sheen_page_photos){.count = 0};
    st = sheen_cli_view_open(&model, &v->session, err);
    if (st)
        return st;
    v->camera = model.camera;
    st = make_page(v, &model, err);
    sheen_cli_view_close(&model);
    return st;
}

// A page that asks again every two seconds.
static void answer_waiting(sheen_answer *to, const char *why)
{
    char html[2048];
    char shown[1024];
    size_t n = 0;
    for (; *why && n < sizeof shown - 1; why++) // as text: nothing in it may become a tag
        shown[n++] = *why;
    for (size_t i = 0; i < n; i++)
        if (strchr("<>&", shown[i]))
            shown[i] = ' ';
    shown[n] = 0;
    snprintf(html, sizeof html,
             "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" "
             "content=\"2\"><link rel=\"icon\" href=\"data:,\"><title>sheen</title><style>body{font:16px "
             "system-ui,sans-serif;margin:3em auto;"
             "max-width:34em;color:#f2f2f2;background:#303030}</style></head><body><main><h1>Nothing to see "
             "yet</h1>"
             "<p>%s</p><p>This page shows the model as soon as there is one.</p></main></body></html>",
             shown);
    sheen_answer_text(to, "text/html; charset=utf-8", html);
}

static void answer_page(viewing *v, sheen_answer *to)
{
    char state[sizeof v->state];
    sheen_err err = {0};
    look_at_model(state, v->path);
    if (strcmp(state, v->state) != 0 || !v->page) {
        forget(v);
        memcpy(v->state, state, sizeof state);
        if (load(v, &err)) {
            forget(v);
            answer_waiting(to, err.msg);
            return;
        }
    }
    to->data = malloc(v->page_bytes);
    to->size_bytes = v->page_bytes;
    to->type = "text/html; charset=utf-8";
    if (to->data)
        memcpy(to->data, v->page, v->page_bytes);
}

static void answer_photo(const viewing *v, const char *number, sheen_answer *to)
{
    uint8_t *jpeg;
    sheen_err ignored;
    char *end;
    if (!v->open || *number < '0' || *number > '9' || strlen(number) > 4)
        return;
    const unsigned long i = strtoul(number, &end, 10);
    if (*end || i >= v->photos.count ||
        sheen_page_photo(&jpeg, &to->size_bytes, &v->photos, i, &v->session, &v->camera, PHOTO_WIDTH_PX,
                         &ignored))
        return;
    to->data = jpeg;
    to->type = "image/jpeg";
}

static void answer(void *self, const char *what, sheen_answer *to)
{
    viewing *v = self;
    if (!*what) {
        answer_page(v, to);
    } else if (!strcmp(what, "state")) {
        char state[sizeof v->state], json[sizeof v->state + 32];
        look_at_model(state, v->path);
        snprintf(json, sizeof json, "{\"changed\": %s}", strcmp(state, v->state) ? "true" : "false");
        sheen_answer_text(to, "application/json", json);
    } else if (!strncmp(what, "photo/", 6)) {
        answer_photo(v, what + 6, to);
    }
}

static sheen_status run(sheen_cli *cli, sheen_err *err)
{
    viewing v = {.open = false};
    sheen_serve_options o = {0};
    const sheen_option options[] = {
        {"port", 0, SHEEN_OPTION_INT, &o.port, "N", "of the address (default: any that is free)", 1, 65535},
        {"no-browser", 0, SHEEN_OPTION_FLAG, &o.stay, NULL, "only say the address", 0, 0},
        {"threads", 0, SHEEN_OPTION_INT, &v.n_threads, "N", "default: one a processor", 1, 1024},
        {0},
    };
    sheen_session s;
    sheen_status st = sheen_cli_parse(cli, options, 1, 1, err);
    if (st || cli->wants_help)
        return st;
    if ((st = sheen_session_open(&s, cli->args[0], err)))
        return st;
    sheen_session_release(&s);
    if (!sheen_viewer_html[0])
        return sheen_fail(err, SHEEN_EUNSUP,
                          "this build has no viewer to show; install nodejs and npm, and build again");
    v.path = cli->args[0];
    st = sheen_cli_serve(cli, answer, &v, &o, err);
    forget(&v);
    return st;
}

const sheen_command sheen_cmd_view = {
    .name = "view",
    .synopsis = "SESSION [options]",
    .summary = "the model in your browser, beside the photographs",
    .about = "Serves the page of `sheen export` on this machine alone, under an address that nobody else "
             "knows, and\n"
             "opens it. A session without a model is waited for; a new fit is shown when it is there.\n",
    .example = "  sheen view penguin.session\n",
    .run = run,
};
