// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/rough_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "models/localizers/start/drive_start.h"
#include "models/localizers/start/rigid_path.h"
#include "models/localizers/start/space_follow.h"
#include "models/localizers/start/space_start.h"
#include "models/trajectory/stretches.h"

namespace octant {
namespace {

/// Duration of the first window, since shorter pieces are never well determined among such beacons, and of
/// the longest one in which odometry preserves the shape of the path. If no piece is clear, longer windows
/// are a last resort.
constexpr double kFirstWindow_s = 8.0, kLongest_s = 45.0;
/// Cost differences: a pose is clearly better than the others, and a pose is worth following.
constexpr double kClearlyBetter = 8.0, kWorthFollowing = 16.0;
constexpr std::size_t kMostFollowed = 6;
constexpr double kFollowed_s = 60.0;  ///< in each direction

/// Part of a segment around a given part, extended by a time in both directions.
Segment around(const Trajectory& t, const Segment& segment, const Segment& stretch, double by_s) {
  const double from_s = t.nodes[stretch.first_node].time_s - by_s,
               to_s = t.nodes[stretch.last_node - 1].time_s + by_s;
  std::size_t first = stretch.first_node, last = stretch.last_node;
  while (first > segment.first_node && t.nodes[first - 1].time_s >= from_s) --first;
  while (last < segment.last_node && t.nodes[last].time_s <= to_s) ++last;
  return stretch_of(t, segment, first, last);
}

/// Cost of all arrivals around a part when it is extended from one of its poses.
double cost_of(Trajectory& t, const Segment& part, const Segment& stretch, const LikelyPose& pose,
               const RigidPath& path, const EpochFixModel& model, const TrackerOptions& options) {
  lay_rigidly(t, stretch, pose.T_map_anchor, path);
  const RoughPieces back = follow_roughly(t, part, model, options, stretch.first_node, false),
                    on = follow_roughly(t, part, model, options, stretch.last_node - 1, true);
  if (on.reached + 1 < part.last_node) return INFINITY;  // the path was lost
  return pose.cost + back.cost + on.cost;
}

/// Sets the pose of a part if it is clearly more likely than all others.
bool lay_clearly(Trajectory& t, const Segment& segment, const Segment& stretch, const EpochFixModel& model,
                 const TrackerOptions& options) {
  const std::size_t anchor = stretch.first_node + (stretch.last_node - stretch.first_node) / 2;
  const RigidPath path = rigid_path(t, stretch, anchor);
  const std::vector<LikelyPose> likely = likely_poses(t, stretch, model, options, path, kWorthFollowing);
  if (likely.empty() || likely.size() > kMostFollowed || !likely.front().tight) return false;
  std::size_t best = 0;
  if (likely.size() > 1) {
    const Segment part = around(t, segment, stretch, kFollowed_s);
    std::vector<double> costs;
    for (const LikelyPose& pose : likely)
      costs.push_back(cost_of(t, part, stretch, pose, path, model, options));
    best = static_cast<std::size_t>(std::ranges::min_element(costs) - costs.begin());
    for (std::size_t i = 0; i < costs.size(); ++i)
      if (i != best && !(costs[i] >= costs[best] + kClearlyBetter)) return false;
  }
  lay_rigidly(t, stretch, likely[best].T_map_anchor, path);
  return true;
}

}  // namespace

bool place_roughly(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                   const TrackerOptions& options) {
  std::size_t from = segment.first_node;
  std::vector<PoseObservation> pieces;
  const auto take = [&pieces](const RoughPieces& more) {
    pieces.insert(pieces.end(), more.poses.begin(), more.poses.end());
  };
  const auto lay = [&](const Segment& stretch) { return lay_clearly(t, segment, stretch, model, options); };
  while (from + 2 <= segment.last_node) {
    DriveStart start;
    for (const double longest_s : {kLongest_s, options.max_start_window_s})
      if (!start.found) start = first_placed(t, segment, {kFirstWindow_s, longest_s}, from, lay);
    if (!start.found) break;
    const bool first = pieces.empty();
    pieces.push_back(rough_pose(t, (start.first_node + start.last_node) / 2, options.range_uncertainty_m));
    if (first) take(follow_roughly(t, segment, model, options, start.first_node, false));
    const RoughPieces on = follow_roughly(t, segment, model, options, start.last_node - 1, true);
    take(on);
    from = on.reached;
  }
  if (pieces.empty()) return false;
  // Nodes without a pose follow odometry, so that the adjustment has all states.
  static_cast<void>(follow_odometry(t, segment, from, true));
  join_pieces(t, segment, model.state, pieces, options.threads);
  return true;
}

}  // namespace octant
