// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/clocks/clock_log.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::calib {

/// Position of a vehicle at a stop or at an instant of a drive.
struct ClockPoint {
  std::size_t run = 0;
  VehicleId vehicle;
  double time_s = 0.0;
  std::int64_t epoch = kNoEpoch;
  std::optional<Eigen::Vector3d> measured_m;  ///< measured pose
  double measured_sigma_m = 0.0;
  Eigen::Matrix3d R_map_vehicle = Eigen::Matrix3d::Identity();  ///< of the measured pose
};

/// Motion of a vehicle between two points: in the axes of the first point (odometry), or in axes that do not
/// turn (displacements).
struct ClockMotion {
  std::size_t from = 0, to = 0;
  Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
  double turn_rad = 0.0, sigma_m = 1.0, sigma_rad = 0.0;
  bool turns = false;  ///< odometry
};

/// Reception of a transmission. In metres, less the line of the receiver's clock and an approximate time of
/// transmission.
struct ClockReception {
  std::size_t transmission = 0;
  int run = 0;
  int point = -1;  ///< of the vehicle, if it is at one end
  DeviceId from, to;
  double time_s = 0.0;  ///< on the common time base
  double range_m = 0.0;
  bool used = true;
};

/// Step of a clock that is assumed at a time of a run.
struct ClockJump {
  int run = 0, clock = 0;
  double time_s = 0.0;
};

/// Calibration of a site whose devices have clocks of their own, from receptions r of transmissions e:
///   range = T_e + |p_from - p_to| c0 / c + delay(to) + offset(clock of to, t_e) + noise.
/// T_e is unknown. The offset of a clock relative to its approximate line is linear between knots; from knot
/// to knot its phase and rate are random walks. Unknowns are in metres (rates in m/s), in one vector x.
struct ClockProblem {
  Site site;
  ClockModel clocks;
  std::vector<ClockPoint> points;
  std::vector<ClockMotion> motions;
  std::vector<ClockReception> receptions;
  std::size_t transmissions = 0;
  /// Knots of the clocks of each run [s]; a single one where the rate is constant for the noise of the log.
  std::vector<std::vector<double>> knots_s;
  std::vector<ClockJump> jumps;
  int reference_clock = 0;
  double speed_mps = 343.0;
  double sigma_m = 0.01;                           ///< of a reception
  double phase_walk_m2 = 0.0, rate_walk_m2 = 0.0;  ///< spectral densities of phase [m^2/s] and rate [m^2/s^3]
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double extent_m = 1.0;
  bool heading_is_free = false;  ///< odometry: points have headings
  bool frame_turns = false;      ///< displacements: the turn of their axes in the map is unknown
  bool frame_is_datum = false;   ///< the first point of each run defines the map
  /// Lines that were subtracted from the receptions, by run and clock: offset [s] at the middle of the run,
  /// relative rate.
  std::vector<std::vector<Eigen::Vector2d>> lines;
  std::vector<double> middle_s;
  std::vector<double> base_s;  ///< by run: time base less the time of the log

  [[nodiscard]] std::size_t devices() const { return site.beacons.size() + site.receivers.size(); }
  [[nodiscard]] bool is_beacon(DeviceId d) const { return d.index() < site.beacons.size(); }

  // Indices into x.
  [[nodiscard]] int beacon(std::size_t b) const { return 3 * static_cast<int>(b); }
  [[nodiscard]] int point(std::size_t p) const {
    return beacon(site.beacons.size()) + 4 * static_cast<int>(p);
  }
  [[nodiscard]] int sent(std::size_t e) const { return point(points.size()) + static_cast<int>(e); }
  [[nodiscard]] int delay(std::size_t b) const { return sent(transmissions) + static_cast<int>(b); }
  [[nodiscard]] int speed() const { return delay(site.beacons.size()); }
  [[nodiscard]] int frame() const { return speed() + 1; }
  [[nodiscard]] int jump(std::size_t j) const { return frame() + 1 + static_cast<int>(j); }
  [[nodiscard]] int knot(std::size_t run, int clock, std::size_t k) const;
  [[nodiscard]] int size() const;
};

/// Kinds of rows.
enum class ClockRowKind { kReception, kPrior, kProcess, kMotion };

/// A whitened observation, linearised at x.
struct ClockRow {
  static constexpr int kMost = 24;
  ClockRowKind kind = ClockRowKind::kPrior;
  std::size_t index = 0;  ///< of the reception
  double residual = 0.0;
  int size = 0;
  std::array<int, kMost> at{};
  std::array<double, kMost> by{};
  void add(int index_in_x, double derivative) {
    at[static_cast<std::size_t>(size)] = index_in_x;
    by[static_cast<std::size_t>(size++)] = derivative;
  }
};

/// Marks the elements of x that are fixed.
[[nodiscard]] std::vector<bool> fixed_elements(const ClockProblem& problem);
/// Prior means, with the points at the centre.
[[nodiscard]] Eigen::VectorXd prior_values(const ClockProblem& problem);
/// All rows at x.
[[nodiscard]] std::vector<ClockRow> rows_at(const ClockProblem& problem, const Eigen::VectorXd& x);

/// Makes the problem. @param most_points  number of points that are used, spread evenly; 0: all
[[nodiscard]] ClockProblem make_clock_problem(const Site& site, const std::vector<MeasurementLog>& runs,
                                              const std::vector<ClockLog>& logs, const ClockModel& clocks,
                                              std::size_t most_points = 0);

}  // namespace octant::calib
