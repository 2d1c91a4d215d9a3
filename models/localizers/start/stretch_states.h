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

/// Converts the uncertainty of roughly known beacons for arrivals that are treated as independent. The
/// arrivals of a beacon share its error until its direction changes, about over half of its range, so each of
/// n such arrivals gets sqrt(n) times the uncertainty. Otherwise hundreds of equally wrong ranges would bend
/// the odometry.
[[nodiscard]] double independent_uncertainty_m(const Trajectory& trajectory, const Segment& segment,
                                               const EpochFixModel& model, double uncertainty_m);

/// Increases the sigmas of a segment's arrivals by this uncertainty during its lifetime.
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

/// Sets the states of a part from the pose of its anchor and solves them robustly.
void lay_stretch(Trajectory& trajectory, const Segment& stretch, const EpochFixModel& model,
                 double range_uncertainty_m, const Pose& T_map_anchor, const RigidPath& path);

/// Solves the states of a part that are approximately right: the last step of lay_stretch.
void refine_stretch(Trajectory& trajectory, const Segment& stretch, const EpochFixModel& model,
                    double range_uncertainty_m);

/// Covariance of the pose with which a filter may start at a node. This is the marginal of the solved states,
/// inflated because they were solved robustly without marking outliers.
[[nodiscard]] PoseCovariance start_covariance(Trajectory& trajectory, const Segment& stretch,
                                              const EpochFixModel& model, double range_uncertainty_m,
                                              std::size_t node);

}  // namespace octant
