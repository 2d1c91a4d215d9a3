// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "models/ids.h"
#include "models/physics/attenuation.h"
#include "models/physics/medium.h"
#include "models/physics/pose.h"

namespace octant {

/// Clock by which times of flight are taken.
enum class Clock {
  kSynchronised,  ///< radio or wire marks the firing
  kCycleOffset    ///< one unknown offset each epoch (Kleeman)
};

enum class Ranging {
  kOneWay,
  kTwoWay  ///< tof_s is the time there and back plus turnaround_s; the vehicle hears the reply at time_s
};

/// Which delays are unknowns of their own; an arrival's delay is the sum of those that apply.
struct DelayPer {
  bool beacon = false;
  bool receiver = false;
  bool site = false;
  [[nodiscard]] bool none() const { return !beacon && !receiver && !site; }
};

/// How often sound goes the way between beacon and receiver within one time of flight.
[[nodiscard]] constexpr double legs_of(bool two_way) { return two_way ? 2.0 : 1.0; }

struct Timing {
  Clock clock = Clock::kSynchronised;
  Ranging ranging = Ranging::kOneWay;
  double turnaround_s = 0.0;  ///< two-way ranging only
  DelayPer delay_per;
  double delay_s = 0.0;        ///< prior mean of each delay
  double delay_sigma_s = 0.0;  ///< prior sigma of each delay; 0: held fixed
  /// Clock::kCycleOffset: rate of a vehicle's oscillator against the beacons', less one, by which arrivals
  /// late in a cycle are off; prior mean and sigma (0: held fixed).
  double drift = 0.0;
  double drift_sigma = 0.0;
  [[nodiscard]] double legs() const { return legs_of(ranging == Ranging::kTwoWay); }
};

struct Noise {
  double tof_sigma_s = 1.0e-5;
  double amplitude_relative_sigma = 0.05;  ///< of the amplitude column
  std::optional<double> pair_sigma_s;      ///< bias that a beacon-receiver pair keeps
  double bearing_sigma_rad = 0.01;
  double range_sigma_m = 0.02;  ///< of scan beams
};

/// A number with its prior sigma; 0 holds it fixed.
struct Prior {
  double value = 0.0;
  double sigma = 0.0;
};

struct AttenuationPrior {
  Prior amplitude_1m_v, absorption_np_per_m, rise_time_s;
  double threshold_v = 0.0;
  Prior half_power_angle_rad{};  ///< value 0: receivers hear all round alike
  double saturation_v = std::numeric_limits<double>::infinity();
  [[nodiscard]] AttenuationModel mean() const {
    return {amplitude_1m_v.value, absorption_np_per_m.value,  threshold_v,
            rise_time_s.value,    half_power_angle_rad.value, saturation_v};
  }
};

/// A beacon as the site file knows it. A coordinate without a value is unknown; sigma 0 holds it fixed.
struct SiteBeacon {
  std::string name;
  std::array<std::optional<double>, 3> position_m;
  std::array<std::optional<double>, 3> sigma_m;  ///< no value beside a position: unknown accuracy, no prior
  int line = 0;                                  ///< in the site file
  std::optional<double> delay_s{},
      delay_sigma_s{};  ///< prior of its delay, in place of timing's; with delay_per beacon
  Prior log_gain{};     ///< of its amplitude over the attenuation's, ln; sigma 0: held fixed

