// SPDX-License-Identifier: Apache-2.0
// quiet.c - redirects file descriptor 2 for the length of one library call.
#define _GNU_SOURCE // dup3
#include "base/quiet.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>

static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;

int sheen_quiet_begin(void)
{
    pthread_mutex_lock(&one_at_a_time);
    fflush(stderr);
    const int saved = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    const int nowhere = saved >= 0 ? open("/dev/null", O_WRONLY | O_CLOEXEC) : -1;
    if (nowhere >= 0) {
        dup2(nowhere, STDERR_FILENO);
        close(nowhere);
    }
    return saved;
}

void sheen_quiet_end(int token)
{
    if (token >= 0) {
        fflush(stderr);
        dup2(token, STDERR_FILENO);
        close(token);
    }
    pthread_mutex_unlock(&one_at_a_time);
}
