// SPDX-License-Identifier: Apache-2.0
// serve.h - a web server for this machine alone: loopback, a secret in every address, GET and HEAD only.
//
// It has no files: what it answers is asked of a callback by name, so no path can lead out of anything.
#ifndef SHEEN_CLI_SERVE_H
#define SHEEN_CLI_SERVE_H

#include <stddef.h>

#include "base/status.h"

typedef struct sheen_server sheen_server;

typedef struct sheen_answer {
    void *data; // malloc'd by the callback; the server frees it. NULL: there is no such thing
    size_t size_bytes;
    const char *type; // MIME
} sheen_answer;

// An answer of a text, copied; none where there is no memory for it.
void sheen_answer_text(sheen_answer *to, const char *type, const char *text);

// what: the part of the address after the secret, "" for the page itself. Runs within sheen_server_wait.
typedef void (*sheen_answering)(void *self, const char *what, sheen_answer *answer);

// port 0: any that is free. EIO: the port is taken, or there is no loopback.
sheen_status sheen_server_open(sheen_server **out, int port, sheen_answering answering, void *self,
                               sheen_err *err);
// Answers what comes within timeout_ms, on the calling thread.
void sheen_server_wait(sheen_server *server, int timeout_ms);
const char *sheen_server_address(const sheen_server *server); // "http://127.0.0.1:PORT/SECRET/"
void sheen_server_close(sheen_server **server);

#endif
