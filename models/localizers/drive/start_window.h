// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/start/drive_start.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// The last part of a drive, from which the place is searched. All memory is taken at construction.
class StartWindow {
 public:
  /// @param vehicle  what the states consist of
  explicit StartWindow(const StateSpace& vehicle);

  void begin(double time_s);
  /// Nothing has been received, and no time has passed.
  [[nodiscard]] bool is_new() const { return t_.arrivals.empty() && t_.odometry.empty(); }
  void step(const OdometryObservation& motion, double span_s);
  /// Adds the arrivals of one instant. @param instant  a trajectory of one node
  void add(const Trajectory& instant);
  void keep_recent_half();

  [[nodiscard]] double span_s() const { return t_.nodes.back().time_s - t_.nodes.front().time_s; }
  [[nodiscard]] std::size_t last_node() const { return t_.nodes.size() - 1; }
  [[nodiscard]] bool hears(BeaconId beacon) const;
  [[nodiscard]] std::size_t beacons() const;
  [[nodiscard]] Segment all() const;
  [[nodiscard]] Trajectory& trajectory() { return t_; }

 private:
  Trajectory t_;
};

/// The offset of the speed by a window that is placed, and how the last node's pose follows it.
struct StartSpeed {
  SpeedBelief speed;
  PoseTangent by_speed;
};

/// Sigma of a range that a speed of that sigma leaves in a window [m].
[[nodiscard]] double range_sigma_of_speed_m(const Trajectory& trajectory, const Segment& window,
                                            const EpochFixModel& model, double sigma_mps);

/// The parabola through the squares of all residuals at some speeds (the profile of the likelihood), its
/// states solved at each, with less and less room for a wrong speed in the ranges. Leaves the window solved
/// at that speed, and the model with it.
/// @param sigma_mps  prior sigma of the offset
[[nodiscard]] StartSpeed fit_start_speed(Trajectory& trajectory, const Segment& window, EpochFixModel& model,
                                         double sigma_mps);

}  // namespace octant
