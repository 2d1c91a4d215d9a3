// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/adjust_network.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/errors/reliability.h"
#include "calib/network/survey_row.h"

namespace octant::calib {
namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Eigenvalues of the normal matrix with unit diagonal below this count as zero: sums of some thousand
/// products have rounding errors of 1e-13, and a determined network of ordinary shape stays above 1e-9.
constexpr double kZeroEigenvalue = 1e-11;

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

/// Coordinates, and each orientation from the first direction of its set.
Eigen::VectorXd initial_unknowns(const Network& network, const NetworkColumns& columns) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(columns.size);
  for (std::size_t p = 0; p < network.points.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int c = columns.point[p][i]; c >= 0) x[c] = network.points[p].p_map_m[static_cast<int>(i)];
  std::vector<bool> oriented(static_cast<std::size_t>(network.sets), false);
  for (const SurveyObservation& o : network.observations) {
    if (o.kind != SurveyKind::kDirection || oriented[static_cast<std::size_t>(o.set)]) continue;
    oriented[static_cast<std::size_t>(o.set)] = true;
    x[columns.first_set + o.set] = -survey_row(network, columns, o, x).misclosure;
  }
  return x;
}

/// Inverse of the normal equations, bordered by inner constraints where their rank is deficient.
struct Normals {
  Eigen::MatrixXd inverse;      ///< covariance for unit variance of unit weight
  Eigen::MatrixXd to_datum;     ///< null vectors by their coefficients: restores the constraint
  Eigen::MatrixXd constraints;  ///< one column a constraint
  std::vector<int> undetermined;
};

/// Null vectors of the normal matrix: the motions (and deformations) that no observation sees.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& normal) {
  const double tiny = std::numeric_limits<double>::min();
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(tiny).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * normal *
                                                             scale.asDiagonal());
  const Eigen::Index defect = (eigen.eigenvalues().array() < kZeroEigenvalue).count();
  Eigen::MatrixXd vectors = scale.asDiagonal() * eigen.eigenvectors().leftCols(defect);
  for (Eigen::Index k = 0; k < defect; ++k) vectors.col(k).normalize();
  return vectors;
}

Normals invert(const Eigen::MatrixXd& normal, const std::vector<int>& datum) {
  Normals result;
  const Eigen::MatrixXd motions = null_space(normal);
  const Eigen::Index u = normal.rows(), d = motions.cols();
  result.constraints = Eigen::MatrixXd::Zero(u, d);
  for (const int c : datum) result.constraints.row(c) = motions.row(c);
  if (d > 0) {
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(result.constraints.transpose() * motions);
    if (!lu.isInvertible()) {
      for (int c = 0; c < u; ++c)
        if (motions.row(c).norm() > 1e-6 * motions.cwiseAbs().maxCoeff()) result.undetermined.push_back(c);
      return result;
    }
    result.to_datum = motions * lu.inverse();
  }
  // Adding C C^T makes the matrix regular; the projection restores the minimum of the datum corrections.
  const double weight = normal.diagonal().mean();
  const Eigen::MatrixXd regular = normal + weight * result.constraints * result.constraints.transpose();
  result.inverse = regular.llt().solve(Eigen::MatrixXd::Identity(u, u));
  if (d == 0) return result;
  const Eigen::MatrixXd projection =
      Eigen::MatrixXd::Identity(u, u) - result.to_datum * result.constraints.transpose();
  result.inverse = (projection * result.inverse * projection.transpose()).eval();
  return result;
}

std::vector<std::string> points_of(const Network& network, const NetworkColumns& columns,
                                   const std::vector<int>& unknowns) {
  std::vector<std::string> ids;
  for (std::size_t p = 0; p < network.points.size(); ++p)
    if (std::ranges::any_of(columns.point[p],
                            [&](int c) { return c >= 0 && std::ranges::count(unknowns, c) > 0; }))
      ids.push_back(network.points[p].id);
  return ids;
}

