// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/check_network.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace octant::calib {
namespace {

tl::unexpected<Error> refuse(int line, std::string found, std::string expected) {
  return fail({.line = line, .found = std::move(found), .expected = std::move(expected)});
}

bool is_index(int i, std::size_t size) { return i >= 0 && static_cast<std::size_t>(i) < size; }

bool has_two_ends(SurveyKind kind) { return kind < SurveyKind::kX || kind > SurveyKind::kZ; }

bool has_valid_indices(const Network& n, const SurveyObservation& o) {
  const std::size_t points = n.points.size();
  const auto count = [](int size) { return static_cast<std::size_t>(std::max(size, 0)); };
  if (o.kind == SurveyKind::kConstant) return is_index(o.constant, count(n.constants));
  return is_index(o.from, points) && (!has_two_ends(o.kind) || is_index(o.to, points)) &&
         (o.kind != SurveyKind::kAngle || is_index(o.second, points)) &&
         (o.kind != SurveyKind::kDirection || is_index(o.set, count(n.sets))) &&
         (o.scale < 0 || is_index(o.scale, count(n.scales))) &&
         (o.constant < 0 || is_index(o.constant, count(n.constants))) &&
         (o.target_constant < 0 || is_index(o.target_constant, count(n.constants)));
}

/// True if two points are the same, or coincide in the plane and the observation is undefined there.
bool coincide(const Network& n, const SurveyObservation& o, int a, int b) {
  if (a == b) return true;
  const NetworkPoint& one = n.points[static_cast<std::size_t>(a)];
  const NetworkPoint& two = n.points[static_cast<std::size_t>(b)];
  if (o.kind > SurveyKind::kSlopeDistance || !one.known[0] || !one.known[1] || !two.known[0] || !two.known[1])
    return false;
  // The derivative of a distance and of an azimuth does not exist at distance zero.
  return (one.p_map_m - two.p_map_m).head<2>().norm() == 0.0 && o.kind != SurveyKind::kSlopeDistance;
}

Result<void> check_observation(const Network& n, const SurveyObservation& o) {
  if (!has_valid_indices(n, o))
    return refuse(o.line, "an observation whose point or set does not exist", "indices of the network");
  if (!std::isfinite(o.value)) return refuse(o.line, "an observed value that is not finite", "a number");
  if (!(o.sigma > 0.0) || !std::isfinite(o.sigma))
    return refuse(o.line, "a standard deviation that is not positive", "a positive number");
  if (o.from < 0 || !has_two_ends(o.kind)) return {};
  const auto name = [&](int p) { return n.points[static_cast<std::size_t>(p)].id; };
  if (coincide(n, o, o.from, o.to))
    return refuse(o.line, "an observation between coincident points " + name(o.from) + " and " + name(o.to),
                  "two points at different places");
  if (o.kind == SurveyKind::kAngle && coincide(n, o, o.from, o.second))
    return refuse(o.line,
                  "an observation between coincident points " + name(o.from) + " and " + name(o.second),
                  "two points at different places");
  return {};
}

}  // namespace

Result<void> check_network(const Network& network) {
  if (network.observations.empty())
    return refuse(0, "a network without observations that can be used", "observations of adjusted points");
  if (std::ranges::none_of(network.points, [](const NetworkPoint& p) {
        return std::ranges::any_of(p.role, [](CoordinateRole r) { return r >= CoordinateRole::kFree; });
      }))
    return refuse(0, "a network whose points are all fixed", "at least one adjusted coordinate");
  for (const NetworkPoint& p : network.points)
    if (!p.p_map_m.allFinite())
      return refuse(0, "point " + p.id + " with a coordinate that is not finite", "numbers");
  for (const SurveyObservation& o : network.observations)
    if (auto checked = check_observation(network, o); !checked) return checked;
  std::vector<bool> covered(network.observations.size(), false);
  for (const ObservationCovariance& block : network.covariances) {
    const Eigen::Index size = block.covariance.rows(), end = block.first + size;
    if (block.first < 0 || size == 0 || size != block.covariance.cols() ||
        end > static_cast<Eigen::Index>(network.observations.size()))
      return refuse(0, "a covariance matrix outside the observations", "as many rows as observations");
    const int line = network.observations[static_cast<std::size_t>(block.first)].line;
    for (auto i = static_cast<std::size_t>(block.first); i < static_cast<std::size_t>(end); ++i) {
      if (covered[i]) return refuse(line, "two covariance matrices of one observation", "one");
      covered[i] = true;
    }
    const Eigen::LLT<Eigen::MatrixXd> factor(block.covariance);
    if (!block.covariance.allFinite() || factor.info() != Eigen::Success)
      return refuse(line, "a covariance matrix that is not positive definite",
                    "variances above zero and correlations within (-1, 1)");
  }
  return {};
}

}  // namespace octant::calib
