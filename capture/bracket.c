// SPDX-License-Identifier: Apache-2.0
// bracket.c - exposes, waits for the picture to rest, takes a pair; for each exposure; and merges them.
#include "capture/bracket.h"

#include <math.h>
#include <stdlib.h>

#include "base/image_file.h"
#include "base/radiometry.h"
#include "capture/exposure_merge.h"

_Static_assert((int)SHEEN_MERGE_MAX == (int)SHEEN_BRACKET_MAX, "one limit");
static const double step = 4; // two stops

double sheen_bracket_factor(int i, int n)
{
    return pow(step, i - 0.5 * (n - 1));
}

static sheen_status take_picture(sheen_image *out, const sheen_session *session, sheen_ladder *ladder,
                                 sheen_err *err)
{
    sheen_frame frame;
    sheen_radiometry r;
    sheen_status s = sheen_ladder_next(ladder, &frame, err);
    if (!s)
        s = sheen_radiometry_load(&r, session, &frame.info, err);
    if (s)
        return s;
    sheen_image_release(&r.gain); // is applied to the sum when that is read
    s = sheen_radiometry_develop(out, &r, &frame.info, frame.data, frame.size_bytes, err);
    sheen_radiometry_release(&r);
    return s;
}

static sheen_status take_exposures(sheen_exposure *e, int n, const sheen_session *session,
                                   sheen_ladder *ladder, sheen_err *err)
{
    for (int i = 0; i < n; i++) {
        sheen_status s = sheen_source_expose(ladder->src, sheen_bracket_factor(i, n), &e[i].exposure_s, err);
        for (int k = 0; !s && k < 2; k++)
            s = take_picture(&e[i].pair[k], session, ladder, err);
        if (s)
            return s;
    }
    return SHEEN_OK;
}

static sheen_status merge(sheen_frame *frame, uint8_t **payload_out, const sheen_exposure *e, int n,
                          double reference_s, sheen_err *err)
{
    sheen_image sum;
    sheen_merge_report report;
    sheen_status s = sheen_exposures_merge(&sum, &report, e, n, reference_s, err);
    if (!s)
        s = sheen_exr_encode(payload_out, &frame->size_bytes, &sum, NULL, false, err);
    sheen_image_release(&sum);
    if (s)
        return s;
    frame->data = *payload_out;
    frame->extension = "exr";
    frame->info.fourcc = 0;
    frame->info.stride_bytes = 0;
    frame->info.transfer = SHEEN_TRANSFER_LINEAR;
    frame->info.color = (sheen_colorimetry){0};
    frame->info.bracket.n_exposures = n;
    frame->info.bracket.noise[0] = report.noise[0];
    frame->info.bracket.noise[1] = report.noise[1];
    frame->info.bracket.residual = report.residual;
    for (int i = 0; i < n; i++)
        frame->info.bracket.exposure_s[i] = e[i].exposure_s;
    return SHEEN_OK;
}

sheen_status sheen_bracket_take(sheen_frame *frame, uint8_t **payload_out, const sheen_session *session,
                                sheen_ladder *ladder, int n_exposures, sheen_err *err)
{
    sheen_exposure e[SHEEN_BRACKET_MAX] = {0};
    double reference_s;
    *payload_out = NULL;
    sheen_status s = take_exposures(e, n_exposures, session, ladder, err);
    sheen_err back_err;
    const sheen_status back = sheen_source_expose(ladder->src, 1, &reference_s, &back_err);
    if (!s && back) {
        s = back;
        if (err)
            *err = back_err;
    }
    if (!s)
        s = merge(frame, payload_out, e, n_exposures, reference_s, err);
    for (int i = 0; i < n_exposures; i++)
        for (int k = 0; k < 2; k++)
            sheen_image_release(&e[i].pair[k]);
    return s;
}
