// SPDX-License-Identifier: Apache-2.0
// diffuse.h - texture and surroundings from photographs whose lights are accounted for.
//
// A texel's photographs obey I_v = D + S_v + F_v M_v: D the same in all of them, S_v the lights' specular part, M_v what
// is mirrored there, F_v Schlick's term. view_light.h predicts S_v and M_v.
#ifndef SHEEN_FIT_DIFFUSE_H
#define SHEEN_FIT_DIFFUSE_H

#include "fit/view_light.h"

// Photographs that a texel is estimated from at most.
enum { SHEEN_REFINED_MAX_VIEWS = 64 };

// Finds F0 and, where asked to, the ambient light (else it stays) of `surroundings` (its board is given), by least squares over differences between
// the photographs of each texel, in which D falls out; a few reweighted rounds against outliers. Every k-th texel of those that
// two photographs or more see. views, lights: [n_views].
void sheen_surroundings_fit(sheen_surroundings *surroundings, int with_ambient, const sheen_texel_view *views,
                            const sheen_view_light *lights, size_t n_views, int n_threads);

// I - F M of a texel that the view sees: what is left for its diffuse colour and the lights.
void sheen_diffuse_and_lights(double rgb[3], const sheen_surroundings *surroundings,
                              const sheen_texel_view *view, const sheen_view_light *light, size_t texel);

// How badly each photograph of a texel is predicted by the others: mean Lorentzian of I_v - S_v - F_v M_v against the mean of the
// rest. surroundings->present = 0: without F M.
double sheen_diffuse_cost(const sheen_surroundings *surroundings, const sheen_texel_view *views,
                          const sheen_view_light *lights, size_t n_views, int n_threads);

// D of every texel: the robust mean of I_v - S_v - F_v M_v, in which a view counts less where it is seen at a slant and where
// much was taken off it. Texels that no view sees stay unseen. texture: of the same lattice; n_views in it is kept.
// deviation: [n_texels] standard deviation of each one's luminance, NaN where fewer than two photographs see it; NULL: not asked for.
void sheen_diffuse_fit(sheen_texture *texture, float *deviation, const sheen_surroundings *surroundings,
                       const sheen_texel_view *views, const sheen_view_light *lights, size_t n_views,
                       int n_threads);

#endif
