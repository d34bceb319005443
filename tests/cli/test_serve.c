// SPDX-License-Identifier: Apache-2.0
// test_serve.c - what the server of pages answers, and to whom: by requests as a browser, a page of somebody else's, or a
// program that guesses would send them.
#include "cli/serve.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/support.h"

typedef struct site {
    sheen_server *server;
    int port, n_asked;
    const char *secret; // and what follows it in the address
    char asked[200];
} site;

static void answer_what(void *self, const char *what, sheen_answer *answer)
{
    site *s = self;
    s->n_asked++;
    snprintf(s->asked, sizeof s->asked, "%s", what);
    if (strcmp(what, "") != 0 && strcmp(what, "model.json") != 0)
        return;
    answer->data = strdup("<p>sheen</p>");
    answer->size_bytes = 12;
    answer->type = "text/html";
}

static void open_site(site *s)
{
    sheen_err err;
    *s = (site){0};
    assert_ok(sheen_server_open(&s->server, 0, answer_what, s, &err), err);
    const char *address = sheen_server_address(s->server);
    assert_int_equal(sscanf(address, "http://127.0.0.1:%d/", &s->port), 1);
    s->secret = strchr(address + strlen("http://"), '/') + 1;
}

static int connect_to(const site *s)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons((uint16_t)s->port)};
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    assert_true(fd >= 0);
    assert_return_code(connect(fd, (struct sockaddr *)&at, sizeof at), 0);
    return fd;
}

// The whole answer; the server closes the connection where the request says so, or where it does not like it.
static int ask_raw(site *s, const char *request, char *reply, size_t reply_bytes)
{
    const int fd = connect_to(s);
    size_t n = 0;
    int code = 0;
    bool open = true;
    assert_int_equal(send(fd, request, strlen(request), MSG_NOSIGNAL), (ssize_t)strlen(request));
    for (int i = 0; i < 200 && open; i++) {
        sheen_server_wait(s->server, 10);
        ssize_t got;
        while ((got = recv(fd, reply + n, reply_bytes - 1 - n, MSG_DONTWAIT)) > 0)
            n += (size_t)got;
        open = got != 0;
    }
    close(fd);
    reply[n] = 0;
    assert_false(open);
    assert_int_equal(sscanf(reply, "HTTP/1.%*d %d", &code), 1);
    return code;
}

static int ask(site *s, const char *method, const char *path, const char *host)
{
    char request[4400], reply[4096];
    snprintf(request, sizeof request, "%s /%s HTTP/1.1\r\n%s%s%sConnection: close\r\n\r\n", method, path,
             host ? "Host: " : "", host ? host : "", host ? "\r\n" : "");
    return ask_raw(s, request, reply, sizeof reply);
}

static void whoever_has_the_address_gets_the_page(void **state)
{
    (void)state;
    site s;
    char request[300], reply[4096], path[128], host[40];
    open_site(&s);
    assert_int_equal(strlen(s.secret), 33); // 128 bits, and a slash
    snprintf(request, sizeof request, "GET /%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n\r\n",
             s.secret, s.port);
    assert_int_equal(ask_raw(&s, request, reply, sizeof reply), 200);
    assert_non_null(strstr(reply, "\r\n\r\n<p>sheen</p>"));
    assert_non_null(strstr(reply, "Content-Type: text/html"));
    // Nobody else may use, frame or keep it.
    assert_non_null(strstr(reply, "Cross-Origin-Resource-Policy: same-origin"));
    assert_non_null(strstr(reply, "X-Frame-Options: DENY"));
    assert_non_null(strstr(reply, "Cache-Control: no-store"));
    assert_null(strstr(reply, "Access-Control-Allow-Origin"));
    snprintf(host, sizeof host, "localhost:%d", s.port);
    snprintf(path, sizeof path, "%smodel.json", s.secret);
    assert_int_equal(ask(&s, "GET", path, host), 200);
    assert_string_equal(s.asked, "model.json");
    assert_int_equal(ask(&s, "HEAD", path, host), 200);
    snprintf(path, sizeof path, "%sother", s.secret);
    assert_int_equal(ask(&s, "GET", path, host), 404);
    sheen_server_close(&s.server);
    assert_null(s.server);
}

