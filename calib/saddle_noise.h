// SPDX-License-Identifier: Apache-2.0
// saddle_noise.h - how good a refined chessboard corner is: what noise does to it, and whether it is alone.
//
// The refinement (saddle_refine.h) ends where f(q) = sum w g g' (p - q) = 0. To first order noise in the grey values
// moves q by -D^-1 df with D = df/dq, which is -sum w g g' only where edges are sharp and end outside of the window. f
// is a sum over central differences of bilinear samples, so that df is linear in the pixels: df = K n, and
// cov(q) = D^-1 K K' D^-T for independent noise n of variance 1 a pixel.
//
// A saddle turned by half about itself is the same picture. What is not, beyond noise, does not belong to it: an
// object's outline or a shadow's edge in the window, which drags the corner by tenths of a pixel.
#ifndef SHEEN_CALIB_SADDLE_NOISE_H
#define SHEEN_CALIB_SADDLE_NOISE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// covariance = (xx, xy, yy) in px^2 per squared grey value, of the corner refined to q_px in a window of half_px to
// each side; *asymmetry: rms of what changes by half a turn about q_px, over sqrt(2), in grey values: the noise where
// nothing else is in the window. False, and all 0, where the window is flat, out of range or reaches over the
// picture's edge.
bool sheen_saddle_noise(double covariance[3], double *asymmetry, const uint8_t *grey, int width_px,
                        int height_px, const double q_px[2], int half_px);

#ifdef __cplusplus
}
#endif
#endif
