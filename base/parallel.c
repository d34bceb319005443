// SPDX-License-Identifier: Apache-2.0
// parallel.c - data-parallel loops over POSIX threads, with a shared counter of pieces.
#define _GNU_SOURCE // sched_getaffinity
#include "base/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

enum { MAX_THREADS = 64 };

int sheen_cpu_count(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set))
        return 1;
    const int n = CPU_COUNT(&set);
    return n < 1 ? 1 : n > MAX_THREADS ? MAX_THREADS : n;
}

typedef struct loop {
    size_t n, grain;
    atomic_size_t next;
    void (*body)(void *self, size_t begin, size_t end);
    void *self;
} loop;

static void *work(void *arg)
{
    loop *l = arg;
    for (;;) {
        const size_t begin = atomic_fetch_add(&l->next, l->grain);
        if (begin >= l->n)
            return NULL;
        const size_t end = l->n - begin < l->grain ? l->n : begin + l->grain;
        l->body(l->self, begin, end);
    }
}

void sheen_parallel_for(size_t n, size_t grain, int n_threads,
                        void (*body)(void *self, size_t begin, size_t end), void *self)
{
    loop l = {.n = n, .grain = grain ? grain : 1, .body = body, .self = self};
    atomic_init(&l.next, 0);
    if (n_threads <= 0)
        n_threads = sheen_cpu_count();
    if (n_threads > MAX_THREADS)
        n_threads = MAX_THREADS;
    const size_t n_pieces = (n + l.grain - 1) / l.grain;
    if ((size_t)n_threads > n_pieces)
        n_threads = (int)n_pieces;

    pthread_t threads[MAX_THREADS];
    int n_started = 0;
    while (n_started < n_threads - 1 && !pthread_create(&threads[n_started], NULL, work, &l))
        n_started++;
    work(&l);
    for (int i = 0; i < n_started; i++)
        pthread_join(threads[i], NULL);
}