static void nobody_else_is_answered(void **state)
{
    (void)state;
    static const char *const methods[] = {"POST", "PUT", "DELETE", "OPTIONS"};
    site s;
    char path[128], host[40], wrong[40];
    open_site(&s);
    snprintf(host, sizeof host, "127.0.0.1:%d", s.port);
    snprintf(path, sizeof path, "%s", s.secret);
    // A name that was pointed here, another port, no name at all.
    snprintf(wrong, sizeof wrong, "evil.example:%d", s.port);
    assert_int_equal(ask(&s, "GET", path, wrong), 403);
    snprintf(wrong, sizeof wrong, "127.0.0.1:%d", s.port ^ 1);
    assert_int_equal(ask(&s, "GET", path, wrong), 403);
    assert_int_equal(ask(&s, "GET", path, "127.0.0.1"), 403);
    assert_true(ask(&s, "GET", path, NULL) >= 400);
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
        assert_int_equal(ask(&s, methods[i], path, host), 405);
    // Without the secret, with a part of it, with another one.
    assert_int_equal(ask(&s, "GET", "", host), 404);
    assert_int_equal(ask(&s, "GET", "model.json", host), 404);
    path[31] = 0;
    assert_int_equal(ask(&s, "GET", path, host), 404);
    snprintf(path, sizeof path, "%s", s.secret);
    path[0] = path[0] == 'a' ? 'b' : 'a';
    assert_int_equal(ask(&s, "GET", path, host), 404);
    assert_int_equal(s.n_asked, 0);
    sheen_server_close(&s.server);
}

// There are no files: a path that climbs is a name like any other, which nobody knows.
static void a_path_leads_nowhere(void **state)
{
    (void)state;
    static const char *const paths[] = {"../etc/passwd",     "..%2f..%2fetc%2fpasswd", "/etc/passwd", "%00",
                                        "model.json%00.png", "model.json/..",          "?q=../x"};
    site s;
    char path[200], host[40];
    open_site(&s);
    snprintf(host, sizeof host, "127.0.0.1:%d", s.port);
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        snprintf(path, sizeof path, "%s%s", s.secret, paths[i]);
        const int code = ask(&s, "GET", path, host);
        // Behind a question mark, or a NUL, it is the same page's address
        assert_int_equal(code, strstr(paths[i], "?") || strstr(paths[i], "%00") ? 200 : 404);
    }
    sheen_server_close(&s.server);
}

static void what_is_no_request_ends_without_harm(void **state)
{
    (void)state;
    static const char *const requests[] = {"\r\n\r\n\r\n", "GET\r\n\r\n",
                                           "GET / HTTP/9.9\r\nConnection: close\r\n\r\n",
                                           "GET / HTTP/1.1\r\nHost\r\n\r\n"};
    site s;
    char reply[4096], long_path[4000], host[40];
    open_site(&s);
    for (size_t i = 0; i < sizeof requests / sizeof *requests; i++) {
        const int fd = connect_to(&s);
        assert_true(send(fd, requests[i], strlen(requests[i]), MSG_NOSIGNAL) > 0);
        for (int k = 0; k < 5; k++)
            sheen_server_wait(s.server, 5);
        (void)recv(fd, reply, sizeof reply, MSG_DONTWAIT);
        close(fd); // in the middle of whatever it was
    }
    memset(long_path, 'a', sizeof long_path - 1);
    long_path[500] = 0;
    snprintf(host, sizeof host, "127.0.0.1:%d", s.port);
    assert_int_equal(ask(&s, "GET", long_path, host), 404);
    assert_int_equal(ask(&s, "GET", s.secret, host), 200);
    sheen_server_close(&s.server);
}

static void a_port_that_is_taken_is_said(void **state)
{
    (void)state;
    site s;
    sheen_server *other;
    sheen_err err;
    open_site(&s);
    assert_fails(sheen_server_open(&other, s.port, answer_what, &s, &err), err, SHEEN_EIO, "is it taken?");
    assert_null(other);
    sheen_server_close(&s.server);
}

static void two_servers_have_two_secrets(void **state)
{
    (void)state;
    site a, b;
    char path[64], host[40];
    open_site(&a);
    open_site(&b);
    assert_string_not_equal(a.secret, b.secret);
    snprintf(path, sizeof path, "%s", a.secret);
    snprintf(host, sizeof host, "127.0.0.1:%d", b.port);
    assert_int_equal(ask(&b, "GET", path, host), 404);
    sheen_server_close(&a.server);
    sheen_server_close(&b.server);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whoever_has_the_address_gets_the_page),
        cmocka_unit_test(nobody_else_is_answered),
        cmocka_unit_test(a_path_leads_nowhere),
        cmocka_unit_test(what_is_no_request_ends_without_harm),
        cmocka_unit_test(a_port_that_is_taken_is_said),
        cmocka_unit_test(two_servers_have_two_secrets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
