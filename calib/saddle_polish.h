// SPDX-License-Identifier: Apache-2.0
// saddle_polish.h - the last step of a chessboard corner: free of the interpolation's bias, with its covariance.
//
// The refinement (saddle_refine.h) ends where f(q) = sum w g g' (p - q) = 0, g being differences of samples between
// the pixels. Where these are bilinear, the sample at a fraction a of a pixel has the third moment a (1 - a) (1 - 2a):
// corners seem drawn towards the middle between two pixels, by 0.02 px at a blur of 0.8 px. Lagrange's interpolation
// through six pixels has neither that moment nor the fifth; q is moved on by Newton steps -D^-1 f with D = df/dq.
//
// D is taken by differences, since it is -sum w g g' only where edges are sharp and end outside of the window. f is a
// sum over products of two samples' differences, so that to first order df is linear in the pixels: df = K n, and
// cov(q) = D^-1 K K' D^-T for independent noise n of variance 1 a pixel.
//
// A saddle turned by half about itself is the same picture. What is not, beyond noise, does not belong to it: an
// object's outline or a shadow's edge in the window, which drags the corner by tenths of a pixel.
#ifndef SHEEN_CALIB_SADDLE_POLISH_H
#define SHEEN_CALIB_SADDLE_POLISH_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sheen_saddle_polished {
    double q_px[2];
    double covariance[3]; // (xx, xy, yy) of q_px in px^2 per squared grey value of a pixel's noise
    // rms of what changes by half a turn about q_px, as the noise of a pixel in grey values that would do that: the
    // noise itself where nothing else is in the window; and how many pairs of samples, weighed, speak for it
    double asymmetry, n_pairs;
} sheen_saddle_polished;

// From the corner refined to q_px in a window of half_px to each side. False where the window is flat, out of range
// or reaches over the picture's edge, or where the corner moves by more than half a pixel.
bool sheen_saddle_polish(sheen_saddle_polished *out, const uint8_t *grey, int width_px, int height_px,
                         const double q_px[2], int half_px);

#ifdef __cplusplus
}
#endif
#endif
