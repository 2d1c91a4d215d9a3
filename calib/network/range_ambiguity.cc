// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/range_ambiguity.h"

#include <algorithm>
#include <cmath>

#include "calib/network/select_observations.h"
#include "calib/network/survey_row.h"
#include "calib/problem/trilaterate.h"

namespace octant::calib {
namespace {

/// Difference of half squares below which two positions fit equally well.
constexpr double kEqualFit = 4.0;
/// Distance of two positions, in sigmas, below which they are the same.
constexpr double kSamePosition = 4.0;
/// Redundant ranges of a point from which they contradict every position without another one of them.
constexpr std::size_t kMostSpare = 2;

/// One point with its ranges to others, which keep their adjusted positions.
struct Resection {
  std::vector<RangeFrom> ranges, left_out;  ///< without the delays
  std::vector<double> sigmas_m;
  TrilaterationOptions options;
  Eigen::Vector3d given_m = Eigen::Vector3d::Zero(),
                  weight = Eigen::Vector3d::Zero();  ///< observed coordinates

  [[nodiscard]] double half_squares(const std::vector<RangeFrom>& from, const Eigen::Vector3d& p_m) const {
    double sum = (p_m - given_m).cwiseAbs2().dot(weight);
    for (std::size_t i = 0; i < from.size(); ++i)
      sum += std::pow(((from[i].p_map_m - p_m).norm() - from[i].range_m) / sigmas_m[i], 2);
    return 0.5 * sum;
  }
};

Resection resection_of(const SolvedNetwork& solved, int p, int dimensions) {
  Resection at;
  const NetworkColumns columns = network_columns(solved.network);
  const auto is_located = [&](int point) {
    return solved.network.points[static_cast<std::size_t>(point)].role[0] != CoordinateRole::kAbsent;
  };
  const Eigen::Vector3d& here = solved.solution.points_m[static_cast<std::size_t>(p)];
  // The computed range and the misclosure are the observed range without the delays.
  const auto range_of = [&](const SurveyObservation& o) -> RangeFrom {
    const Eigen::Vector3d& there =
        solved.solution.points_m[static_cast<std::size_t>(o.from == p ? o.to : o.from)];
    return {there, (there - here).norm() +
                       survey_row(solved.network, columns, o, solved.solution.unknowns).misclosure};
  };
  for (const SurveyObservation& o : solved.network.observations) {
    const int axis = static_cast<int>(o.kind) - static_cast<int>(SurveyKind::kX);
    if (o.kind == SurveyKind::kSlopeDistance && (o.from == p || o.to == p)) {
      at.ranges.push_back(range_of(o));
      at.sigmas_m.push_back(o.sigma);
    } else if (o.from == p && axis >= 0 && axis < dimensions) {
      at.given_m[axis] = o.value;
      at.weight[axis] = std::pow(o.sigma, -2);
    }
  }
  for (const SurveyObservation& o : solved.outlying)
    if ((o.from == p || o.to == p) && is_located(o.from) && is_located(o.to))
      at.left_out.push_back(range_of(o));
  at.options = {.held = {false, false, dimensions == 2}, .guess = here, .above = false};
  if (!at.sigmas_m.empty()) at.options.scale_m = std::ranges::max(at.sigmas_m);
  return at;
}

/// Fits another position equally well: a mirror image, or the one without another range than those that were
/// left out?
bool is_ambiguous(const SolvedNetwork& solved, int p, int dimensions) {
  const Resection at = resection_of(solved, p, dimensions);
  if (at.ranges.empty()) return false;
  const auto point = static_cast<std::size_t>(p);
  const Eigen::Vector3d& here = solved.solution.points_m[point];
  const double sigma_m =
      std::sqrt(solved.solution.point_covariances_m2[point].topLeftCorner(dimensions, dimensions).trace());
  const double best = at.half_squares(at.ranges, here);
  const auto is_equal = [&](const std::vector<RangeFrom>& ranges, const Eigen::Vector3d& other) {
    return (other - here).norm() > kSamePosition * sigma_m &&
           at.half_squares(ranges, other) - best < kEqualFit;
  };
  if (const auto image = mirror_image_of(here, at.ranges, at.options); image && is_equal(at.ranges, *image))
    return true;
  if (at.ranges.size() > static_cast<std::size_t>(dimensions) + kMostSpare) return false;
  for (const RangeFrom& left_out : at.left_out)
    for (std::size_t k = 0; k < at.ranges.size(); ++k) {
      std::vector<RangeFrom> exchanged = at.ranges;
      exchanged[k] = left_out;
      if (is_equal(exchanged, trilaterate(exchanged, at.options).p_map_m)) return true;
    }
  return false;
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
