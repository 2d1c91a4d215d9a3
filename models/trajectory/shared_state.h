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

/// The numbers that all arrivals share: what calibration solves for and localization holds fixed.
struct SharedState {
  std::vector<Eigen::Vector3d> beacon_p_map_m;
  std::vector<double> beacon_delay_s;
  std::vector<Eigen::Vector3d> receiver_p_vehicle_m;
  std::vector<double> receiver_delay_s;
  double site_delay_s = 0.0;
  std::vector<double> speed_offset_mps = {
      0.0};  ///< added to the medium's model; one for all, or one for each run
  std::optional<AttenuationModel> attenuation;
  std::vector<Eigen::Vector3d>
      receiver_axis;  ///< unit vectors, zero: none; where the attenuation is directional, else empty
  std::vector<double> pair_bias_s;  ///< beacon-major, empty: none
  std::vector<double>
      beacon_log_gain;              ///< of each beacon's amplitude over the attenuation's, ln; empty: none
  std::vector<double> clock_drift;  ///< of each vehicle, see Timing::drift; empty: none

  [[nodiscard]] double delay_s(BeaconId beacon, ReceiverId receiver) const {
    double sum = site_delay_s + beacon_delay_s[beacon.index()] + receiver_delay_s[receiver.index()];
    if (!pair_bias_s.empty()) sum += pair_bias_s[beacon.index() * receiver_delay_s.size() + receiver.index()];
    return sum;
  }
  [[nodiscard]] double log_gain(BeaconId beacon) const {
    return beacon_log_gain.empty() ? 0.0 : beacon_log_gain[beacon.index()];
  }
  /// As PathInput takes it.
  [[nodiscard]] const Eigen::Vector3d* axis_of(ReceiverId receiver) const {
    return receiver_axis.empty() ? nullptr : &receiver_axis[receiver.index()];
  }
  [[nodiscard]] double drift(VehicleId vehicle) const {
    return vehicle.index() < clock_drift.size() ? clock_drift[vehicle.index()] : 0.0;
  }
  /// Whether times of flight are distance over one speed, and a delay: what the ways take that are made for
  /// many arrivals. Whatever else makes a path longer or later is named here.
  [[nodiscard]] bool has_plain_paths() const { return !attenuation; }
  [[nodiscard]] double speed_offset(std::size_t run) const {
    return speed_offset_mps.size() > 1 ? speed_offset_mps[run] : speed_offset_mps[0];
  }
};

/// What a state knows of the path from a beacon to a receiver; the vehicle's pose, what two-way ranging and a
/// cycle's clock add and a measured amplitude are the caller's. The attenuation and the axis are the state's.
/// @param speed_mps  of the signal, its offset included
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

/// What an observation over a path (beacon, receiver) is derived by: derivatives have these places.
enum PathNumber : std::uint8_t {
  kByBeacon,        ///< and the two axes that follow
  kByReceiver = 3,  ///< likewise
  kByRadius = 6,    ///< of an array as a whole
  kByTurn,          ///< likewise
  kByAttenuation,   ///< in the order of AttenuationRow
  kByGain = kByAttenuation + kAttenuationUnknowns,
  kByDelay,  ///< of beacon, receiver, site and pair; it and what follows move times alone
  kByDrift,
  kBySpeed,
  kPathNumbers
};

/// Calls visit(ParameterId, PathNumber) for every shared number that an observation over the path may hang
/// on: the one list of them.
/// @param receiver  invalid: a reflector that is seen, which has its place alone
/// @param run  of the observation
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

/// A shared number that is to be found, and what is known of it beforehand. SI units.
struct SharedPrior {
  ParameterId id;
  double mean = 0.0;
  double sigma = 0.0;        ///< infinite: nothing is known
  double si_per_unit = 1.0;  ///< of an internal unit: metres at the medium's nominal speed, or a pure number
  double lower = -INFINITY, upper = INFINITY;  ///< bounds
};
/// All that a site leaves open. Numbers of one kind and owner follow each other.
/// @param runs  how many there are
[[nodiscard]] std::vector<SharedPrior> shared_priors(const Site& site, std::size_t runs);

/// Where a state holds a shared number; null where it holds none: what an array's circumradius and turn make
/// of it stands on the receivers.
[[nodiscard]] double* value_in(SharedState& state, const ParameterId& id);

/// Adds a beacon that has all numbers of that one.
void add_copy_of_beacon(SharedState& state, std::size_t beacon);
/// Gives a beacon all numbers of its own that it has in another state.
void set_beacon(SharedState& state, std::size_t beacon, const SharedState& from);

/// Prior means of a site; unknown coordinates are zero.
[[nodiscard]] SharedState prior_state(const Site& site);
/// The calibrated values of a deployment (a site's one delay is carried by the beacons).
[[nodiscard]] SharedState shared_state(const Deployment& deployment);

}  // namespace octant
