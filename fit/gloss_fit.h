// SPDX-License-Identifier: Apache-2.0
// gloss_fit.h - k_S by region: which colours of texture shine more than others, told from highlights that cross them.
#ifndef SHEEN_FIT_GLOSS_FIT_H
#define SHEEN_FIT_GLOSS_FIT_H

#include <stdbool.h>

#include "fit/lamp_samples.h"

// Colours are clustered (the widest cluster is cut in two, then all are settled by Lloyd's iteration) and each cluster's share is
// found under the Lorentzian, given what the lamps would add for a gloss of 1: predicted[count]. The number of clusters is that
// with which half of the photographs predict the other half best; each step up must be better by 3 %, where the object turned the first by 20 %; else *out has n = 0.
// The largest share for which there is good evidence is 1; *strength is what the lamps are to be multiplied by for that.
// scale: of the residuals. The samples' own gloss plays no part. ENOMEM.
sheen_status sheen_gloss_fit(sheen_gloss *out, double *strength, const sheen_lamp_samples *samples,
                             const float *predicted, double scale, bool turned, sheen_err *err);

#endif
