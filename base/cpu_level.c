// SPDX-License-Identifier: Apache-2.0
// cpu_level.c - the processor's instruction set, by the compiler's own table.
#include "base/cpu_level.h"

int sheen_cpu_level(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw"))
        return SHEEN_CPU_AVX512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return SHEEN_CPU_AVX2;
#endif
    return SHEEN_CPU_BASELINE;
}
