// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "models/change.h"
#include "models/contradiction.h"
#include "models/parameter.h"
#include "models/site.h"

namespace octant {

enum class BeaconStatus {
  kCalibrated,
  kControlPoint,  ///< held fixed
  kUndetermined   ///< not heard, or not well enough; localizers leave it out
};
[[nodiscard]] const char* to_string(BeaconStatus status);

struct DeploymentBeacon {
  std::string name;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  double delay_s = 0.0;
  double delay_sigma_s = 0.0;
  double gain = 1.0;  ///< of its amplitude over the attenuation's: below 1 where dirt or age dampen it
  BeaconStatus status = BeaconStatus::kCalibrated;
};

struct DeploymentReceiver {
  std::string name;
  VehicleId vehicle;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  double delay_s = 0.0;
  double delay_sigma_s = 0.0;
  std::optional<Eigen::Vector3d> axis;
  /// Cosine of the widest horizontal angle off the axis at which the calibration's arrivals were heard; with
  /// an axis only.
  std::optional<double> hearing_cosine{};
};

/// How position, orientation and scale were fixed.
struct Datum {
  std::string description;  ///< one sentence
  std::string position, orientation,
      scale;  ///< each: "control points", "measured poses", "control distances", "medium", ...
  std::vector<std::string> control_points;
};

struct CalibrationStatistics {
  std::size_t arrivals = 0;  ///< used in the adjustment
  std::size_t rejected = 0;
  std::size_t unknowns = 0;  ///< shared parameters and poses
  double redundancy = 0.0;
  double variance_factor = 0.0;
  double chi2_p = 0.0;  ///< two-sided p value of the variance factor's chi-square test
  double rms_s = 0.0;
  bool converged = false;
};

/// Joint covariance of the calibrated parameters, SI units, order of `parameters`.
struct JointCovariance {
  std::vector<ParameterId> parameters;
  Eigen::MatrixXd matrix;

  /// Where a parameter stands; -1: it was held fixed.
  [[nodiscard]] int index_of(const ParameterId& id) const { return octant::index_of(parameters, id); }
};

/// The part of the errors of arrivals that is not white, as the calibration's residuals show it; zero: there
/// is none.
struct CorrelatedNoise {
  double sigma_s = 0.0;       ///< of the part that a beacon-receiver pair keeps for about time_s [s]
  double time_s = 0.0;        ///< [s]
  double pair_sigma_s = 0.0;  ///< of the part that a pair keeps for good: it does not average out [s]
  [[nodiscard]] bool any() const { return sigma_s > 0.0 || pair_sigma_s > 0.0; }
};

struct InputDigest {
  std::string path;
  std::string sha256;
};

/// Everything a localizer needs to know of a calibrated site; written by calibrate, read at run time.
struct Deployment {
  std::string site;
  std::string created;  ///< ISO 8601, UTC
  Motion motion = Motion::kPlanar;
  Datum datum;
  Medium medium;                  ///< reference state; see speed_offset_mps
  double speed_offset_mps = 0.0;  ///< added to the medium's model at any temperature
  double speed_sigma_mps = 0.0;
  Timing timing;
  Noise noise;
  CorrelatedNoise correlated_noise;  ///< beside noise.tof_sigma_s, which is white
  std::optional<AttenuationModel> attenuation;
  std::vector<DeploymentBeacon> beacons;
  std::vector<SiteVehicle> vehicles;
  std::vector<DeploymentReceiver> receivers;  ///< all vehicles' receivers, vehicle by vehicle
  JointCovariance covariance;
  CalibrationStatistics statistics;
  Tolerance tolerance;
  std::optional<std::array<double, 2>> validity_temperature_degC;
  std::vector<Eigen::Vector2d> validity_area_m;  ///< convex hull of the calibrated poses, counter-clockwise
  /// Distance beyond which the calibration's vehicle heard nothing though it would have had to; none: the
  /// recordings do not tell how far a beacon is heard [m].
  std::optional<double> validity_reach_m;
  ValidityPeriod validity_period;  ///< as the site states it; from `created` on
  std::vector<InputDigest> inputs;
  std::string program_version;
  std::string program_command;
  std::vector<std::string> warnings;
  std::optional<Previous> previous;  ///< of a recalibration
  std::string digest;                ///< SHA-256 of its file's content, where it was read from one
  /// What the data of the calibration say against its site file: exported against advice, and localizers say
  /// so. Empty: nothing.
  std::vector<Contradiction> contradictions;

  /// Speed at a temperature: the model's and the calibrated offset [m/s].
  [[nodiscard]] double speed_mps(double temperature_degC) const {
    return octant::speed_mps(medium, temperature_degC) + speed_offset_mps;
  }
};
[[nodiscard]] NameTable names_of(const Deployment& deployment);

}  // namespace octant
