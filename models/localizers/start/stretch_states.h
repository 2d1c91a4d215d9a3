// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/fix.h"
#include "models/localizers/least_squares/search_problem.h"
#include "models/support/scratch.h"
#include "models/trajectory/trajectory.h"

namespace octant {

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

}  // namespace octant
