// SPDX-License-Identifier: Apache-2.0
// fuzz.h - libFuzzer's entry point, which no header of its own declares; the build includes this in every target.
#ifndef SHEEN_TESTS_FUZZ_FUZZ_H
#define SHEEN_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
#else
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
#endif

#endif
