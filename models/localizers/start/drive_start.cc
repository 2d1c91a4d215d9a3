// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/drive_start.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/localizers/least_squares/candidates.h"
#include "models/localizers/least_squares/search_problem.h"
#include "models/localizers/start/rigid_path.h"
#include "models/localizers/start/space_start.h"
#include "models/localizers/start/stretch_states.h"
#include "models/support/observed.h"
#include "models/trajectory/stretches.h"

namespace octant {
namespace {

constexpr std::size_t kMinRanges = 8;
constexpr double kClearScoreMargin = 8.0;  ///< in log likelihood; an ambiguous window can still grow
constexpr double kWindowGrowth = 1.4;
constexpr double kMaxHeadingSigma = 0.25;  ///< rad: limit for safe linearisation in the filter
constexpr double kMaxMeanCost =
    2.0;  ///< mean cost of an arrival: 0.5 for a perfect fit, the caps if no pose fits

/// Returns true if the best pose of a search is clearly better than the second, well determined, and explains
/// the arrivals.
bool is_clear(const SearchProblem& problem, const SearchResult& result, double max_sigma_m) {
  if (result.poses.empty()) return false;
  if (result.poses.size() > 1 && result.poses[1].score < result.poses[0].score + kClearScoreMargin)
    return false;
  if (result.poses[0].score >
      kMaxMeanCost * static_cast<double>(problem.ranges.size() + problem.bearings.size()))
    return false;
  Eigen::Matrix4d A = result.information[0];
  if (!problem.has_offset) A(3, 3) += 1.0;
  const ObservedState<Eigen::Matrix4d> observed(A);
  if (!observed.all()) return false;
  const Eigen::Matrix4d P = observed.covariance();
  return std::sqrt(P(0, 0) + P(1, 1)) < max_sigma_m && std::sqrt(P(2, 2)) < kMaxHeadingSigma;
}

/// First node with an arrival at or after a given one, or the end of the segment. Silent parts would only
/// waste the time of a window.
std::size_t heard_from(const Trajectory& t, const Segment& segment, std::size_t node) {
  const std::size_t at = first_of_node(t.arrivals, node, segment.first_arrival, segment.last_arrival);
  return at == segment.last_arrival ? segment.last_node : t.arrivals[at].node;
}

}  // namespace

bool place_stretch(Trajectory& t, const Segment& window, const EpochFixModel& model,
                   const TrackerOptions& options) {
  if (t.motion == Motion::kSpatial) return place_stretch_in_space(t, window, model, options);
  const std::size_t anchor = window.first_node + (window.last_node - window.first_node) / 2;
  const RigidPath path = rigid_path(t, window, anchor);
  SearchProblem problem = make_search_problem(t, window, model, options.range_uncertainty_m, path);
  if (problem.ranges.size() < kMinRanges || problem.groups() < 2) return false;
  thin_out(problem);
  SearchOptions search;
  // Fine enough that half a step moves the end of the path by a small part of the distances.
  search.headings = std::clamp(
      static_cast<int>(std::ceil(2 * std::numbers::pi * problem.lever_m / (0.1 * problem.span_m))), 16, 72);
  search.max_pairs = 60;
  search.keep = 24;
  const SearchResult result = search_pose(problem, search);
  const double scale_m = std::hypot(problem.median_sigma_m, options.range_uncertainty_m);
  if (!is_clear(problem, result, std::max(0.05 * problem.span_m, 2 * scale_m))) return false;
  const PlanarState& best = result.poses.front().state;
  lay_stretch(t, window, model, options.range_uncertainty_m,
              Pose::planar(best.x_m, best.y_m, best.heading_rad), path);
  return true;
}

DriveStart first_placed(const Trajectory& t, const Segment& segment, const StartWindows& windows,
                        std::size_t from_node, const std::function<bool(const Segment&)>& place) {
  DriveStart start;
  start.first_node = heard_from(t, segment, from_node);
  while (start.first_node + 2 <= segment.last_node) {
    const double begin_s = t.nodes[start.first_node].time_s, end_s = t.nodes[segment.last_node - 1].time_s;
    std::size_t last = start.first_node;
    for (double span_s = windows.first_s;; span_s *= kWindowGrowth) {
      while (last < segment.last_node && t.nodes[last].time_s <= begin_s + span_s) ++last;
      if (last >= start.first_node + 2 && place(stretch_of(t, segment, start.first_node, last))) {
        start.found = true;
        start.last_node = last;
        return start;
      }
      if (last == segment.last_node || span_s * kWindowGrowth > windows.longest_s) break;
    }
    if (begin_s + windows.longest_s >= end_s) break;  // the remaining windows are parts of this one
    start.first_node =
        heard_from(t, segment, start.first_node + std::max<std::size_t>((last - start.first_node) / 2, 1));
  }
  return start;
}

DriveStart find_start(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                      const TrackerOptions& options, std::size_t from_node) {
  return first_placed(t, segment, {options.start_window_s, options.max_start_window_s}, from_node,
                      [&](const Segment& stretch) { return place_stretch(t, stretch, model, options); });
}

}  // namespace octant
