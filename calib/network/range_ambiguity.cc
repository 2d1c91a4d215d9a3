// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/range_ambiguity.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/network/select_observations.h"
#include "calib/network/survey_row.h"

namespace octant::calib {
namespace {

/// Difference of half squares below which two positions fit equally well.
constexpr double kEqualFit = 4.0;
/// Distance of two positions, in sigmas, below which they are the same.
constexpr double kSamePosition = 4.0;
constexpr int kResectionSteps = 20;

/// One point with the observations of its position; the other points keep their adjusted positions.
struct Resection {
  Eigen::VectorXd given_m, given_weight;  ///< weights are 0 without an observed coordinate
  Eigen::MatrixXd neighbours_m;           ///< one column a range
  Eigen::VectorXd rise_m, range_m, sigma_m;

  /// Half the sum of squares at x. Adds to the normal equations where they are given.
  double half_squares(const Eigen::VectorXd& x, Eigen::MatrixXd* normal, Eigen::VectorXd* gradient) const {
    const Eigen::VectorXd off_m = given_m - x;
    double sum = off_m.cwiseAbs2().dot(given_weight);
    if (normal != nullptr) {
      *normal = given_weight.asDiagonal();
      *gradient = given_weight.cwiseProduct(off_m);
    }
    for (Eigen::Index i = 0; i < range_m.size(); ++i) {
      const Eigen::VectorXd sight_m = x - neighbours_m.col(i);
      const double length_m = std::hypot(sight_m.norm(), rise_m[i]);
      const Eigen::VectorXd slope = sight_m / (std::max(length_m, 1e-9) * sigma_m[i]);
      const double residual = (range_m[i] - length_m) / sigma_m[i];
      sum += residual * residual;
      if (normal == nullptr) continue;
      *normal += slope * slope.transpose();
      *gradient += residual * slope;
    }
    return 0.5 * sum;
  }
};

/// Adjusted position from a start (Levenberg-Marquardt), with half the sum of squares there.
std::pair<Eigen::VectorXd, double> resect(const Resection& at, Eigen::VectorXd x) {
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
  double cost = at.half_squares(x, &normal, &gradient), damping = 1e-6;
  for (int step = 0; step < kResectionSteps; ++step) {
    const Eigen::MatrixXd damped =
        normal + damping * normal.trace() * Eigen::MatrixXd::Identity(x.size(), x.size());
    const Eigen::VectorXd next = x + damped.ldlt().solve(gradient);
    if (const double there = at.half_squares(next, nullptr, nullptr); there < cost) {
      x = next;
      cost = at.half_squares(x, &normal, &gradient);
      damping *= 0.1;
    } else {
      damping *= 10.0;
    }
  }
  return {x, cost};
}

Resection resection_of(const SolvedNetwork& solved, int p, int dimensions) {
  Resection at;
  at.given_m = at.given_weight = Eigen::VectorXd::Zero(dimensions);
  std::vector<std::pair<int, std::size_t>> ranges;
  for (std::size_t i = 0; i < solved.network.observations.size(); ++i) {
    const SurveyObservation& o = solved.network.observations[i];
    if (o.kind == SurveyKind::kSlopeDistance && (o.from == p || o.to == p))
      ranges.emplace_back(o.from == p ? o.to : o.from, i);
    const int axis = static_cast<int>(o.kind) - static_cast<int>(SurveyKind::kX);
    if (o.from != p || axis < 0 || axis >= dimensions) continue;
    at.given_m[axis] = o.value;
    at.given_weight[axis] = std::pow(o.sigma, -2);
  }
  const auto n = static_cast<Eigen::Index>(ranges.size());
  at.neighbours_m.resize(dimensions, n);
  at.rise_m = at.range_m = at.sigma_m = Eigen::VectorXd::Zero(n);
  const Eigen::Vector3d& here = solved.solution.points_m[static_cast<std::size_t>(p)];
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& [other, i] = ranges[static_cast<std::size_t>(k)];
    const Eigen::Vector3d& there = solved.solution.points_m[static_cast<std::size_t>(other)];
    at.neighbours_m.col(k) = there.head(dimensions);
    if (dimensions == 2) at.rise_m[k] = there.z() - here.z();
    // The adjusted range less the residual is the observed one without the delays.
    at.range_m[k] = (there - here).norm() - solved.solution.observations[i].residual;
    at.sigma_m[k] = solved.network.observations[i].sigma;
  }
  return at;
}

bool is_ambiguous(const SolvedNetwork& solved, int p, int dimensions) {
  const Resection at = resection_of(solved, p, dimensions);
  if (at.range_m.size() == 0) return false;
  const auto point = static_cast<std::size_t>(p);
  const Eigen::VectorXd here = solved.solution.points_m[point].head(dimensions),
                        middle = at.neighbours_m.rowwise().mean();
  const Eigen::MatrixXd spread = at.neighbours_m.colwise() - middle;
  const Eigen::VectorXd across =
      Eigen::JacobiSVD<Eigen::MatrixXd>(spread, Eigen::ComputeFullU).matrixU().col(dimensions - 1);
  const auto [image, cost] = resect(at, here - 2.0 * across.dot(here - middle) * across);
  const double sigma_m =
      std::sqrt(solved.solution.point_covariances_m2[point].topLeftCorner(dimensions, dimensions).trace());
  return (image - here).norm() > kSamePosition * sigma_m &&
         cost - at.half_squares(here, nullptr, nullptr) < kEqualFit;
}

}  // namespace

std::vector<std::string> leave_out_ambiguous(SolvedNetwork& solved, int dimensions) {
  std::vector<std::string> names;
  while (solved.solution.status == NetworkStatus::kConverged) {
    std::vector<std::size_t> located, ambiguous;
    for (std::size_t p = 0; p < solved.network.points.size(); ++p)
      if (solved.network.points[p].role[0] != CoordinateRole::kAbsent) located.push_back(p);
    if (located.size() <= static_cast<std::size_t>(dimensions) + 1) return names;
    for (const std::size_t p : located)
      if (solved.network.points[p].role[0] != CoordinateRole::kFixed &&
          is_ambiguous(solved, static_cast<int>(p), dimensions))
        ambiguous.push_back(p);
    if (ambiguous.empty()) return names;
    for (const std::size_t p : ambiguous) {
      NetworkPoint& point = solved.network.points[p];
      std::fill_n(point.role.begin(), dimensions, CoordinateRole::kAbsent);
      names.push_back(point.id);
    }
    solved.unusable += remove_unusable(solved.network, true);
    if (solved.network.observations.empty() || network_columns(solved.network).size == 0) {
      solved.solution.status = NetworkStatus::kUndetermined;
      solved.undetermined.insert(solved.undetermined.end(), names.begin(), names.end());
      break;
    }
    solved.solution = adjust_network(solved.network);
  }
  return names;
}

}  // namespace octant::calib
