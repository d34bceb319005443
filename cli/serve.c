// SPDX-License-Identifier: Apache-2.0
// serve.c - the one door to libmicrohttpd.
//
// A page of another origin may send requests here, and a name of its own may be pointed at 127.0.0.1; so the Host header
// must be ours, and the address must hold a secret that is new in each run. Answers may be used by no other origin.
#include "cli/serve.h"

#include <arpa/inet.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>

enum { SECRET_BYTES = 16, MAX_CONNECTIONS = 32, IDLE_S = 30 };

struct sheen_server {
    struct MHD_Daemon *daemon;
    sheen_answering answering;
    void *self;
    int port;
    char secret[2 * SECRET_BYTES + 1], address[96];
};

static enum MHD_Result reply(struct MHD_Connection *connection, unsigned status, const char *type, void *data,
                             size_t size_bytes, enum MHD_ResponseMemoryMode memory)
{
    static const char *const headers[][2] = {
        {"Cache-Control", "no-store"},
        {"Referrer-Policy", "no-referrer"},
        {"X-Content-Type-Options", "nosniff"},
        {"X-Frame-Options", "DENY"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"Cross-Origin-Opener-Policy", "same-origin"},
    };
    struct MHD_Response *response = MHD_create_response_from_buffer(size_bytes, data, memory);
    if (!response) {
        if (memory == MHD_RESPMEM_MUST_FREE)
            free(data);
        return MHD_NO;
    }
    MHD_add_response_header(response, "Content-Type", type);
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++)
        MHD_add_response_header(response, headers[i][0], headers[i][1]);
    const enum MHD_Result result = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return result;
}

static enum MHD_Result refuse(struct MHD_Connection *connection, unsigned status)
{
    static char text[] = "not here\n";
    return reply(connection, status, "text/plain", text, sizeof text - 1, MHD_RESPMEM_PERSISTENT);
}

static int is_ours(const sheen_server *s, const char *host)
{
    char want[64];
    if (!host)
        return 0;
    snprintf(want, sizeof want, "127.0.0.1:%d", s->port);
    if (!strcmp(host, want))
        return 1;
    snprintf(want, sizeof want, "localhost:%d", s->port);
    return !strcmp(host, want);
}

// "/SECRET/what" to what; NULL for anything else. All of the secret is compared, whatever its beginning.
static const char *what_of(const sheen_server *s, const char *url)
{
    const size_t n = sizeof s->secret - 1;
    if (strlen(url) < n + 2 || url[0] != '/' || url[n + 1] != '/')
        return NULL;
    unsigned differs = 0;
    for (size_t i = 0; i < n; i++)
        differs |= (unsigned)(url[1 + i] ^ s->secret[i]);
    return differs ? NULL : url + n + 2;
}

static enum MHD_Result on_request(void *self, struct MHD_Connection *connection, const char *url,
                                  const char *method, const char *version, const char *upload,
                                  size_t *upload_bytes, void **seen)
{
    sheen_server *s = self;
    (void)version;
    (void)upload;
    if (!*seen) { // headers only: the body, if any, is still to come
        *seen = s;
        return MHD_YES;
    }
    if (*upload_bytes) {
        *upload_bytes = 0;
        return MHD_YES;
    }
    if (!is_ours(s, MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Host")))
        return refuse(connection, MHD_HTTP_FORBIDDEN);
    if (strcmp(method, "GET") != 0 && strcmp(method, "HEAD") != 0)
        return refuse(connection, MHD_HTTP_METHOD_NOT_ALLOWED);
    const char *what = what_of(s, url);
    sheen_answer answer = {.type = "application/octet-stream"};
    if (what)
        s->answering(s->self, what, &answer);
    if (!answer.data)
        return refuse(connection, MHD_HTTP_NOT_FOUND);
    return reply(connection, MHD_HTTP_OK, answer.type, answer.data, answer.size_bytes, MHD_RESPMEM_MUST_FREE);
}

void sheen_answer_text(sheen_answer *to, const char *type, const char *text)
{
    to->size_bytes = strlen(text);
    to->data = malloc(to->size_bytes + 1);
    to->type = type;
    if (to->data)
        memcpy(to->data, text, to->size_bytes + 1);
}

static sheen_status make_secret(sheen_server *s, sheen_err *err)
{
    uint8_t bytes[SECRET_BYTES];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return sheen_fail(err, SHEEN_EIO, "the system gives no random numbers for a secret address");
    for (size_t i = 0; i < SECRET_BYTES; i++)
        snprintf(s->secret + 2 * i, 3, "%02x", bytes[i]);
    return SHEEN_OK;
}

sheen_status sheen_server_open(sheen_server **out, int port, sheen_answering answering, void *self,
                               sheen_err *err)
{
    struct sockaddr_in loopback = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    *out = NULL;
    sheen_server *s = calloc(1, sizeof *s);
    if (!s)
        return sheen_fail_memory(err, (double)sizeof *s, "a server");
    s->answering = answering;
    s->self = self;
    sheen_status st = make_secret(s, err);
    loopback.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (!st) {
        const union MHD_DaemonInfo *info;
        s->daemon = MHD_start_daemon(MHD_NO_FLAG, (uint16_t)port, NULL, NULL, on_request, s,
                                     MHD_OPTION_SOCK_ADDR, (struct sockaddr *)&loopback,
                                     MHD_OPTION_CONNECTION_LIMIT, (unsigned)MAX_CONNECTIONS,
                                     MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)IDLE_S, MHD_OPTION_END);
        info = s->daemon ? MHD_get_daemon_info(s->daemon, MHD_DAEMON_INFO_BIND_PORT) : NULL;
        if (info)
            s->port = info->port;
        else
            st = sheen_fail(err, SHEEN_EIO, "cannot serve on port %d of this machine; is it taken?", port);
    }
    if (st) {
        sheen_server_close(&s);
        return st;
    }
    snprintf(s->address, sizeof s->address, "http://127.0.0.1:%d/%s/", s->port, s->secret);
    *out = s;
    return SHEEN_OK;
}

void sheen_server_wait(sheen_server *s, int timeout_ms)
{
    MHD_run_wait(s->daemon, timeout_ms);
}

const char *sheen_server_address(const sheen_server *s)
{
    return s->address;
}

void sheen_server_close(sheen_server **s)
{
    if (!*s)
        return;
    if ((*s)->daemon)
        MHD_stop_daemon((*s)->daemon);
    free(*s);
    *s = NULL;
}
