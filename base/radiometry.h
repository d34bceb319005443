// SPDX-License-Identifier: Apache-2.0
// radiometry.h - what was measured of a camera's numbers, and frames turned into light by it.
//
// A session keeps three things of its camera in radiometry/ (docs/session-format.md), each as it was measured: dark
// frames (the lens covered: black level, hot pixels), one for each exposure in use; a flat field (an evenly lit white:
// what lens and sensor make darker); and a response curve (which light stands behind a code).
#ifndef SHEEN_BASE_RADIOMETRY_H
#define SHEEN_BASE_RADIOMETRY_H

#include "base/session.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SHEEN_SESSION_RADIOMETRY "radiometry"

typedef enum sheen_measure {
    SHEEN_MEASURE_DARK,     // mean codes of frames without light; belongs to all settings
    SHEEN_MEASURE_FLAT,     // mean codes of frames of an even white; belongs to the lens: focus, zoom, iris
    SHEEN_MEASURE_RESPONSE, // light at evenly spaced codes; belongs to what makes the curve: gamma, contrast, ...
    SHEEN_MEASURE_COUNT
} sheen_measure;

// The dark frames, the flat field and the curve that apply to one frame, as they are used. data NULL: there is none.
typedef struct sheen_radiometry {
    sheen_raster dark;        // codes, 16 bits: of the mosaic (one channel), else as developed
    sheen_image gain;         // RGB, 1 where the picture is brightest
    sheen_image response;     // light at width_px codes evenly from 0 to 1, one row, one channel
    double response_residual; // relative; NaN: no curve
} sheen_radiometry;

// What of the session's applies to frame f; all empty where the session has nothing. EDATA, with what differs and what to
// do, where it was measured of another camera, at another size or under other settings; EFORMAT where a file is damaged.
sheen_status sheen_radiometry_load(sheen_radiometry *r, const sheen_session *s, const sheen_frame_info *f,
                                   sheen_err *err);
void sheen_radiometry_release(sheen_radiometry *r);

// A frame's codes, full scale 65535, or 255 of a JPEG: of a mosaic before anything is interpolated (one channel).
// f->color, fourcc, sizes say what the payload is. EFORMAT, EUNSUP, ENOMEM.
sheen_status sheen_frame_codes(sheen_raster *out, const sheen_frame_info *f, const void *payload,
                               size_t size_bytes, sheen_err *err);
// A payload as RGB in linear light: L = gain (l - d) / (1 - D), with l the light of its code by the curve, d that of
// the dark frame, and D the mean of d (of a mosaic both before it is interpolated). r may be NULL. Negative light is 0. Of a frame that was put
// together from several exposures only the gain is applied: the rest was done with each. EFORMAT, EUNSUP, ENOMEM.
sheen_status sheen_radiometry_develop(sheen_image *out, const sheen_radiometry *r, const sheen_frame_info *f,
                                      const void *payload, size_t size_bytes, sheen_err *err);

// Puts a measurement into the session, in the place of one of the same kind (of dark frames: and the same settings).
// `taken` describes the frames that it was made from (its name does not count). Dark, flat: a 16-bit raster of codes as
// sheen_frame_codes gives them, `response` NULL. Response: one row of light, `codes` NULL; taken->bracket says from
// which exposures, and the residual. EIO, EARG, ENOMEM.
sheen_status sheen_radiometry_store(const sheen_session *s, sheen_measure kind, const sheen_frame_info *taken,
                                    const sheen_raster *codes, const sheen_image *response, sheen_err *err);

// What `from` has measured and `to` has not. EIO, EFORMAT.
sheen_status sheen_radiometry_copy(const sheen_session *to, const sheen_session *from, sheen_err *err);

// Whether what was measured of frames like a may be used for b (see sheen_measure). EDATA: the sentence says what differs.
sheen_status sheen_measure_belongs(sheen_measure kind, const sheen_frame_info *a, const sheen_frame_info *b,
                                   sheen_err *err);

// Digest over all that the session has measured; "" where that is nothing.
sheen_status sheen_radiometry_digest(char hex[33], const sheen_session *s, sheen_err *err);

#ifdef __cplusplus
}
#endif
#endif
