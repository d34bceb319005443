// SPDX-License-Identifier: Apache-2.0
// order.h - orders for qsort.
#ifndef SHEEN_BASE_ORDER_H
#define SHEEN_BASE_ORDER_H

#ifdef __cplusplus
extern "C" {
#endif

// a, b: const double *, neither of them NaN; the smaller first.
static inline int sheen_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

#ifdef __cplusplus
}
#endif
#endif