  /// None where a coordinate is unknown.
  [[nodiscard]] std::optional<Eigen::Vector3d> place_m() const {
    if (!position_m[0] || !position_m[1] || !position_m[2]) return {};
    return Eigen::Vector3d(*position_m[0], *position_m[1], *position_m[2]);
  }
  [[nodiscard]] bool is_control_point() const {
    for (int i = 0; i < 3; ++i)
      if (!position_m[i] || !sigma_m[i] || *sigma_m[i] != 0.0) return false;
    return true;
  }
};

struct SiteReceiver {
  std::string name;
  VehicleId vehicle;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< in the vehicle frame
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();     ///< prior, per axis; 0 holds it fixed
  std::optional<Eigen::Vector3d> axis;                   ///< direction of hearing, unit vector
  /// Taken off position_m while a site is calibrated by recordings that tell no headings: the vehicle then
  /// stands where its receiver is.
  Eigen::Vector2d taken_off_m = Eigen::Vector2d::Zero();
};

/// Line that a vehicle runs on; its heading is the line's.
struct Rail {
  enum class Shape { kStraight, kArc };
  Shape shape = Shape::kStraight;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero(),
                  to_m = Eigen::Vector2d::Zero();      ///< ends of a straight rail; heading from -> to
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();  ///< of an arc, run counter-clockwise
  double radius_m = 0.0;
};

/// Octagon that is adjusted as a whole, by its circumradius and its turn about the vehicle's z axis, instead
/// of receiver by receiver. Prior means are those of the receivers' positions.
struct ArrayShape {
  double radius_sigma_m = 0.0;  ///< 0: held fixed
  double turn_sigma_rad = 0.0;  ///< 0: held fixed
};

/// How a vehicle usually moves: what ties its states together where there is neither odometry nor a measured
/// pose. Velocities wander as white-noise acceleration makes them, by about the stated amounts within a
/// second.
struct MotionPrior {
  double speed_mps = 1.0;
  double acceleration_mps2 = 0.5;
  double turn_rate_rad_per_s = 1.0;
  double turn_acceleration_rad_per_s2 = 1.0;
};

struct SiteVehicle {
  std::string name = "robot";
  std::size_t first_receiver = 0;  ///< its receivers are contiguous in Site::receivers
  std::size_t receiver_count = 0;
  std::optional<Rail> rail{};
  std::optional<ArrayShape> array{};
  std::optional<MotionPrior> motion{};
  double clock_drift =
      0.0;  ///< of a deployment: calibrated rate of its oscillator against the beacons', less one
  double clock_drift_sigma = 0.0;
};

struct ControlDistance {
  BeaconId from, to;
  double distance_m = 0.0;
  double sigma_m = 0.0;
};

/// What the site must reach; gates in verify and in reports.
struct Tolerance {
  std::optional<double> beacon_m;
  std::optional<double> fix_m;
};

/// For how long a calibration of the site may be trusted; what is not stated does not count.
struct ValidityPeriod {
  std::optional<double> months;  ///< after which a recalibration is due
  /// By which beacons may settle: a recalibration is due when one of them may have left tolerance.beacon_m.
  std::optional<double> beacon_drift_m_per_month;
  [[nodiscard]] bool stated() const { return months || beacon_drift_m_per_month; }
  friend bool operator==(const ValidityPeriod&, const ValidityPeriod&) = default;
};

/// What is left out before anything is known of the vehicle.
struct Gates {
  double min_range_m = 0.0;                                      ///< Chang's d_min; 0: no gate
  double max_range_m = std::numeric_limits<double>::infinity();  ///< Chang's d_max
  bool triangle = true;                                          ///< Kleeman's triangle inequality
};

/// All that is known of a site before calibration.
struct Site {
  std::string name;
  std::string path;  ///< of the file, as the user wrote it; empty if made in memory
  Motion motion = Motion::kPlanar;
  Medium medium;
  double speed_sigma_mps = 0.0;       ///< prior of the offset from the medium's model; 0: held fixed
  bool speed_offset_per_run = false;  ///< one offset each run instead of one for all
  Timing timing;
  Noise noise;
  std::optional<AttenuationPrior> attenuation;
  std::vector<SiteBeacon> beacons;
  std::vector<SiteVehicle> vehicles;
  std::vector<SiteReceiver> receivers;  ///< all vehicles' receivers, vehicle by vehicle
  std::vector<ControlDistance> distances;
  Tolerance tolerance;
  ValidityPeriod validity;
  Gates gates;
  std::vector<std::string> warnings;  ///< of reading: ignored keys, assumptions made
  /// Blocks that the site file states; they may be left out only where there are no arrivals (bearings or
  /// scans alone).
  bool medium_given = true, timing_given = true, tof_sigma_given = true;
};

/// Prior of a beacon's delay [s]: what the beacon states, and timing's for what it does not. With delay_per
/// beacon.
[[nodiscard]] Prior beacon_delay_prior(const Site& site, std::size_t beacon);
/// Largest prior sigma of the delays in use [s]; 0: none is an unknown.
[[nodiscard]] double largest_delay_sigma_s(const Site& site);

/// Names by which a run's rows are resolved; from a site or from a deployment.
struct NameTable {
  std::vector<std::string> beacons;
  std::vector<std::string> vehicles;
  struct Receiver {
    std::string name;
    VehicleId vehicle;
  };
  std::vector<Receiver> receivers;

  /// By name, one after the other; an id that is not valid() where there is none. @param vehicle, receiver
  /// empty: the only one, or the vehicle `robot`
  [[nodiscard]] BeaconId find_beacon(std::string_view name) const;
  [[nodiscard]] VehicleId find_vehicle(std::string_view name) const;
  [[nodiscard]] ReceiverId find_receiver(VehicleId vehicle, std::string_view name) const;
};
[[nodiscard]] NameTable names_of(const Site& site);

}  // namespace octant
