// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/evaluation_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>

#include "models/support/decompositions.h"
#include "models/support/parallel.h"

namespace octant::calib {
namespace {

SystemResiduals system_residuals_of(const ReducedSystem& system) {
  constexpr double kLeastPivot = 1e-13, kLeastInformation = 1e-300;
  SystemResiduals out;
  // The remaining information on an unobservable parameter is a rounding error and may be negative: it is
  // left out.
  const Eigen::VectorXd diagonal = system.H.diagonal();
  const Eigen::VectorXd scale = diagonal.cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = (diagonal.array() > kLeastInformation).select(scale.cwiseInverse(), 0.0);
  const DenseLdlt ldlt((inverse.asDiagonal() * system.H * inverse.asDiagonal()).eval());
  const Eigen::VectorXd d = ldlt.vectorD();
  // P' L D L' P: rank-deficient directions, which no observation of this tile depends on, get a zero row.
  Eigen::VectorXd y = ldlt.transpositionsP() * (inverse.asDiagonal() * system.gradient).eval();
  ldlt.matrixL().solveInPlace(y);
  const Eigen::MatrixXd L = ldlt.matrixL();
  out.R = (ldlt.transpositionsP().transpose() * L).transpose();  // (P' L)' = L' P
  out.z.setZero(d.size());
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double root = d[i] > kLeastPivot ? std::sqrt(d[i]) : 0.0;
    out.R.row(i) *= root;
    if (root > 0) out.z[i] = y[i] / root;
  }
  out.R = out.R * scale.asDiagonal();
  out.rest = std::sqrt(std::max(0.0, 2.0 * system.cost - out.z.squaredNorm()));
  return out;
}

}  // namespace

void EvaluationPoint::PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) {
  if (new_evaluation_point || !is_solved) {
    state = layout->state_of(*x);
    priors = prior_rows(*problem, *layout, *x);
    cost = observations->solve_states(state, options->loss);
    is_solved = true;
  }
  if (!evaluate_jacobians) return;
  if (dense) {
    evaluate_system();
    return;
  }
  std::vector<SystemPart> parts = observations->reduce_each(state, options->loss);
  cost = std::accumulate(parts.begin(), parts.end(), 0.0,
                         [](double before, const SystemPart& part) { return before + part.system.cost; });
  residuals.resize(parts.size());
  for_each_parallel(parts.size(), options->workers.threads, [&](std::size_t i) {
    residuals[i] = system_residuals_of(parts[i].system);
    parts[i] = {};
  });
}

void EvaluationPoint::evaluate_system() {
  at_rest = reduced_at.size() > 0 && nothing_left_to_gain();
  if (at_rest) {
    move_last_residuals();
    return;
  }
  observations->reduce(state, options->loss, sum);
  cost = sum.cost;
  reduced_at = *x;
  residuals.assign(1, system_residuals_of(sum));
}

bool EvaluationPoint::nothing_left_to_gain() const {
  constexpr double kAlike = 3e-4, kLeftBehind = 0.01;
  const Eigen::VectorXd step = *x - reduced_at;
  const double gain = 0.5 * step.dot(sum.H * step);
  const double off = std::abs(cost - sum.cost - step.dot(sum.gradient) - gain);
  return off < kAlike * gain && kLeftBehind * gain < options->function_tolerance * cost;
}

bool EvaluationPoint::rays_are_the_same() const {
  constexpr double kBeaconM = 1e-3, kReceiverM = 5e-5;
  const auto moved = [&](const std::vector<std::array<int, 3>>& columns, double by_m) {
    return std::ranges::any_of(columns, [&](const std::array<int, 3>& place) {
      return std::ranges::any_of(place,
                                 [&](int c) { return c >= 0 && std::abs((*x)[c] - reduced_at[c]) > by_m; });
    });
  };
  return !moved(layout->beacon, kBeaconM) && !moved(layout->receiver, kReceiverM);
}

void EvaluationPoint::move_last_residuals() {
  SystemResiduals& r = residuals[0];
  r.z += r.R * (*x - reduced_at);
  r.rest = std::sqrt(std::max(0.0, 2.0 * cost - r.z.squaredNorm()));
  observations->commit();
}

}  // namespace octant::calib
