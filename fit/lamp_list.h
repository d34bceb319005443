// SPDX-License-Identifier: Apache-2.0
// lamp_list.h - how many lamps there are: added one at a time, each kept where the photographs agree that it is there.
#ifndef SHEEN_FIT_LAMP_LIST_H
#define SHEEN_FIT_LAMP_LIST_H

#include "base/progress.h"
#include "fit/lamp_proof.h"

typedef struct sheen_lamp_list {
    sheen_lamp lamps[SHEEN_LAMP_FIT_MAX];
    size_t n;
    sheen_lobe_shape lobe;
    double scale;     // of the residuals of lit samples
    double cost;      // E over all samples
    double dark_cost; // E of no lamps at all, at the same scale
    int converged;    // of the last refinement of all
} sheen_lamp_list;

typedef struct sheen_lamp_list_options {
    float threshold_lin;
    size_t max_lamps;
    int find;                      // look for more lamps; else those there are, are refined
    int last;                      // refine until nothing changes
    const sheen_lamp_proof *proof; // NULL: residuals alone decide
    sheen_lamp_fit_options fit;
    sheen_progress progress;
} sheen_lamp_list_options;

// Improves *list in place; list->lobe is where the lobe starts (for an empty list sigma above the truth).
//
// A candidate (lamp_start.h) is refined alone, then with all others, and stays where E falls by more than its parameters are worth
// (half of their number times log of the samples), where more views get better by it than get worse (a light that one photograph
// asks for and another denies is none), and where, with the texture estimated anew, it explains a fifth of what photographs left out are
// wrong by in its light (lamp_proof.h). The residuals' scale comes from lit samples and falls as lamps are found, so that faint
// lamps follow bright ones. At the end two neighbours become one, and a lamp goes, where E hardly rises by it or where it explains
// too little given all others. ENOMEM, ECANCEL.
sheen_status sheen_lamp_list_fit(sheen_lamp_list *list, const sheen_lamp_samples *samples,
                                 const sheen_lamp_list_options *options, sheen_err *err);

#endif
