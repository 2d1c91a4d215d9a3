// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/localizers/least_squares/candidates.h"
#include "models/localizers/least_squares/rivals.h"
#include "models/physics/pose.h"

namespace octant {
namespace {

/// Squared distance of two states in sigmas of the first.
double distance2(const PlanarState& a, const PlanarState& b, const Eigen::Matrix4d& information) {
  const Eigen::Vector4d d(b.x_m - a.x_m, b.y_m - a.y_m, wrap_angle(b.heading_rad - a.heading_rad),
                          b.offset_m - a.offset_m);
  return d.dot(information * d);
}

constexpr double kSlack = 4.0;         ///< what a pose that is not settled yet may still gain, of its score
constexpr double kShadowWidth = 30.0;  ///< from how many sigmas on a pose is settled without a beacon
/// An outlier of fewer sigmas may bend the pose that it is held against; of more it cannot.
constexpr double kOutlierSigmas = 3.5, kLargeSigmas = 50.0;

struct Settling {
  double width_m = 0.0;
  std::size_t without_group = Consensus::kNone;
  /// At the first width, and without the group: a score beyond it is given up, which is below any that a
  /// narrower width finds there.
  double give_up = std::numeric_limits<double>::infinity();
};

bool is_near(const PlanarState& a, const PlanarState& b, double within_m, double lever_m) {
  return std::abs(a.x_m - b.x_m) < within_m && std::abs(a.y_m - b.y_m) < within_m &&
         std::abs(wrap_angle(a.heading_rad - b.heading_rad)) * lever_m < within_m;
}

/// Enters a settled pose if it is not there already.
void enter(Consensus& consensus, const PlanarState& state, const Eigen::Matrix4d& information,
           SearchResult& result) {
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

/// Narrows a candidate down to the noise and enters it.
void settle_into(const SearchProblem& problem, Consensus& consensus, PlanarState state,
                 const Settling& settling, SearchResult& result) {
  const bool bounded = std::isfinite(settling.give_up);
  double extra = settling.width_m;
  for (bool first = true; extra > 0.5 * problem.median_sigma_m; first = false) {
    consensus.set_extra_sigma(extra);
    consensus.refine(state, 3, settling.without_group);
    if (bounded && first && settling.without_group == Consensus::kNone) {
      if (consensus.score(state) > settling.give_up) return;
      for (const Candidate& known : result.poses)
        if (is_near(known.state, state, 0.3 * extra, problem.lever_m)) return;
    }
    extra *= 0.3;
  }
  consensus.set_extra_sigma(0.0);
  if (settling.without_group != Consensus::kNone) {
    consensus.refine(state, 6, settling.without_group);
    if (bounded && consensus.score(state) > settling.give_up) return;
  }
  const Eigen::Matrix4d information = consensus.refine(state, 10);
  enter(consensus, state, information, result);
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

/// Half a step of the heading moves the end of the longest lever arm by this much.
double heading_width_m(const SearchProblem& problem, const SearchOptions& options) {
  return 0.5 * problem.lever_m * std::numbers::pi / std::max(options.headings, 1);
}

TopList top_list(const SearchProblem& problem, const SearchOptions& options, double width_m) {
  return TopList(options.keep, 2 * width_m + 5 * std::hypot(problem.median_sigma_m, problem.slack_m),
                 1.2 * 2 * std::numbers::pi / options.headings);
}

/// Where something does not fit the best pose, another beacon may be the one that is wrong: try without each.
void try_without_each_beacon(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                             SearchResult& result) {
  const double fits = 0.5 * static_cast<double>(problem.ranges.size()) + 3.0;
  if (!problem.common_bias || problem.slack_m != 0.0 || problem.groups() < 3 ||
      !(result.poses.front().score > fits))
    return;
  const Candidate best = result.poses.front();
  const Eigen::Matrix4d information = result.information.front();
  consensus.set_extra_sigma(0.0);
  const bool clear =
      options.start && !consensus.has_residual_between(best.state, kOutlierSigmas, kLargeSigmas);
  for (std::size_t group = 0; group < problem.groups(); ++group) {
    if (clear) {
      // A few steps from the best tell whether there is anything without this beacon.
      PlanarState state = best.state;
      consensus.set_extra_sigma(0.0);
      consensus.refine(state, 3, group);
      if (distance2(best.state, state, information) < 4.0 ||
          consensus.score(state) > best.score + options.margin + kSlack)
        continue;
    }
    settle_into(problem, consensus, best.state,
                {.width_m = kShadowWidth * problem.median_sigma_m,
                 .without_group = group,
                 .give_up = options.start ? best.score + options.margin + kSlack
                                          : std::numeric_limits<double>::infinity()},
                result);
  }
  sort_by_score(result);
}

/// What the pairs propose that is not known yet and scores about as well as the best.
void propose_rivals(const SearchProblem& problem, const SearchOptions& options,
                    std::span<const std::array<std::size_t, 2>> pairs, Consensus& consensus,
                    SearchResult& result) {
  const double width_m = heading_width_m(problem, options);
  TopList top = top_list(problem, options, width_m);
  consensus.set_extra_sigma(std::hypot(width_m, problem.median_sigma_m));
  propose_from_pairs(problem, pairs, options.headings, consensus, top);
  for (const Candidate& candidate : top.list())
    settle_into(problem, consensus, candidate.state,
                {.width_m = std::max(width_m, problem.median_sigma_m),
                 .give_up = result.poses.front().score + options.margin + kSlack},
                result);
  sort_by_score(result);
}

/// The search from a start: it is settled, and only what could be its rival is looked for. False where too
/// little speaks for what has been found.
bool search_rivals(const SearchProblem& problem, const SearchOptions& options, SearchResult& result) {
  Consensus consensus(problem);
  const double width_m = std::max(heading_width_m(problem, options), problem.median_sigma_m);
  const double misfit_m = 1.5 * consensus.middle_misfit_m(*options.start);
  settle_into(problem, consensus, *options.start,
              {.width_m = std::clamp(misfit_m, width_m, std::max(width_m, problem.span_m))}, result);
  if (result.poses.empty()) return false;
  const auto outliers = [&] {
    consensus.set_extra_sigma(0.0);
    return most_outliers(consensus, result.poses.front().score, options.margin);
  };
  const std::size_t expected = outliers(), beacons = problem.groups();
  // Where what agrees has a second pose even without any outliers, all depends on finding it.
  if (!excludes_rivals(problem, consensus, result.poses.front().state, 0)) {
    result = SearchResult();
    return false;
  }
  if (!excludes_rivals(problem, consensus, result.poses.front().state, expected)) {
    // First a few, which find the pose where the start has not.
    const std::size_t few = std::min(expected, beacons / 2 - 1);
    propose_rivals(problem, options, covering_pairs(problem, few), consensus, result);
    const std::size_t most = outliers();
    if (most > few)
      propose_rivals(problem, options,
                     most + 2 > beacons ? choose_pairs(problem, static_cast<std::size_t>(options.max_pairs))
                                        : covering_pairs(problem, most),
                     consensus, result);
  }
  try_without_each_beacon(problem, options, consensus, result);
  return true;
}

}  // namespace

SearchResult search_pose(const SearchProblem& problem, const SearchOptions& options) {
  SearchResult result;
  if (problem.ranges.empty() && problem.bearings.empty()) return result;
  const bool by_pairs = !problem.has_offset && problem.groups() >= 2;
  if (options.start) {
    if (by_pairs && search_rivals(problem, options, result)) return result;
    SearchOptions from_nothing = options;
    from_nothing.start.reset();
    return search_pose(problem, from_nothing);
  }
  Consensus consensus(problem);
  double width_m = heading_width_m(problem, options);
  if (!by_pairs) width_m = std::max(width_m, 0.02 * problem.span_m);
  TopList top = top_list(problem, options, width_m);
  if (by_pairs) {
    consensus.set_extra_sigma(std::hypot(width_m, problem.median_sigma_m));
    propose_from_pairs(problem, options, consensus, top);
  } else {
    propose_from_grid(problem, options, consensus, top);
  }
  width_m = std::max(width_m, problem.median_sigma_m);
  for (const Candidate& candidate : top.list())
    settle_into(problem, consensus, candidate.state, {.width_m = width_m}, result);
  if (result.poses.empty()) return result;
  sort_by_score(result);
  try_without_each_beacon(problem, options, consensus, result);
  return result;
}

}  // namespace octant
