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

/// Clock that times of flight refer to.
enum class Clock {
  kSynchronised,  ///< firing is signalled by radio or wire
  kCycleOffset    ///< one unknown offset for each epoch (Kleeman)
};

enum class Ranging {
  kOneWay,
  kTwoWay  ///< tof_s is the round-trip time including turnaround_s; the vehicle receives the reply at time_s
};

/// Selects which delays are separate unknowns. The delay of an arrival is the sum of those that apply.
struct DelayPer {
  bool beacon = false;
  bool receiver = false;
  bool site = false;
  [[nodiscard]] bool none() const { return !beacon && !receiver && !site; }
};

/// Number of passages of the path between beacon and receiver within one time of flight.
[[nodiscard]] constexpr double legs_of(bool two_way) { return two_way ? 2.0 : 1.0; }

struct Timing {
  Clock clock = Clock::kSynchronised;
  Ranging ranging = Ranging::kOneWay;
  double turnaround_s = 0.0;  ///< two-way ranging only
  DelayPer delay_per;
  double delay_s = 0.0;        ///< prior mean of each delay
  double delay_sigma_s = 0.0;  ///< prior sigma of each delay; 0: held fixed
  /// Clock::kCycleOffset only: relative rate error of the vehicle's oscillator, which affects arrivals late
  /// in a cycle. Prior mean and sigma (0: held fixed).
  double drift = 0.0;
  double drift_sigma = 0.0;
  [[nodiscard]] double legs() const { return legs_of(ranging == Ranging::kTwoWay); }
};

struct Noise {
  double tof_sigma_s = 1.0e-5;
  double amplitude_relative_sigma = 0.05;  ///< relative sigma of the amplitude column
  std::optional<double> pair_sigma_s;      ///< constant bias of a beacon-receiver pair
  double bearing_sigma_rad = 0.01;
  double range_sigma_m = 0.02;  ///< sigma of the beams of a scan
};

/// Prior mean with its sigma; sigma 0 holds the value fixed.
struct Prior {
  double value = 0.0;
  double sigma = 0.0;
};

struct AttenuationPrior {
  Prior amplitude_1m_v, absorption_np_per_m, rise_time_s;
  double threshold_v = 0.0;
  Prior half_power_angle_rad{};  ///< value 0: omnidirectional receivers
  double saturation_v = std::numeric_limits<double>::infinity();
  [[nodiscard]] AttenuationModel mean() const {
    return {amplitude_1m_v.value, absorption_np_per_m.value,  threshold_v,
            rise_time_s.value,    half_power_angle_rad.value, saturation_v};
  }
};

/// A beacon as given in the site file. A coordinate without a value is unknown; sigma 0 holds it fixed.
struct SiteBeacon {
  std::string name;
  std::array<std::optional<double>, 3> position_m;
  std::array<std::optional<double>, 3>
      sigma_m;   ///< a position without a sigma is not a prior: its accuracy is unknown
  int line = 0;  ///< line in the site file
  std::optional<double> delay_s{}, delay_sigma_s{};  ///< prior of the beacon's own delay, instead of that in
                                                     ///< `timing`; requires delay_per beacon
  Prior log_gain{};  ///< natural logarithm of its amplitude relative to the attenuation model; sigma 0: held
                     ///< fixed

  /// Position, or no value if a coordinate is unknown.
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
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< position in the vehicle frame
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();     ///< prior sigma of each axis; 0 holds it fixed
  std::optional<Eigen::Vector3d> axis;                   ///< direction of maximum sensitivity, unit vector
  /// Offset subtracted from position_m while the site is calibrated from recordings that do not determine
  /// headings. The vehicle's origin then coincides with its receiver.
  Eigen::Vector2d taken_off_m = Eigen::Vector2d::Zero();
};

/// Rail that a vehicle runs on; the heading is that of the rail.
struct Rail {
  enum class Shape { kStraight, kArc };
  Shape shape = Shape::kStraight;
  Eigen::Vector2d
      from_m = Eigen::Vector2d::Zero(),
      to_m =
          Eigen::Vector2d::Zero();  ///< ends of a straight rail; the heading points from `from_m` to `to_m`
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();  ///< centre of an arc, travelled counter-clockwise
  double radius_m = 0.0;
};

/// Octagonal array that is adjusted as a whole, by its circumradius and its turn about the vehicle's z axis.
/// Prior means are those of the receivers' positions.
struct ArrayShape {
  double radius_sigma_m = 0.0;  ///< 0: held fixed
  double turn_sigma_rad = 0.0;  ///< 0: held fixed
};

/// Typical motion of a vehicle. It links consecutive states where there is neither odometry nor a measured
/// pose: white-noise acceleration changes the velocity by about the given amounts within a second.
struct MotionPrior {
  double speed_mps = 1.0;
  double acceleration_mps2 = 0.5;
  double turn_rate_rad_per_s = 1.0;
  double turn_acceleration_rad_per_s2 = 1.0;
};

