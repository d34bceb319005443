// SPDX-License-Identifier: Apache-2.0
// analyzer.h - what clang's analyzer cannot see from one source file alone; tools/lint includes it before all else.
//
// sheen_fail and its kin return the code that they are given. Without that knowledge the analyzer believes that
// every failure may go on as a success, with outputs that nobody has set.
#ifndef SHEEN_TOOLS_ANALYZER_H
#define SHEEN_TOOLS_ANALYZER_H

#include "base/status.h"

#define sheen_fail(err, code, ...) (sheen_fail(err, code, __VA_ARGS__), (code))
#define sheen_wrap(err, code, ...) (sheen_wrap(err, code, __VA_ARGS__), (code))
#define sheen_fail_memory(err, size_bytes, what) (sheen_fail_memory(err, size_bytes, what), SHEEN_ENOMEM)

#endif