std::vector<ObservationResult> reliability(const SparseRows& w, const Linearised& at,
                                           const Eigen::MatrixXd& inverse, double sigma) {
  const Eigen::MatrixXd aq = at.jacobian * inverse;
  const Eigen::SparseMatrix<double> columns = w;
  const Eigen::VectorXd weighted = w.transpose() * at.whitened;
  std::vector<ObservationResult> results;
  for (Eigen::Index i = 0; i < w.rows(); ++i) {
    // Row i of P Q_v, from W^T (I - A Q A^T) W.
    Eigen::RowVectorXd qa = Eigen::RowVectorXd::Zero(inverse.cols());
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(inverse.cols());
    double pqp = 0.0;
    for (Eigen::SparseMatrix<double>::InnerIterator it(columns, i); it; ++it) {
      qa += it.value() * aq.row(it.row());
      direction += it.value() * at.jacobian.row(it.row()).transpose();
      pqp += it.value() * it.value();
    }
    const double weight = pqp;
    pqp -= qa.dot(direction);
    ObservationResult& r = results.emplace_back();
    r.residual = -at.misclosure[i];
    r.redundancy = std::clamp(pqp / weight, 0.0, 1.0);
    const bool checked = r.redundancy > kUncontrolled;
    r.w = checked ? -weighted[i] / (sigma * std::sqrt(pqp)) : 0.0;
    r.detectable_bias = checked ? kDelta0 * sigma / std::sqrt(pqp) : std::numeric_limits<double>::infinity();
  }
  return results;
}

}  // namespace

NetworkSolution adjust_network(const Network& network, const NetworkOptions& options) {
  NetworkSolution solution;
  const NetworkColumns columns = network_columns(network);
  const SparseRows w = whitening(network, options.sigma_unit);
  const Eigen::VectorXd initial = initial_unknowns(network, columns);
  Eigen::VectorXd x = initial;
  Normals normals;
  double previous = std::numeric_limits<double>::infinity();
  while (solution.iterations < options.max_iterations && solution.status == NetworkStatus::kNotConverged) {
    ++solution.iterations;
    const Linearised at = linearise(network, columns, w, x);
    normals = invert(Eigen::MatrixXd(at.jacobian.transpose() * at.jacobian), columns.datum);
    solution.undetermined = points_of(network, columns, normals.undetermined);
    if (!normals.undetermined.empty()) solution.status = NetworkStatus::kUndetermined;
    if (solution.status == NetworkStatus::kUndetermined) return solution;
    Eigen::VectorXd step = normals.inverse * (at.jacobian.transpose() * at.whitened);
    if (normals.constraints.cols() > 0)
      step -= normals.to_datum * (normals.constraints.transpose() * (x - initial));
    x += step;
    const double size = step.head(columns.first_set).cwiseAbs().maxCoeff();
    // Steps that shrink no more are rounding errors: 1e-10 m already in coordinates of a thousand kilometres.
    const bool is_rounding = size < 1e3 * options.tolerance_m && size > 0.5 * previous;
    if (size < options.tolerance_m || is_rounding) solution.status = NetworkStatus::kConverged;
    previous = size;
  }
  const Linearised at = linearise(network, columns, w, x);
  solution.defect = static_cast<int>(normals.constraints.cols());
  solution.redundancy = static_cast<int>(network.observations.size()) - columns.size + solution.defect;
  const double prior = options.sigma_unit * options.sigma_unit;
  if (solution.redundancy > 0)
    solution.variance_factor = at.whitened.squaredNorm() / solution.redundancy / prior;
  const double variance = options.sigmas_a_posteriori ? solution.variance_factor * prior : prior;
  solution.unknowns = x;
  solution.covariance = variance * normals.inverse;
  solution.observations = reliability(w, at, normals.inverse, std::sqrt(variance));
  for (std::size_t p = 0; p < network.points.size(); ++p) {
    Eigen::Vector3d& position = solution.points_m.emplace_back(network.points[p].p_map_m);
    for (std::size_t i = 0; i < 3; ++i)
      if (const int c = columns.point[p][i]; c >= 0) position[static_cast<int>(i)] = x[c];
  }
  return solution;
}

}  // namespace octant::calib
