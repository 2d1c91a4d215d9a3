// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/parameter.h"
#include "models/physics/attenuation.h"
#include "models/physics/measurement.h"
#include "models/site.h"

namespace octant {

/// Parameters that all arrivals share. Calibration estimates them, localization keeps them fixed.
struct SharedState {
  std::vector<Eigen::Vector3d> beacon_p_map_m;
  std::vector<double> beacon_delay_s;
  std::vector<Eigen::Vector3d> receiver_p_vehicle_m;
  std::vector<double> receiver_delay_s;
  double site_delay_s = 0.0;
  std::vector<double> speed_offset_mps = {
      0.0};  ///< offset from the medium's model; one for all runs, or one for each run
  std::optional<AttenuationModel> attenuation;
  std::vector<Eigen::Vector3d> receiver_axis;  ///< unit vectors, zero for omnidirectional receivers; empty
                                               ///< unless the attenuation is directional
  std::vector<double> pair_bias_s;             ///< beacon-major; empty if there are no biases
  std::vector<double> beacon_log_gain;  ///< natural logarithm of each beacon's amplitude relative to the
                                        ///< attenuation model; empty if all are nominal
  std::vector<double>
      clock_drift;  ///< drift of each vehicle's clock, see Timing::drift; empty if there is none

  [[nodiscard]] double delay_s(BeaconId beacon, ReceiverId receiver) const {
    double sum = site_delay_s + beacon_delay_s[beacon.index()] + receiver_delay_s[receiver.index()];
    if (!pair_bias_s.empty()) sum += pair_bias_s[beacon.index() * receiver_delay_s.size() + receiver.index()];
    return sum;
  }
  [[nodiscard]] double log_gain(BeaconId beacon) const {
    return beacon_log_gain.empty() ? 0.0 : beacon_log_gain[beacon.index()];
  }
  /// Axis in the form that PathInput expects.
  [[nodiscard]] const Eigen::Vector3d* axis_of(ReceiverId receiver) const {
    return receiver_axis.empty() ? nullptr : &receiver_axis[receiver.index()];
  }
  [[nodiscard]] double drift(VehicleId vehicle) const {
    return vehicle.index() < clock_drift.size() ? clock_drift[vehicle.index()] : 0.0;
  }
  /// Returns true if a time of flight is distance over one speed plus a delay. The fast implementations for
  /// many arrivals require it. Any other effect on path or time must be added here.
  [[nodiscard]] bool has_plain_paths() const { return !attenuation; }
  [[nodiscard]] double speed_offset(std::size_t run) const {
    return speed_offset_mps.size() > 1 ? speed_offset_mps[run] : speed_offset_mps[0];
  }
};

/// Path from a beacon to a receiver as far as the shared state determines it. The caller adds the pose, the
/// terms of two-way ranging and cycle offsets, and a measured amplitude.
/// @param speed_mps  speed of the signal including its offset
[[nodiscard]] inline PathInput path_of(const SharedState& state, BeaconId beacon, ReceiverId receiver,
                                       double speed_mps) {
  PathInput path;
  path.p_beacon_map_m = state.beacon_p_map_m[beacon.index()];
  path.p_receiver_vehicle_m = state.receiver_p_vehicle_m[receiver.index()];
  path.speed_mps = speed_mps;
  path.delay_s = state.delay_s(beacon, receiver);
  path.attenuation = state.attenuation ? &*state.attenuation : nullptr;
  path.axis_vehicle = state.axis_of(receiver);
  path.log_gain = state.log_gain(beacon);
  return path;
}

/// Positions of the derivatives of an observation over the path (beacon, receiver).
enum PathNumber : std::uint8_t {
  kByBeacon,        ///< three columns, one for each axis
  kByReceiver = 3,  ///< three columns, one for each axis
  kByRadius = 6,    ///< circumradius of an array that is adjusted as a whole
  kByTurn,          ///< turn of such an array
  kByAttenuation,   ///< kAttenuationUnknowns columns in the order of AttenuationRow
  kByGain = kByAttenuation + kAttenuationUnknowns,
  kByDelay,  ///< sum of the delays of beacon, receiver, site and pair; this and the following columns affect
             ///< times only
  kByDrift,
  kBySpeed,
  kPathNumbers
};

/// Calls visit(ParameterId, PathNumber) for every shared parameter that an observation over the path may
/// depend on. This is the only list of them.
/// @param receiver  invalid for a bearing to a reflector, which depends on its position only
/// @param run  run of the observation
template <class Visit>
void for_each_path_parameter(BeaconId beacon, ReceiverId receiver, VehicleId vehicle, std::size_t run,
                             Visit&& visit) {
  namespace of = parameters;
  const auto at = [](int first, std::size_t i) {
    return static_cast<PathNumber>(first + static_cast<int>(i));
  };
  const std::size_t b = beacon.index();
  for (std::size_t i = 0; i < 3; ++i) visit(of::beacon_position(b, i), at(kByBeacon, i));
  if (!receiver.valid()) return;
  const std::size_t r = receiver.index(), v = vehicle.index();
  visit(of::array_radius(v), kByRadius);
  visit(of::array_turn(v), kByTurn);
  for (std::size_t i = 0; i < 3; ++i) visit(of::receiver_position(r, i), at(kByReceiver, i));
  for (std::size_t i = 0; i < kAttenuationUnknowns; ++i) visit(of::attenuation(i), at(kByAttenuation, i));
  visit(of::beacon_gain(b), kByGain);
  visit(of::beacon_delay(b), kByDelay);
  visit(of::receiver_delay(r), kByDelay);
  visit(of::site_delay(), kByDelay);
  visit(of::pair_bias(b, r), kByDelay);
  visit(of::clock_drift(v), kByDrift);
  visit(of::speed(run + 1), kBySpeed);
}

/// A shared parameter that is to be estimated, with its prior. SI units.
struct SharedPrior {
  ParameterId id;
  double mean = 0.0;
  double sigma = 0.0;        ///< infinite: no prior
  double si_per_unit = 1.0;  ///< internal unit: metres at the medium's nominal speed, or a pure number
  double lower = -INFINITY, upper = INFINITY;  ///< bounds
};
/// All parameters that a site leaves open. Parameters of one kind and owner are consecutive.
/// @param runs  number of runs
[[nodiscard]] std::vector<SharedPrior> shared_priors(const Site& site, std::size_t runs);

/// Address of a shared parameter in a state. Null if the state does not store it: circumradius and turn of an
/// array act through the receivers.
[[nodiscard]] double* value_in(SharedState& state, const ParameterId& id);

/// Appends a copy of a beacon with all its parameters.
void add_copy_of_beacon(SharedState& state, std::size_t beacon);
/// Copies all parameters of a beacon from another state.
void set_beacon(SharedState& state, std::size_t beacon, const SharedState& from);

/// Prior means of a site; unknown coordinates are zero.
[[nodiscard]] SharedState prior_state(const Site& site);
/// Calibrated values of a deployment. A common delay of the site is part of the beacons' delays.
[[nodiscard]] SharedState shared_state(const Deployment& deployment);

}  // namespace octant