struct SiteVehicle {
  std::string name = "robot";
  std::size_t first_receiver = 0;  ///< the vehicle's receivers are contiguous in Site::receivers
  std::size_t receiver_count = 0;
  std::optional<Rail> rail{};
  std::optional<ArrayShape> array{};
  std::optional<MotionPrior> motion{};
  double clock_drift = 0.0;  ///< calibrated relative rate error of its oscillator; deployments only
  double clock_drift_sigma = 0.0;
};

struct ControlDistance {
  BeaconId from, to;
  double distance_m = 0.0;
  double sigma_m = 0.0;
};

/// Required accuracy of the site; checked by verify and in reports.
struct Tolerance {
  std::optional<double> beacon_m;
  std::optional<double> fix_m;
};

/// Validity period of a calibration. Limits that are not given are not applied.
struct ValidityPeriod {
  std::optional<double> months;  ///< recalibration is due after this time
  /// Drift rate of a beacon. Recalibration is due when a beacon may have left tolerance.beacon_m.
  std::optional<double> beacon_drift_m_per_month;
  [[nodiscard]] bool stated() const { return months || beacon_drift_m_per_month; }
  friend bool operator==(const ValidityPeriod&, const ValidityPeriod&) = default;
};

/// Drift between two visits, as standard deviations a year. Values that are not given are those of the kind
/// of medium (drift_after in models/changes/change_sigmas.h).
struct DriftRates {
  std::optional<double> beacon_m_per_year{};    ///< each axis
  std::optional<double> delay_m_per_year{};     ///< delay as the range that corresponds to it
  std::optional<double> receiver_m_per_year{};  ///< each axis
  std::optional<double> speed_mps_per_year{};   ///< speed of the medium at a given temperature
  [[nodiscard]] bool given() const {
    return beacon_m_per_year || delay_m_per_year || receiver_m_per_year || speed_mps_per_year;
  }
  friend bool operator==(const DriftRates&, const DriftRates&) = default;
};

/// Gates that are applied before the pose is known.
struct Gates {
  double min_range_m = 0.0;                                      ///< d_min of Chang; 0: no gate
  double max_range_m = std::numeric_limits<double>::infinity();  ///< d_max of Chang
  bool triangle = true;                                          ///< triangle inequality of Kleeman
};

/// Everything that is known about a site before its calibration.
struct Site {
  std::string name;
  std::string path;  ///< path of the file as the user wrote it; empty for a site that was made in memory
  Motion motion = Motion::kPlanar;
  Medium medium;
  double speed_sigma_mps = 0.0;       ///< prior of the offset from the medium's model; 0: held fixed
  bool speed_offset_per_run = false;  ///< one offset for each run instead of a common one
  Timing timing;
  Noise noise;
  std::optional<AttenuationPrior> attenuation;
  std::vector<SiteBeacon> beacons;
  std::vector<SiteVehicle> vehicles;
  std::vector<SiteReceiver> receivers;  ///< receivers of all vehicles, vehicle by vehicle
  std::vector<ControlDistance> distances;
  Tolerance tolerance;
  ValidityPeriod validity;
  DriftRates drift;
  Gates gates;
  std::vector<std::string> warnings;  ///< warnings of the reader: ignored keys, assumptions made
  /// Blocks that are present in the site file. They are required unless there are no arrivals (bearings or
  /// scans alone).
  bool medium_given = true, timing_given = true, tof_sigma_given = true;
};

/// Prior of a beacon's delay [s]: the beacon's own values, else those in `timing`. Requires delay_per beacon.
[[nodiscard]] Prior beacon_delay_prior(const Site& site, std::size_t beacon);
/// Largest prior sigma of the delays in use [s]; 0 if no delay is an unknown.
[[nodiscard]] double largest_delay_sigma_s(const Site& site);

/// Names that rows of a run refer to, from a site or a deployment.
struct NameTable {
  std::vector<std::string> beacons;
  std::vector<std::string> vehicles;
  struct Receiver {
    std::string name;
    VehicleId vehicle;
  };
  std::vector<Receiver> receivers;

  /// Find an entry by name, by linear search; the result is not valid() if there is none. An empty vehicle or
  /// receiver name means the only one, or the vehicle `robot`.
  [[nodiscard]] BeaconId find_beacon(std::string_view name) const;
  [[nodiscard]] VehicleId find_vehicle(std::string_view name) const;
  [[nodiscard]] ReceiverId find_receiver(VehicleId vehicle, std::string_view name) const;
};
[[nodiscard]] NameTable names_of(const Site& site);

}  // namespace octant
