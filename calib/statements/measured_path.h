// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// Relative time within a recording, from -0.5 (start) to 0.5 (end).
[[nodiscard]] inline double share_of_span(const std::pair<double, double>& span_s, double time_s) {
  return (time_s - span_s.first) / (span_s.second - span_s.first) - 0.5;
}

/// Time of a measured pose as an observation.
[[nodiscard]] inline double time_of(const Trajectory& t, const PoseObservation& pose) {
  const double before_s = t.nodes[pose.node].time_s;
  return pose.alpha > 0.0 ? before_s + pose.alpha * (t.nodes[pose.node + 1].time_s - before_s) : before_s;
}

/// Measured poses of a trajectory as a function of time.
class MeasuredPath {
 public:
  explicit MeasuredPath(const Trajectory& t) : t_(&t) {
    for (const PoseObservation& p : t.poses) times_s_.push_back(time_of(t, p));
  }
  [[nodiscard]] const Trajectory* trajectory() const { return t_; }

  /// Interpolates between two poses (linear, slerp) and extrapolates linearly beyond the ends.
  [[nodiscard]] Pose at(double time_s) const {
    const std::size_t n = times_s_.size();
    const auto next = static_cast<std::size_t>(std::ranges::lower_bound(times_s_, time_s) - times_s_.begin());
    const std::size_t b = std::clamp<std::size_t>(next, 1, n - 1), a = b - 1;
    const double step_s = times_s_[b] - times_s_[a];
    if (!(step_s > 0.0)) return t_->poses[a].T_map_vehicle;
    const double share = (time_s - times_s_[a]) / step_s;
    const Pose &from = t_->poses[a].T_map_vehicle, &to = t_->poses[b].T_map_vehicle;
    return {from.translation_m + share * (to.translation_m - from.translation_m),
            from.rotation.slerp(std::clamp(share, 0.0, 1.0), to.rotation)};
  }
  [[nodiscard]] Eigen::Vector3d velocity_at(double time_s) const {
    const double from_s = std::max(time_s - kHalfStep_s, times_s_.front()),
                 to_s = std::min(time_s + kHalfStep_s, times_s_.back());
    if (!(to_s > from_s)) return Eigen::Vector3d::Zero();
    return (at(to_s).translation_m - at(from_s).translation_m) / (to_s - from_s);
  }

 private:
  /// Half of the time over which measured poses determine a velocity.
  static constexpr double kHalfStep_s = 0.25;

  const Trajectory* t_;
  std::vector<double> times_s_;
};

}  // namespace octant::calib
