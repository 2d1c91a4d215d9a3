// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/localizers/least_squares/candidates.h"
#include "models/physics/pose.h"

namespace octant {
namespace {

/// Squared distance of two states in sigmas of the first.
double distance2(const PlanarState& a, const PlanarState& b, const Eigen::Matrix4d& information) {
  const Eigen::Vector4d d(b.x_m - a.x_m, b.y_m - a.y_m, wrap_angle(b.heading_rad - a.heading_rad),
                          b.offset_m - a.offset_m);
  return d.dot(information * d);
}

/// Narrows a candidate down to the noise and enters it if it is not there already.
void settle_into(const SearchProblem& problem, Consensus& consensus, PlanarState state, double width_m,
                 std::size_t without_group, SearchResult& result) {
  double extra = width_m;
  while (extra > 0.5 * problem.median_sigma_m) {
    consensus.set_extra_sigma(extra);
    consensus.refine(state, 3, without_group);
    extra *= 0.3;
  }
  consensus.set_extra_sigma(0.0);
  if (without_group != Consensus::kNone) consensus.refine(state, 6, without_group);
  const Eigen::Matrix4d information = consensus.refine(state, 10);
  const Candidate found{state, consensus.score(state)};
  if (!std::isfinite(found.score)) return;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    // The same place, come upon from two sides: keep the better.
    if (std::min(distance2(result.poses[i].state, state, result.information[i]),
                 distance2(state, result.poses[i].state, information)) > 9.0)
      continue;
    if (found.score < result.poses[i].score) {
      result.poses[i] = found;
      result.information[i] = information;
    }
    return;
  }
  result.poses.push_back(found);
  result.information.push_back(information);
}

void sort_by_score(SearchResult& result) {
  std::pmr::vector<std::size_t> order(result.poses.size(), scratch());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return result.poses[a].score != result.poses[b].score ? result.poses[a].score < result.poses[b].score
                                                          : a < b;
  });
  SearchResult sorted;
  for (const std::size_t i : order) {
    sorted.poses.push_back(result.poses[i]);
    sorted.information.push_back(result.information[i]);
  }
  result = std::move(sorted);
}

}  // namespace

SearchResult search_pose(const SearchProblem& problem, const SearchOptions& options) {
  SearchResult result;
  if (problem.ranges.empty() && problem.bearings.empty()) return result;
  Consensus consensus(problem);
  const bool by_pairs = !problem.has_offset && problem.groups() >= 2;
  // Half a step of the heading moves the end of the longest lever arm by this much.
  double width_m = 0.5 * problem.lever_m * std::numbers::pi / std::max(options.headings, 1);
  if (!by_pairs) width_m = std::max(width_m, 0.02 * problem.span_m);
  TopList top(options.keep, 2 * width_m + 5 * std::hypot(problem.median_sigma_m, problem.slack_m),
              1.2 * 2 * std::numbers::pi / options.headings);
  if (by_pairs) {
    consensus.set_extra_sigma(std::hypot(width_m, problem.median_sigma_m));
    propose_from_pairs(problem, options, consensus, top);
  } else {
    propose_from_grid(problem, options, consensus, top);
  }
  width_m = std::max(width_m, problem.median_sigma_m);
  for (const Candidate& candidate : top.list())
    settle_into(problem, consensus, candidate.state, width_m, Consensus::kNone, result);
  if (result.poses.empty()) return result;
  sort_by_score(result);
  // Where something does not fit the best pose, another beacon may be the one that is wrong: try without
  // each.
  const double fits = 0.5 * static_cast<double>(problem.ranges.size()) + 3.0;
  if (problem.common_bias && problem.slack_m == 0.0 && problem.groups() >= 3 &&
      result.poses.front().score > fits) {
    const PlanarState best = result.poses.front().state;
    for (std::size_t group = 0; group < problem.groups(); ++group)
      settle_into(problem, consensus, best, 30 * problem.median_sigma_m, group, result);
    sort_by_score(result);
  }
  return result;
}

}  // namespace octant
