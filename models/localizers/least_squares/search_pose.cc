// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "models/localizers/least_squares/candidates.h"
#include "models/localizers/least_squares/pair_places.h"
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

constexpr double kScoreMargin = 4.0;   ///< possible decrease of the score of a pose before it has converged
constexpr double kBetterScore = 2.0;   ///< decrease of the score that makes a nearby pose a different one
constexpr double kShadowWidth = 30.0;  ///< width in sigmas from which on a pose is solved without a beacon
/// An outlier of few sigmas may distort the pose from which it is judged; a large one cannot.
constexpr double kOutlierSigmas = 3.5, kLargeSigmas = 50.0;

struct Refinement {
  double width_m = 0.0;
  std::size_t without_group = Consensus::kNone;
  /// At the first width, and without the group: candidates with a score above it are dropped. Narrower widths
  /// cannot fall below it there.
  double give_up = std::numeric_limits<double>::infinity();
};

bool is_near(const PlanarState& a, const PlanarState& b, double within_m, double lever_m) {
  return std::abs(a.x_m - b.x_m) < within_m && std::abs(a.y_m - b.y_m) < within_m &&
         std::abs(wrap_angle(a.heading_rad - b.heading_rad)) * lever_m < within_m;
}

/// Adds a solved pose unless it is known.
void enter(Consensus& consensus, const PlanarState& state, const Eigen::Matrix4d& information,
           SearchResult& result) {
  const Candidate found{state, consensus.score(state)};
  if (!std::isfinite(found.score)) return;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    // A position reached from two sides is one pose: keep the better one.
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

/// Returns true if a state near a known pose does not explain more than that pose at the current width. If
/// the known pose has a shadowed beacon, the pose that all beacons agree on may lie within the width of it.
bool explains_no_more(Consensus& consensus, const PlanarState& state, const PlanarState& known) {
  return consensus.score(state) > consensus.score(known) - kBetterScore;
}

/// Runs the first steps of a candidate; returns true if it approaches a new pose and is not dropped.
bool leads_to_new(const SearchProblem& problem, Consensus& consensus, PlanarState& state,
                  const Refinement& refinement, const SearchResult& result) {
  Consensus::Descent descent;
  for (int k = 0; k < 3; ++k) {
    consensus.refine(state, 1, Consensus::kNone, descent);
    for (const Candidate& known : result.poses)
      if (is_near(known.state, state, refinement.width_m, problem.lever_m) &&
          explains_no_more(consensus, state, known.state))
        return false;
  }
  return consensus.score(state) <= refinement.give_up;
}

/// Returns true if a state, refined without a beacon, is within a sigma of a known pose and explains no more
/// than that. If the known pose has a shadowed beacon, nothing else may distinguish them.
bool leads_back(Consensus& consensus, const PlanarState& state, const SearchResult& result) {
  for (std::size_t i = 0; i < result.poses.size(); ++i)
    if (distance2(result.poses[i].state, state, result.information[i]) < 1.0)
      return explains_no_more(consensus, state, result.poses[i].state);
  return false;
}

/// Refines a candidate to the noise level and adds it.
void refine_into(const SearchProblem& problem, Consensus& consensus, PlanarState state,
                 const Refinement& refinement, SearchResult& result) {
  const bool bounded = std::isfinite(refinement.give_up);
  double extra = refinement.width_m;
  for (bool first = true; extra > 0.5 * problem.median_sigma_m; first = false) {
    consensus.set_extra_sigma(extra);
    if (bounded && first && refinement.without_group == Consensus::kNone) {
      if (!leads_to_new(problem, consensus, state, refinement, result)) return;
    } else {
      consensus.refine(state, 3, refinement.without_group);
    }
    extra *= 0.3;
  }
  consensus.set_extra_sigma(0.0);
  if (refinement.without_group != Consensus::kNone) {
    consensus.refine(state, 2, refinement.without_group);
    if (bounded && leads_back(consensus, state, result)) return;
    consensus.refine(state, 4, refinement.without_group);
    if (bounded && (leads_back(consensus, state, result) || consensus.score(state) > refinement.give_up))
      return;
  }
  const Eigen::Matrix4d information = consensus.refine(state, 10);
  enter(consensus, state, information, result);
}

void sort_by_score(SearchResult& result) {
  std::pmr::vector<std::size_t> order(result.poses.size(), scratch());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
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

/// Displacement of the end of the longest lever arm by half a step of the heading.
double heading_width_m(const SearchProblem& problem, const SearchOptions& options) {
  return 0.5 * problem.lever_m * std::numbers::pi / std::max(options.headings, 1);
}

TopList top_list(const SearchProblem& problem, const SearchOptions& options, double width_m) {
  return TopList(options.keep, 2 * width_m + 5 * std::hypot(problem.median_sigma_m, problem.uncertainty_m),
                 1.2 * 2 * std::numbers::pi / options.headings);
}

/// If something does not fit the best pose, another beacon may be the wrong one: tries without each of them.
void try_without_each_beacon(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                             SearchResult& result) {
  const double fits = 0.5 * static_cast<double>(problem.ranges.size()) + 3.0;
  if (!problem.common_bias || problem.uncertainty_m != 0.0 || problem.groups() < 3 ||
      !(result.poses.front().score > fits))
    return;
  const Candidate best = result.poses.front();
  const Eigen::Matrix4d information = result.information.front();
  consensus.set_extra_sigma(0.0);
  const bool clear =
      options.bounded && !consensus.has_residual_between(best.state, kOutlierSigmas, kLargeSigmas);
  for (std::size_t group = 0; group < problem.groups(); ++group) {
    if (clear) {
      // A few steps from the best pose reveal whether there is another one without this beacon.
      PlanarState state = best.state;
      consensus.set_extra_sigma(0.0);
      consensus.refine(state, 1, group);
      if (distance2(best.state, state, information) < 1.0) continue;
      consensus.refine(state, 2, group);
      if (distance2(best.state, state, information) < 4.0 ||
          consensus.score(state) > best.score + options.margin + kScoreMargin)
        continue;
    }
    refine_into(problem, consensus, best.state,
                {.width_m = kShadowWidth * problem.median_sigma_m,
                 .without_group = group,
                 .give_up = options.bounded ? best.score + options.margin + kScoreMargin
                                            : std::numeric_limits<double>::infinity()},
                result);
  }
  sort_by_score(result);
}

constexpr std::size_t kFewPairs = 6;    ///< one of them most likely leads to a pose
constexpr std::size_t kFewBeacons = 4;  ///< with so few beacons all pairs are tried at once

/// Finds all poses that score within the bound among those that pairs allow. Regions are visited in order of
/// their promise, so that the bound decreases early. Regions of pairs that a known pose explains lead to that
/// pose, so one of them suffices.
class Exploration {
 public:
  Exploration(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
              const Discord& discord, SearchResult& result)
      : problem_(problem),
        options_(options),
        consensus_(consensus),
        discord_(discord),
        result_(result),
        width_m_(heading_width_m(problem, options)) {
    consensus.set_extra_sigma(0.0);
    places_.emplace(problem, consensus, discord, problem.lever_m > 1e-6 ? options.headings : 1);
  }

  /// Finds any pose, which then bounds the others.
  void find_one(std::span<const std::array<std::size_t, 2>> pairs) {
    visit_places(pairs.first(std::min(pairs.size(), kFewPairs)), true);
    if (result_.poses.empty()) visit_places(pairs, true);
    sort_by_score(result_);
  }
  /// @param one_pose  true if the arrivals in agreement with the best pose determine it uniquely
  void visit(std::span<const std::array<std::size_t, 2>> pairs, bool one_pose) {
    skip_known_ = one_pose;
    // The bound was not lower when a pair was visited before.
    std::pmr::vector<std::array<std::size_t, 2>> fresh(scratch());
    fresh.reserve(pairs.size());
    for (const auto& pair : pairs)
      if (std::ranges::find(visited_, pair) == visited_.end()) fresh.push_back(pair);
    visit_places(fresh, false);
    visited_.insert(visited_.end(), fresh.begin(), fresh.end());
    sort_by_score(result_);
  }

 private:
  void visit_places(std::span<const std::array<std::size_t, 2>> pairs, bool until_found) {
    TopList top = top_list(problem_, options_, width_m_);
    consensus_.set_extra_sigma(std::hypot(width_m_, problem_.median_sigma_m));
    double lowest = std::numeric_limits<double>::infinity();
    for (const Candidate& pose : result_.poses) lowest = std::min(lowest, consensus_.score(pose.state));
    std::pmr::vector<double> refined(scratch());  // scores of poses that lowered the bound
    for (PairPlace& place : places_->within(pairs, bound())) {
      if (place.least_score > bound()) continue;
      if (place.is_flat) {
        const auto part = places_->narrowed(place, bound());
        if (!part) continue;
        place = *part;
      }
      if (skip_known_ && leads_to_known(place) && std::exchange(known_seen_, true)) continue;
      consensus_.set_extra_sigma(std::hypot(width_m_, problem_.median_sigma_m));
      places_->propose(place, consensus_, bound(), top);
      if (top.list().empty() || !(top.list().front().score < lowest)) continue;
      // The best pose so far may lower the bound for all others.
      lowest = top.list().front().score;
      refined.push_back(lowest);
      refine_at(top.list().front().state);
      if (until_found && !result_.poses.empty()) return;
      skip_known_ = skip_known_ || best_is_one_pose();
    }
    for (const Candidate& candidate : top.list())
      if (candidate.least_score <= bound() && std::ranges::find(refined, candidate.score) == refined.end())
        refine_at(candidate.state);
  }

  /// Returns true if the arrivals in agreement with the best pose determine it uniquely.
  [[nodiscard]] bool best_is_one_pose() {
    const auto better = [](const Candidate& a, const Candidate& b) { return a.score < b.score; };
    const auto best = std::ranges::min_element(result_.poses, better);
    if (best == result_.poses.end()) return false;
    consensus_.set_extra_sigma(0.0);
    return excludes_rivals(problem_, consensus_, discord_, best->state, 0);
  }

  /// Bound from the poses that have been solved.
  [[nodiscard]] double bound() const {
    double best = std::numeric_limits<double>::infinity();
    for (const Candidate& pose : result_.poses) best = std::min(best, pose.score);
    return best + options_.margin;
  }

  void refine_at(const PlanarState& state) {
    refine_into(problem_, consensus_, state,
                {.width_m = std::max(width_m_, problem_.median_sigma_m), .give_up = bound() + kScoreMargin},
                result_);
  }

  bool leads_to_known(const PairPlace& place) {
    for (const Candidate& pose : result_.poses)
      if (!place.is_long &&
          std::hypot(pose.state.x_m - place.x_m, pose.state.y_m - place.y_m) <
              (place.is_flat ? place.reach_m : std::min(place.reach_m, place.half_gap_m)) &&
          consensus_.explains(pose.state, place.pair))
        return true;
    return false;
  }

  const SearchProblem& problem_;
  const SearchOptions& options_;
  Consensus& consensus_;
  const Discord& discord_;
  SearchResult& result_;
  double width_m_;
  std::optional<PairPlaces> places_;
  std::pmr::vector<std::array<std::size_t, 2>> visited_{scratch()};
  bool skip_known_ = false;
  bool known_seen_ = false;  ///< headings at the pose found from the start are tried only once
};

/// Search among known beacons: finds the best pose, starting from the expected one if given, and uses its
/// score as a bound for rivals.
SearchResult search_within_bounds(const SearchProblem& problem, const SearchOptions& options) {
  SearchResult result;
  Consensus consensus(problem);
  const Discord discord = discord_of(problem, consensus);
  if (options.start) {
    const double width_m = std::max(heading_width_m(problem, options), problem.median_sigma_m);
    const double misfit_m = 1.5 * consensus.middle_misfit_m(*options.start);
    refine_into(problem, consensus, *options.start,
                {.width_m = std::clamp(misfit_m, width_m, std::max(width_m, problem.span_m))}, result);
  }
  Exploration exploration(problem, options, consensus, discord, result);
  const auto excluded_with = [&](std::size_t outliers) {
    consensus.set_extra_sigma(0.0);
    return excludes_rivals(problem, consensus, discord, result.poses.front().state, outliers);
  };
  const std::size_t beacons = problem.groups(), most_pairs = static_cast<std::size_t>(options.max_pairs);
  if (result.poses.empty()) exploration.find_one(choose_pairs(problem, most_pairs));
  if (result.poses.empty()) return result;
  const auto outliers = [&] {
    consensus.set_extra_sigma(0.0);
    return most_outliers(consensus, discord, result.poses.front().score, options.margin);
  };
  if (const std::size_t expected = outliers(); !excluded_with(expected)) {
    // Tries few pairs first, which find the pose if the start has not.
    const std::size_t few = std::min(expected, beacons / 2 - 1);
    bool one_pose = excluded_with(0);
    if (one_pose || (expected + 2 > beacons && beacons > kFewBeacons)) {
      exploration.visit(covering_pairs(problem, discord, few), one_pose);
      one_pose = excluded_with(0);
    }
    const std::size_t most = outliers();
    // If the arrivals in agreement have a second pose even without outliers, it must be found.
    if (most + 2 > beacons || !one_pose)
      exploration.visit(choose_pairs(problem, most_pairs), one_pose);
    else if (most > few && !excluded_with(most))
      exploration.visit(covering_pairs(problem, discord, most), true);
  }
  try_without_each_beacon(problem, options, consensus, result);
  return result;
}

}  // namespace

SearchResult search_pose(const SearchProblem& problem, const SearchOptions& options) {
  SearchResult result;
  if (problem.ranges.empty() && problem.bearings.empty()) return result;
  const bool by_pairs = !problem.has_offset && problem.groups() >= 2;
  if (options.bounded && by_pairs && problem.common_bias && problem.uncertainty_m == 0.0)
    result = search_within_bounds(problem, options);
  // If no two ranges are compatible, the best pose is still reported.
  if (!result.poses.empty()) return result;
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
    refine_into(problem, consensus, candidate.state, {.width_m = width_m}, result);
  if (result.poses.empty()) return result;
  sort_by_score(result);
  try_without_each_beacon(problem, options, consensus, result);
  return result;
}

}  // namespace octant
