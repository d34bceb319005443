// SPDX-License-Identifier: Apache-2.0
// parallel.h - data-parallel loops. The only place that starts worker threads.
#ifndef SHEEN_BASE_PARALLEL_H
#define SHEEN_BASE_PARALLEL_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

// Number of processors that this process may use, at least 1.
int sheen_cpu_count(void);

// Calls body(self, begin, end) over [0, n) in pieces of at most `grain`, from n_threads
// threads (0: one per processor), and returns when all are done. Pieces are handed out in
// order but may end in any order: a body writes only to places that belong to its indices,
// so that results do not depend on the number of threads. Where threads cannot be started
// the calling thread does the work.
void sheen_parallel_for(size_t n, size_t grain, int n_threads,
                        void (*body)(void *self, size_t begin, size_t end), void *self);

#ifdef __cplusplus
}
#endif
#endif
