// SPDX-License-Identifier: Apache-2.0
// metrics.h - how far a rendered picture is from a photograph.
#ifndef SHEEN_FIT_METRICS_H
#define SHEEN_FIT_METRICS_H

#include <stdint.h>

#include "base/image.h"

// Peak signal-to-noise ratios in dB, peak 1, after clipping both pictures to 0..1; NaN where no pixel counts.
typedef struct sheen_psnr {
    double linear_db, srgb_db;
    size_t n_pixels;
} sheen_psnr;

// Over the pixels where select[y * width + x] is not 0 (select NULL: the whole frame). Pictures are RGB, linear, of the
// same size.
sheen_psnr sheen_psnr_of(const sheen_image *rendered, const sheen_image *photo, const uint8_t *select);

// The measures of the Stanford-ORB benchmark (Kuang et al., NeurIPS 2023) as its own program computes them:
//   * the mask is eroded by 5x5 pixels; outside it both pictures are 0;
//   * each colour channel of the rendered picture is scaled by the factor that is best in the least-squares sense;
//   * hdr_db: linear, both times mean(sRGB(photo)) / mean(photo), clipped to 4;
//     ldr_db: clipped to 1 and sRGB-coded;
//   * the error is the mean over the whole frame, zeros included, so that it depends on how much of the
//     frame the object fills: never compare it with sheen_psnr_of;
//   * neither is reported below what a flat grey 0.5 would score;
//   * ssim: of the two pictures of ldr_db, 3x3 Gaussian window of sigma 1.5, mean over the frame.
// The benchmark's frames are 512 x 512; here the frame is what it is. (LPIPS needs a trained network: not here.)
typedef struct sheen_orb {
    double hdr_db, ldr_db, ssim;
} sheen_orb;

// mask: as many bytes as pixels, 0 or not. ENOMEM; EDATA where nothing is left of the mask.
sheen_status sheen_orb_of(sheen_orb *out, const sheen_image *rendered, const sheen_image *photo,
                          const uint8_t *mask, sheen_err *err);

#endif
