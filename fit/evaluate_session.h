// SPDX-License-Identifier: Apache-2.0
// evaluate_session.h - scoring a session's model: on its test frames, on left-out input frames, or on other pictures.
#ifndef SHEEN_FIT_EVALUATE_SESSION_H
#define SHEEN_FIT_EVALUATE_SESSION_H

#include "fit/evaluate.h"
#include "fit/method.h"

typedef struct sheen_evaluate_session_options {
    sheen_fit_method method; // for folds
    sheen_paper_options fit; // for folds; its n_threads and progress hold for all
    int n_folds; // > 0: that many fits, each without every n_folds-th input frame, scored on those
    const char *against_dir; // pictures to score on, <name>.<png|jpg|tif|exr>, posed by
    const char *poses_path;  // this file (base/pose_file.h); poses in the board's frame
    sheen_transfer transfer; // of those pictures
} sheen_evaluate_session_options;

// Without folds and folder: the session's test frames, by its own camera and poses. Highlight masks are taken from
// highlights/<name>.png of the session (or of against_dir) where they exist.
// Writes evaluation/evaluation.json, evaluation/evaluation.md (the table) and evaluation/<view>.png (photograph, render, their difference
// times 4, minimum texture, median texture, side by side) in one step. EDATA: nothing to score on, or no model yet.
sheen_status sheen_evaluate_session(sheen_evaluation *out, const sheen_session *s,
                                    const sheen_evaluate_session_options *options, sheen_err *err);

// True where evaluation/ was made from the session's present model and test frames.
bool sheen_evaluation_is_current(const sheen_session *s);

// The table as text, in Markdown: a row a method, means over the views. Caller frees. NULL: out of memory.
char *sheen_evaluation_table(const sheen_evaluation *e);
// The same with every view, as members of an open JSON object.
void sheen_evaluation_write(const sheen_evaluation *e, sheen_json_writer *w);

#endif
