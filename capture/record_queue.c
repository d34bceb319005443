// SPDX-License-Identifier: Apache-2.0
// record_queue.c - a list of jobs, oldest first: those before `next` are written and wait to be collected, `next` and
// what follows wait to be written. One mutex guards the list; the jobs' bytes belong to whoever the list says.
#include "capture/record_queue.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct job {
    struct job *after;
    sheen_frame_info info;
    char extension[12];
    uint8_t *payload, *mask; // in one block with the job
    size_t payload_bytes, mask_bytes;
    sheen_status status;
    sheen_err err;
} job;

struct sheen_record_queue {
    const sheen_session *session;
    sheen_record_write *write;
    void *write_self;
    size_t limit_bytes;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t pushed, written;
    // Under the mutex:
    job *first, *last, *next;
    size_t n_bytes; // of jobs that are not yet written
    bool closing, failed;
    // The recorder's own:
    size_t n_jobs;
};

enum { DEFAULT_LIMIT_BYTES = 64 << 20 };

// The mask goes first: once the frame counts, its mask is there.
static sheen_status write_job(sheen_record_queue *q, job *j)
{
    if (j->mask_bytes) {
        const sheen_status s = sheen_session_add_mask(q->session, SHEEN_SESSION_MASKS, j->info.name, j->mask,
                                                      j->mask_bytes, &j->err);
        if (s)
            return s;
    }
    return q->write ? q->write(q->write_self, q->session, &j->info, j->extension, j->payload,
                               j->payload_bytes, &j->err)
                    : sheen_session_write_frame(q->session, &j->info, j->extension, j->payload,
                                                j->payload_bytes, &j->err);
}

static void *run(void *self)
{
    sheen_record_queue *q = self;
    pthread_mutex_lock(&q->mutex);
    for (;;) {
        while (!q->next && !q->closing)
            pthread_cond_wait(&q->pushed, &q->mutex);
        job *j = q->next;
        if (!j)
            break;
        if (q->failed)
            j->status = sheen_fail(&j->err, SHEEN_EIO, "not tried: a frame before it could not be written");
        else {
            pthread_mutex_unlock(&q->mutex);
            j->status = write_job(q, j);
            pthread_mutex_lock(&q->mutex);
        }
        q->failed = q->failed || j->status;
        q->next = j->after;
        q->n_bytes -= j->payload_bytes + j->mask_bytes;
        pthread_cond_signal(&q->written);
    }
    pthread_mutex_unlock(&q->mutex);
    return NULL;
}

static void init_locks(sheen_record_queue *q)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&q->mutex, NULL);
    pthread_cond_init(&q->pushed, NULL);
    pthread_cond_init(&q->written, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

static void release(sheen_record_queue *q)
{
    for (job *j = q->first, *after; j; j = after) {
        after = j->after;
        free(j);
    }
    pthread_cond_destroy(&q->written);
    pthread_cond_destroy(&q->pushed);
    pthread_mutex_destroy(&q->mutex);
    free(q);
}

sheen_status sheen_record_queue_open(sheen_record_queue **out, const sheen_session *session,
                                     const sheen_record_options *options, sheen_err *err)
{
    sheen_record_queue *q = calloc(1, sizeof *q);
    *out = NULL;
    if (!q)
        return sheen_fail_memory(err, sizeof *q, "the recorder");
    q->session = session;
    q->write = options->write;
    q->write_self = options->write_self;
    q->limit_bytes = options->queue_bytes ? options->queue_bytes : DEFAULT_LIMIT_BYTES;
    init_locks(q);
    if (pthread_create(&q->thread, NULL, run, q)) {
        release(q);
        return sheen_fail(err, SHEEN_ENOMEM, "no thread can be had for writing frames: close other programs");
    }
    *out = q;
    return SHEEN_OK;
}

void sheen_record_queue_close(sheen_record_queue **queue)
{
    sheen_record_queue *q = *queue;
    if (!q)
        return;
    pthread_mutex_lock(&q->mutex);
    q->closing = true;
    pthread_cond_signal(&q->pushed);
    pthread_mutex_unlock(&q->mutex);
    pthread_join(q->thread, NULL);
    release(q);
    *queue = NULL;
}

static struct timespec after_ms(int timeout_ms)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    const int64_t ns = t.tv_nsec + (int64_t)timeout_ms * 1000000;
    return (struct timespec){t.tv_sec + (time_t)(ns / 1000000000), (long)(ns % 1000000000)};
}

bool sheen_record_queue_wait_room(sheen_record_queue *q, size_t size_bytes, int timeout_ms)
{
    const struct timespec until = after_ms(timeout_ms);
    pthread_mutex_lock(&q->mutex);
    bool room;
    do
        room = !q->n_bytes || q->n_bytes + size_bytes <= q->limit_bytes;
    while (!room && timeout_ms && !pthread_cond_timedwait(&q->written, &q->mutex, &until));
    pthread_mutex_unlock(&q->mutex);
    return room;
}

sheen_status sheen_record_queue_push(sheen_record_queue *q, const sheen_frame *frame, sheen_err *err)
{
    const size_t n_mask = frame->mask ? frame->mask_bytes : 0;
    job *j = malloc(sizeof *j + frame->size_bytes + n_mask);
    if (!j)
        return sheen_fail_memory(err, (double)frame->size_bytes + (double)n_mask, "a frame");
    *j = (job){.info = frame->info, .payload_bytes = frame->size_bytes, .mask_bytes = n_mask};
    j->payload = (uint8_t *)(j + 1);
    j->mask = j->payload + frame->size_bytes;
    if (frame->size_bytes)
        memcpy(j->payload, frame->data, frame->size_bytes);
    if (n_mask)
        memcpy(j->mask, frame->mask, n_mask);
    snprintf(j->extension, sizeof j->extension, "%s", frame->extension);
    pthread_mutex_lock(&q->mutex);
    if (q->last)
        q->last->after = j;
    else
        q->first = j;
    q->last = j;
    if (!q->next)
        q->next = j;
    q->n_bytes += j->payload_bytes + j->mask_bytes;
    pthread_cond_signal(&q->pushed);
    pthread_mutex_unlock(&q->mutex);
    q->n_jobs++;
    return SHEEN_OK;
}

sheen_status sheen_record_queue_collect(sheen_record_queue *q, sheen_frame_info *info, int timeout_ms,
                                        sheen_err *err)
{
    const struct timespec until = after_ms(timeout_ms);
    if (!q->n_jobs)
        return SHEEN_ETIMEOUT;
    pthread_mutex_lock(&q->mutex);
    while (q->first == q->next && timeout_ms && !pthread_cond_timedwait(&q->written, &q->mutex, &until))
        ;
    job *j = q->first == q->next ? NULL : q->first;
    if (j) {
        q->first = j->after;
        q->last = q->first ? q->last : NULL;
    }
    pthread_mutex_unlock(&q->mutex);
    if (!j)
        return SHEEN_ETIMEOUT;
    const sheen_status s = j->status;
    *info = j->info;
    if (s && err)
        *err = j->err;
    free(j);
    q->n_jobs--;
    return s;
}

size_t sheen_record_queue_count(const sheen_record_queue *q)
{
    return q->n_jobs;
}
