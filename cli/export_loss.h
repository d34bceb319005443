// SPDX-License-Identifier: Apache-2.0
// export_loss.h - how much of a session's model an export lost, measured on the photographs it was fitted to.
#ifndef SHEEN_CLI_EXPORT_LOSS_H
#define SHEEN_CLI_EXPORT_LOSS_H

#include "fit/photos.h"
#include "render/draw.h"

enum { SHEEN_EXPORT_MAX_VIEWS = 8 };

// The photographs to measure on (evenly chosen among the input frames), with the uncompressed model drawn from
// their viewpoints.
typedef struct sheen_export_views {
    sheen_photos photos;
    size_t n_views, i_photo[SHEEN_EXPORT_MAX_VIEWS];
    sheen_image drawn[SHEEN_EXPORT_MAX_VIEWS];
    uint8_t *select[SHEEN_EXPORT_MAX_VIEWS]; // pixels wholly on the object
    sheen_draw_options options;
} sheen_export_views;

// dB over the object, sRGB. full and packed: drawings against photographs, means over the views; their difference is
// the loss. agreement: drawings of the two models against each other, the worst view.
typedef struct sheen_export_loss {
    double full_db, packed_db, agreement_db;
} sheen_export_loss;

// model is the uncompressed one. EDATA: no photograph to measure on. ECANCEL.
sheen_status sheen_export_views_open(sheen_export_views *out, const sheen_session *s,
                                     const sheen_model *model, int n_threads, const sheen_progress *progress,
                                     sheen_err *err);
void sheen_export_views_close(sheen_export_views *v);
sheen_status sheen_export_measure(sheen_export_loss *out, const sheen_export_views *v,
                                  const sheen_model *packed, sheen_err *err);

#endif
