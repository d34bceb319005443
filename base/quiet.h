// SPDX-License-Identifier: Apache-2.0
// quiet.h - keeps a library's own chatter off the person's screen.
//
// mrcal, CHOLMOD and OpenCV write to the standard error stream with no switch to stop them. Between begin and
// end what is written to it goes nowhere. The stream belongs to the whole process, so keep the span short: one
// library call. Spans from several threads wait for each other.
#ifndef SHEEN_BASE_QUIET_H
#define SHEEN_BASE_QUIET_H

#ifdef __cplusplus
extern "C" {
#endif

// Returns a token for end; a stream that cannot be redirected stays as it is.
int sheen_quiet_begin(void);
void sheen_quiet_end(int token);

#ifdef __cplusplus
}
#endif
#endif
