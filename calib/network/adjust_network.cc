// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/adjust_network.h"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/errors/reliability.h"
#include "calib/network/normal_equations.h"
#include "calib/network/survey_row.h"

namespace octant::calib {
namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Steps below this are within the linear range of any survey, and their change of the sum of squares may be
/// rounding.
constexpr double kSmallStep_m = 1e-3;
/// Damping of steps that are too long for the linearisation.
constexpr double kLeastDamping = 1e-6, kMostDamping = 1e3;
/// Decrease of the sum of squares by a damped step that means convergence.
constexpr double kNoGain = 1e-6;

/// Matrix W with W^T W equal to the weight matrix, for a unit variance of unit weight.
SparseRows whitening(const Network& network, double sigma_unit) {
  const auto n = static_cast<Eigen::Index>(network.observations.size());
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<bool> correlated(network.observations.size(), false);
  for (const ObservationCovariance& block : network.covariances) {
    const Eigen::Index size = block.covariance.rows();
    const Eigen::MatrixXd root =
        block.covariance.llt().matrixL().solve(Eigen::MatrixXd::Identity(size, size)) * sigma_unit;
    for (Eigen::Index i = 0; i < size; ++i) {
      correlated[static_cast<std::size_t>(block.first + i)] = true;
      for (Eigen::Index k = 0; k <= i; ++k)
        entries.emplace_back(block.first + i, block.first + k, root(i, k));
    }
  }
  for (Eigen::Index i = 0; i < n; ++i)
    if (const auto k = static_cast<std::size_t>(i); !correlated[k])
      entries.emplace_back(i, i, sigma_unit / network.observations[k].sigma);
  SparseRows w(n, n);
  w.setFromTriplets(entries.begin(), entries.end());
  return w;
}

struct Linearised {
  SparseRows jacobian;  ///< whitened
  Eigen::VectorXd misclosure;
  Eigen::VectorXd whitened;
};

Linearised linearise(const Network& network, const NetworkColumns& columns, const SparseRows& w,
                     const Eigen::VectorXd& x) {
  Linearised result;
  const auto n = static_cast<Eigen::Index>(network.observations.size());
  result.misclosure.resize(n);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < n; ++i) {
    const SurveyRow row = survey_row(network, columns, network.observations[static_cast<std::size_t>(i)], x);
    result.misclosure[i] = row.misclosure;
    for (const auto& [column, value] : row.entries) entries.emplace_back(i, column, value);
  }
  SparseRows jacobian(n, columns.size);
  jacobian.setFromTriplets(entries.begin(), entries.end());
  result.jacobian = w * jacobian;
  result.whitened = w * result.misclosure;
  return result;
}

std::vector<ObservationResult> reliability(const SparseRows& w, const Linearised& at,
                                           const NormalEquations& normals, double sigma) {
  const Eigen::SparseMatrix<double> columns = w;
  const Eigen::VectorXd weighted = w.transpose() * at.whitened;
  std::vector<ObservationResult> results;
  for (Eigen::Index i = 0; i < w.rows(); ++i) {
    // Element i of the diagonal of P Q_v P = W^T (I - A Q A^T) W.
    Eigen::SparseVector<double> direction(at.jacobian.cols());
    double weight = 0.0;
    for (Eigen::SparseMatrix<double>::InnerIterator it(columns, i); it; ++it) {
      direction += it.value() * Eigen::SparseVector<double>(at.jacobian.row(it.row()).transpose());
      weight += it.value() * it.value();
    }
    const double pqp = weight - normals.variance(direction);
    ObservationResult& r = results.emplace_back();
    r.residual = -at.misclosure[i];
    r.redundancy = std::clamp(pqp / weight, 0.0, 1.0);
    const bool checked = r.redundancy > kUncontrolled;
    r.w = checked ? -weighted[i] / (sigma * std::sqrt(pqp)) : 0.0;
    r.detectable_bias = checked ? kDelta0 * sigma / std::sqrt(pqp) : std::numeric_limits<double>::infinity();
  }
  return results;
}

/// Covariances of the points, and of all unknowns where they are few.
void add_covariances(const NetworkColumns& columns, const NormalEquations& normals, double variance,
                     int dense_limit, NetworkSolution& solution) {
  if (columns.size <= dense_limit) solution.covariance = variance * normals.all_cofactors();
  for (const std::array<int, 3>& column : columns.point) {
    std::vector<int> axes, unknowns;
    for (int i = 0; i < 3; ++i)
      if (const int c = column[static_cast<std::size_t>(i)]; c >= 0) {
        axes.push_back(i);
        unknowns.push_back(c);
      }
    Eigen::Matrix3d& covariance = solution.point_covariances_m2.emplace_back(Eigen::Matrix3d::Zero());
    covariance(axes, axes) = variance * normals.cofactors(unknowns);
  }
}

