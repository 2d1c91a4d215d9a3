// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/start/drive_start.h"
#include "models/support/scratch.h"
#include "models/trajectory/trajectory.h"

namespace octant {

/// The last part of a drive, in which the pose is searched. All memory is allocated at construction.
class StartWindow {
 public:
  /// @param vehicle  state space of the vehicle
  explicit StartWindow(const StateSpace& vehicle);

  void begin(double time_s);
  [[nodiscard]] bool has_arrivals() const { return !t_.arrivals.empty(); }
  void step(const OdometryObservation& motion, double span_s);
  /// Adds the arrivals of one time. @param instant  a trajectory of one node
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

/// Offset of the speed from a solved window, and its effect on the last node's pose.
struct StartSpeed {
  SpeedBelief speed;
  PoseTangent by_speed;
};

/// Sigma of the ranges in a window due to the sigma of the speed [m].
[[nodiscard]] double range_sigma_of_speed_m(const Trajectory& trajectory, const Segment& window,
                                            const EpochFixModel& model, double sigma_mps);

/// Fits a parabola to the sum of squares at several speeds (profile likelihood). The states are solved at
/// each speed, with a decreasing additional uncertainty of the ranges. Sets the window and the model to the
/// resulting speed.
/// @param sigma_mps  prior sigma of the offset
/// @param scratch  memory for one solution
/// @param known_mps  an offset nearby, at which the window is solved already
[[nodiscard]] StartSpeed fit_start_speed(Trajectory& trajectory, const Segment& window, EpochFixModel& model,
                                         double sigma_mps, Scratch& scratch,
                                         std::optional<double> known_mps = {});

}  // namespace octant
