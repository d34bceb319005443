// SPDX-License-Identifier: Apache-2.0
// cpu_level.h - which of the instruction sets that kernels are compiled for this processor has.
#ifndef SHEEN_BASE_CPU_LEVEL_H
#define SHEEN_BASE_CPU_LEVEL_H

#ifdef __cplusplus
extern "C" {
#endif

// 0: what every x86-64 has, or another processor; 1: AVX2 and FMA; 2: AVX-512 F, VL, DQ, BW.
enum { SHEEN_CPU_BASELINE, SHEEN_CPU_AVX2, SHEEN_CPU_AVX512 };
int sheen_cpu_level(void);

// Marks a function that is compiled once a level: the body is an always inlined function that these call.
#define SHEEN_KERNEL_INLINE static inline __attribute__((always_inline))
#if defined(__x86_64__)
#define SHEEN_TARGET_AVX2 __attribute__((target("avx2,fma")))
#define SHEEN_TARGET_AVX512 __attribute__((target("avx512f,avx512vl,avx512dq,avx512bw,fma")))
#endif

#ifdef __cplusplus
}
#endif
#endif
