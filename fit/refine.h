// SPDX-License-Identifier: Apache-2.0
// refine.h - illumination and reflectance parameters by two minimisations in turns (section 4.3).
#ifndef SHEEN_FIT_REFINE_H
#define SHEEN_FIT_REFINE_H

#include "base/progress.h"
#include "fit/robust.h"
#include "fit/samples.h"

typedef struct sheen_refine_options {
    double sigma0_rad;      // where sigma starts; it should lie above the truth (see docs/algorithm.md)
    double sigma_tolerance; // relative change of sigma in a turn that counts as converged; 0: 1e-3
    double cost_tolerance;  // relative change of E, likewise; 0: 1e-4
    int max_turns;          // 0: 100
    double sigma_err_floor; // smallest scale of the M-estimator, in light; 0: 0.0015
    sheen_loss loss;
    // Does the mesh hide a light from a sample? NULL: nothing is hidden (the paper). Called from several threads.
    int (*hidden)(void *self, size_t i_sample, const float l_world[3]);
    void *hidden_self;
    int n_threads;
    sheen_progress progress;
} sheen_refine_options;

// After each turn.
typedef struct sheen_refine_turn {
    double sigma_rad, k_s, objective;
    size_t n_nodes_left;
} sheen_refine_turn;

typedef struct sheen_refine_result {
    double sigma_rad, k_s; // k_S in the gauge sum_l omega L_l = 1
    double *radiance;      // [n_nodes] L_l >= 0, in that gauge
    size_t n_nodes_left;   // nodes with L_l > 0
    double sigma_err, objective;
    int converged;
    sheen_refine_turn *turns;
    size_t n_turns;
} sheen_refine_result;

// Minimises E (eq. 9) over sigma with (L_l, k_S) held, then over (L_l, k_S) with sigma held, until neither changes.
// node_world[n_nodes][3]: nodes with a value on the initial hemisphere; radiance0[n_nodes]: their Y; omega_sr: 2 pi / N_L.
// Only k_S omega L_l can be observed: the gauge gives k_S its size.
// EDATA: no samples or no nodes. ECANCEL, ENOMEM.
sheen_status sheen_refine(sheen_refine_result *out, const sheen_samples *samples, const float *node_world,
                          const float *radiance0, size_t n_nodes, double omega_sr,
                          const sheen_refine_options *options, sheen_err *err);
// Appends to its history. ENOMEM.
sheen_status sheen_refine_note(sheen_refine_result *out, const sheen_refine_turn *turn, sheen_err *err);

void sheen_refine_result_release(sheen_refine_result *r);

#endif
