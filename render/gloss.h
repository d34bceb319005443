// SPDX-License-Identifier: Apache-2.0
// gloss.h - how strongly each place shines, by the colour of its texture: paints differ in gloss as they do in colour.
//
// Beyond the paper, whose k_S is one number. A place whose texture has the linear colour c shines with the share
//
//     g(c) = sum_i w_i share_i / sum_i w_i        w_i = exp(-|sqrt(c) - sqrt(c_i)|^2 / (2 width^2))
//
// of everything specular (lights and mirrored surroundings): a mean over n colours c_i, almost that of the nearest. sqrt is by
// channel, negative light counting as none. n = 0: 1 everywhere.
#ifndef SHEEN_RENDER_GLOSS_H
#define SHEEN_RENDER_GLOSS_H

#ifdef __cplusplus
extern "C" {
#endif

enum { SHEEN_GLOSS_MAX = 32 };

typedef struct sheen_gloss {
    int n;                          // 0..SHEEN_GLOSS_MAX
    float width;                    // > 0 where n is
    float root[SHEEN_GLOSS_MAX][3]; // sqrt(c_i), 0..
    float share[SHEEN_GLOSS_MAX];   // 0..
} sheen_gloss;

// The weights w_i / sum w, [n], at the root of a colour.
void sheen_gloss_weights(float *weight, const sheen_gloss *g, const float root[3]);
// g(c) by the root of the colour, and of a linear colour.
float sheen_gloss_at_root(const sheen_gloss *g, const float root[3]);
float sheen_gloss_at(const sheen_gloss *g, const float rgb[3]);

#ifdef __cplusplus
}
#endif
#endif
