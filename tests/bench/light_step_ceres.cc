// SPDX-License-Identifier: Apache-2.0
// light_step_ceres.cc - the light step by Ceres: a bounded scalar for each node, a row of the matrix for each sample.
#include <ceres/ceres.h>

#include <cmath>
#include <vector>

#include "tests/bench/light_step.h"

namespace
{

struct Row : public ceres::CostFunction {
    std::vector<double> a; // over the noise
    double y;

    Row(const std::vector<double> &values, double observed) : a(values), y(observed)
    {
        set_num_residuals(1);
        mutable_parameter_block_sizes()->assign(a.size(), 1);
    }

    bool Evaluate(double const *const *x, double *residual, double **jacobian) const override
    {
        residual[0] = y;
        for (size_t i = 0; i < a.size(); i++) {
            residual[0] -= a[i] * x[i][0];
            if (jacobian && jacobian[i])
                jacobian[i][0] = -a[i];
        }
        return true;
    }
};

} // namespace

int light_step_ceres(double *x, const light_step *p, int max_iterations)
{
    ceres::Problem problem;
    std::vector<std::vector<double>> value(p->m.n_samples);
    std::vector<std::vector<double *>> node(p->m.n_samples);
    for (size_t l = 0; l < p->m.n_nodes; l++)
        for (size_t k = p->m.column_start[l]; k < p->m.column_start[l + 1]; k++) {
            value[p->m.sample[k]].push_back(static_cast<double>(p->m.value[k]) / p->scale);
            node[p->m.sample[k]].push_back(x + l);
        }
    for (size_t s = 0; s < p->m.n_samples; s++)
        if (!node[s].empty())
            problem.AddResidualBlock(new Row(value[s], static_cast<double>(p->y[s]) / p->scale),
                                     new ceres::CauchyLoss(std::sqrt(2.0)), node[s]);
    for (size_t l = 0; l < p->m.n_nodes; l++)
        if (problem.HasParameterBlock(x + l))
            problem.SetParameterLowerBound(x + l, 0, 0);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::CGNR;
    options.max_num_iterations = max_iterations;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return 1;
}
