// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/search_problem.h"
#include "models/support/scratch.h"
#include "models/trajectory/stretches.h"

namespace octant {

/// A stretch of a drive whose place is known.
struct DriveStart {
  bool found = false;
  std::size_t first_node = 0, last_node = 0;  ///< [first, last) of the stretch
};

/// What the uncertainty of roughly known beacons amounts to for arrivals that are counted as independent:
/// those of one beacon share its error until its direction has changed, say over half of a range driven, so
/// each of the n until then has sqrt(n) times the uncertainty. Without it hundreds of equally wrong ranges
/// would bend the odometry.
[[nodiscard]] double independent_uncertainty_m(const Trajectory& trajectory, const Segment& segment,
                                               const EpochFixModel& model, double uncertainty_m);

/// Widens the sigmas of a segment's arrivals by that, for as long as it lives.
class WidenedArrivals {
 public:
  WidenedArrivals(Trajectory& trajectory, const Segment& segment, const EpochFixModel& model,
                  double uncertainty_m);
  ~WidenedArrivals();
  WidenedArrivals(const WidenedArrivals&) = delete;
  WidenedArrivals& operator=(const WidenedArrivals&) = delete;

 private:
  Trajectory& trajectory_;
  std::size_t first_;
  std::pmr::vector<double> sigma_s_{scratch()};
};

/// Places a stretch if the arrivals settle it: the odometry is taken as a rigid piece, whose middle pose is
/// found as an epoch's is, with lever arms along the path; then its states are settled robustly. False:
/// nothing of it is clear.
[[nodiscard]] bool place_stretch(Trajectory& trajectory, const Segment& stretch, const EpochFixModel& model,
                                 const TrackerOptions& options);

/// Puts a stretch where its anchor's pose has it, and settles its states robustly.
void lay_stretch(Trajectory& trajectory, const Segment& stretch, const EpochFixModel& model,
                 double range_uncertainty_m, const Pose& T_map_anchor, const RigidPath& path);

/// Solves for the states of a stretch that lies about right: the last of what lay_stretch does.
void refine_stretch(Trajectory& trajectory, const Segment& stretch, const EpochFixModel& model,
                    double range_uncertainty_m);

/// Covariance (of the pose, as Motion has it) with which a filter may begin at a node of a stretch that was
/// placed: its marginal, inflated, because the stretch was solved robustly and its outliers are not marked.
[[nodiscard]] PoseCovariance start_covariance(Trajectory& trajectory, const Segment& stretch,
                                              const EpochFixModel& model, double range_uncertainty_m,
                                              std::size_t node);

/// Spans of the stretches that are tried.
struct StartWindows {
  double first_s = 0.0, longest_s = 0.0;
};

/// The first stretch at or after from_node that can be placed: from the first node at which anything is heard
/// windows grow up to the longest span, then from half a window on.
/// @param place  places a stretch, if it can be
[[nodiscard]] DriveStart first_placed(const Trajectory& trajectory, const Segment& segment,
                                      const StartWindows& windows, std::size_t from_node,
                                      const std::function<bool(const Segment&)>& place);

/// Searches the place of the first stretch at or after from_node that the arrivals settle: the odometry of a
/// window is taken as a rigid piece, whose middle pose is found as an epoch's is, with lever arms along the
/// path. The window grows until one pose is far better than any other, then its states are settled robustly.
/// Sets the nodes of the stretch, marks nothing.
[[nodiscard]] DriveStart find_start(Trajectory& trajectory, const Segment& segment,
                                    const EpochFixModel& model, const TrackerOptions& options,
                                    std::size_t from_node);

}  // namespace octant