void report(const Network& network, const NetworkColumns& columns, const NetworkOptions& options,
            const SparseRows& w, const Linearised& at, const NormalEquations& normals,
            const Eigen::VectorXd& x, NetworkSolution& solution) {
  solution.defect = normals.defect();
  solution.redundancy = static_cast<int>(network.observations.size()) - columns.size + solution.defect;
  const double prior = options.sigma_unit * options.sigma_unit;
  if (solution.redundancy > 0)
    solution.variance_factor = at.whitened.squaredNorm() / solution.redundancy / prior;
  const double variance = options.sigmas_a_posteriori ? solution.variance_factor * prior : prior;
  solution.unknowns = x;
  add_covariances(columns, normals, variance, options.dense_limit, solution);
  solution.observations = reliability(w, at, normals, std::sqrt(variance));
  for (std::size_t p = 0; p < network.points.size(); ++p) {
    Eigen::Vector3d& position = solution.points_m.emplace_back(network.points[p].p_map_m);
    for (std::size_t i = 0; i < 3; ++i)
      if (const int c = columns.point[p][i]; c >= 0) position[static_cast<int>(i)] = x[c];
  }
}

/// Step of Levenberg. The damping is relative to the mean of the diagonal, since elements of it vanish where
/// ranges cannot be met exactly and a point lies in the plane of its neighbours.
Eigen::VectorXd damped_step(const Linearised& at, double damping) {
  Eigen::SparseMatrix<double> normal = at.jacobian.transpose() * at.jacobian;
  const double mean = normal.diagonal().mean();
  for (Eigen::Index c = 0; c < normal.cols(); ++c) normal.coeffRef(c, c) += damping * mean;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(normal);
  return factor.solve(at.jacobian.transpose() * at.whitened);
}

}  // namespace

NetworkSolution adjust_network(const Network& network, const NetworkOptions& options) {
  NetworkSolution solution;
  const NetworkColumns columns = network_columns(network);
  const SparseRows w = whitening(network, options.sigma_unit);
  Eigen::VectorXd x = initial_unknowns(network, columns), reference = x;
  double previous = std::numeric_limits<double>::infinity();
  while (true) {
    const Linearised at = linearise(network, columns, w, x);
    const NormalEquations normals(at.jacobian, columns.point, columns.datum);
    solution.undetermined = normals.undetermined();
    if (!solution.undetermined.empty()) solution.status = NetworkStatus::kUndetermined;
    if (solution.status == NetworkStatus::kUndetermined) return solution;
    if (solution.status == NetworkStatus::kConverged || solution.iterations == options.max_iterations) {
      report(network, columns, options, w, at, normals, x, solution);
      return solution;
    }
    ++solution.iterations;
    bool is_damped = false;
    Eigen::VectorXd step = normals.solve(at.jacobian.transpose() * at.whitened, x - reference);
    // A large step that increases the sum of squares is too long for the linearisation.
    const double squares = at.whitened.squaredNorm();
    double gain = std::numeric_limits<double>::infinity();
    for (double damping = kLeastDamping;
         damping < kMostDamping && (is_damped || step.cwiseAbs().maxCoeff() > kSmallStep_m);
         damping *= 10.0) {
      gain = squares - linearise(network, columns, w, x + step).whitened.squaredNorm();
      if (gain >= 0.0) break;
      step = damped_step(at, damping);
      is_damped = true;
    }
    const double no_gain = kNoGain * options.sigma_unit * options.sigma_unit;
    if (is_damped && gain < -no_gain) {  // no step improves the sum of squares, and this is no rounding error
      solution.iterations = options.max_iterations;
      continue;
    }
    x += step;
    if (options.datum_follows) reference = x;
    const double size = step.head(columns.first_set).cwiseAbs().maxCoeff();
    // Steps that shrink no more are rounding errors: 1e-10 m already in coordinates of a thousand kilometres.
    const bool is_rounding = size < 1e3 * options.tolerance_m && size > 0.5 * previous;
    const bool is_stationary = is_damped && gain < no_gain;
    if (size < options.tolerance_m || is_rounding || is_stationary)
      solution.status = NetworkStatus::kConverged;
    previous = size;
  }
}

}  // namespace octant::calib
