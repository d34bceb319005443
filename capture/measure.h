// SPDX-License-Identifier: Apache-2.0
// measure.h - a camera measured: its dark frames, its flat field, its response curve, into a session.
#ifndef SHEEN_CAPTURE_MEASURE_H
#define SHEEN_CAPTURE_MEASURE_H

#include "base/radiometry.h"
#include "capture/record.h"

typedef struct sheen_measure_report {
    int n_frames;                      // averaged
    double level;                      // mean code, of full scale
    size_t n_hot;                      // dark: pixels that stand out of the others
    double darkest;                    // flat: the darkest hundredth of the picture, of the brightest
    double residual, residual_claimed; // response (response_fit.h)
    int n_exposures;
    double exposure_s[SHEEN_BRACKET_MAX];
} sheen_measure_report;

// Averages n_frames frames of a camera under its lock, of which nothing but the lens cap (dark) or an even white (flat) is
// in view, and stores them. `o`: patience, notices, progress. EUNSUP (not locked), EDATA (light where there must be none,
// none where there must be, saturation, unevenness), and what the source reports.
sheen_status sheen_measure_field(sheen_measure_report *report, const sheen_session *s, sheen_source *src,
                                 sheen_measure kind, int n_frames, const sheen_record_options *o,
                                 sheen_err *err);

// Dark frames for each exposure of a bracket of n_exposures (bracket.h).
sheen_status sheen_measure_bracket_dark(sheen_measure_report *report, const sheen_session *s,
                                        sheen_source *src, int n_exposures, int n_frames,
                                        const sheen_record_options *o, sheen_err *err);

// The response curve, from a bracket of a scene that stands still; stored with its residual. EUNSUP where the exposure
// cannot be set or the format is a mosaic (which is linear), EDATA.
sheen_status sheen_measure_response(sheen_measure_report *report, const sheen_session *s, sheen_source *src,
                                    const sheen_record_options *o, sheen_err *err);

#endif
