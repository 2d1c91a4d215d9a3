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
  kUndetermined   ///< not observed, or not well enough; localizers ignore it
};
[[nodiscard]] const char* to_string(BeaconStatus status);

struct DeploymentBeacon {
  std::string name;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  double delay_s = 0.0;
  double delay_sigma_s = 0.0;
  double gain = 1.0;  ///< amplitude relative to the attenuation model; below 1 where dirt or age reduce it
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
  /// Cosine of the widest horizontal angle off the axis at which the calibration received arrivals. Only for
  /// receivers with an axis.
  std::optional<double> hearing_cosine{};
};

/// Constraints that fix position, orientation and scale of the map.
struct Datum {
  std::string description;  ///< one sentence
  std::string position, orientation,
      scale;  ///< "control points", "measured poses", "control distances", "medium", ... for each of the
              ///< three
  std::vector<std::string> control_points;
};

struct CalibrationStatistics {
  std::size_t arrivals = 0;  ///< number used in the adjustment
  std::size_t rejected = 0;
  std::size_t unknowns = 0;  ///< shared parameters and poses
  double redundancy = 0.0;
  double variance_factor = 0.0;
  double chi2_p = 0.0;  ///< two-sided p value of the variance factor's chi-square test
  double rms_s = 0.0;
  bool converged = false;
};

/// Joint covariance of the calibrated parameters in SI units, in the order of `parameters`.
struct JointCovariance {
  std::vector<ParameterId> parameters;
  Eigen::MatrixXd matrix;

  /// Row of a parameter; -1 for a parameter that was held fixed.
  [[nodiscard]] int index_of(const ParameterId& id) const { return octant::index_of(parameters, id); }
};

/// Correlated part of the arrivals' errors, estimated from the residuals of the calibration. Zero if there is
/// none.
struct CorrelatedNoise {
  double sigma_s = 0.0;       ///< part that a beacon-receiver pair keeps for about time_s [s]
  double time_s = 0.0;        ///< correlation time [s]
  double pair_sigma_s = 0.0;  ///< constant bias of a pair, which does not average out [s]
  [[nodiscard]] bool any() const { return sigma_s > 0.0 || pair_sigma_s > 0.0; }
};

struct InputDigest {
  std::string path;
  std::string sha256;
};

/// Everything that a localizer needs to know about a calibrated site. Written by calibrate, read at run time.
struct Deployment {
  std::string site;
  std::string created;  ///< ISO 8601, UTC
  Motion motion = Motion::kPlanar;
  Datum datum;
  Medium medium;                  ///< reference state; see also speed_offset_mps
  double speed_offset_mps = 0.0;  ///< added to the medium's model at any temperature
  double speed_sigma_mps = 0.0;
  Timing timing;
  Noise noise;
  CorrelatedNoise correlated_noise;  ///< in addition to the white noise.tof_sigma_s
  std::optional<AttenuationModel> attenuation;
  std::vector<DeploymentBeacon> beacons;
  std::vector<SiteVehicle> vehicles;
  std::vector<DeploymentReceiver> receivers;  ///< receivers of all vehicles, vehicle by vehicle
  JointCovariance covariance;
  CalibrationStatistics statistics;
  Tolerance tolerance;
  std::optional<std::array<double, 2>> validity_temperature_degC;
  std::vector<Eigen::Vector2d> validity_area_m;  ///< convex hull of the calibrated poses, counter-clockwise
  /// Lowest and highest calibrated origin of a vehicle, in space only [m].
  std::optional<std::array<double, 2>> validity_heights_m;
  /// Distance beyond which the vehicle received nothing during calibration although it should have. No value
  /// if the recordings do not determine the reach of a beacon [m].
  std::optional<double> validity_reach_m;
  ValidityPeriod validity_period;  ///< as given in the site file; counted from `created`
  DriftRates drift;                ///< as given in the site file
  std::vector<InputDigest> inputs;
  std::string program_version;
  std::string program_command;
  std::vector<std::string> warnings;
  std::optional<Previous> previous;  ///< only for a recalibration
  std::string digest;                ///< SHA-256 of the file that it was read from
  /// Contradictions between the data of the calibration and its site file. Non-empty only if the user
  /// exported the deployment in spite of them; localizers then warn.
  std::vector<Contradiction> contradictions;

  /// Speed at a temperature: that of the medium's model plus the calibrated offset [m/s].
  [[nodiscard]] double speed_mps(double temperature_degC) const {
    return octant::speed_mps(medium, temperature_degC) + speed_offset_mps;
  }
};
[[nodiscard]] NameTable names_of(const Deployment& deployment);

}  // namespace octant
