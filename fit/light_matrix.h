// SPDX-License-Identifier: Apache-2.0
// light_matrix.h - eq. (7) as a sparse matrix: samples x nodes of the illumination hemisphere.
//
// I_S = A x with A_sl = exp(-alpha_sl^2 / (2 sigma^2)) / cos(theta_r,s) and x_l = k_S (2 pi / N_L) L_l. The angles come
// from render/lobe.h and do not change with sigma; pairs beyond the lobe's reach at the largest sigma asked for are
// left out.
#ifndef SHEEN_FIT_LIGHT_MATRIX_H
#define SHEEN_FIT_LIGHT_MATRIX_H

#include <stdint.h>

#include "fit/samples.h"

typedef struct sheen_light_matrix {
    size_t n_samples, n_nodes, n_pairs;
    size_t *column_start; // [n_nodes + 1], pairs of node l are column_start[l] .. column_start[l + 1]
    uint32_t *sample;     // [n_pairs] ascending within a column
    float *alpha2;        // [n_pairs] rad^2
    float *value;         // [n_pairs] A_sl at the sigma of the last set_sigma
    float *inverse_cos;   // [n_samples]
    double sigma_max_rad; // the largest sigma for which all pairs are there
} sheen_light_matrix;

// node_world: [n_nodes][3] unit directions. ENOMEM.
sheen_status sheen_light_matrix_init(sheen_light_matrix *m, const sheen_samples *samples,
                                     const float *node_world, size_t n_nodes, double sigma_max_rad,
                                     int n_threads, sheen_err *err);
void sheen_light_matrix_release(sheen_light_matrix *m);

// Takes out the pairs for which hidden(self, i_sample, node direction) is not 0: lights that the mesh hides. Called from
// several threads. Pairs beyond three sigma_max are not asked.
void sheen_light_matrix_hide(sheen_light_matrix *m, const float *node_world,
                             int (*hidden)(void *self, size_t i_sample, const float l_world[3]), void *self,
                             int n_threads);

// Computes `value` for a sigma up to sigma_max_rad.
void sheen_light_matrix_set_sigma(sheen_light_matrix *m, double sigma_rad, int n_threads);

// intensity[n_samples] = A x at a sigma, without touching `value`; columns with x = 0 cost nothing.
void sheen_light_matrix_predict(const sheen_light_matrix *m, double *intensity, const double *x,
                                double sigma_rad);

#endif
