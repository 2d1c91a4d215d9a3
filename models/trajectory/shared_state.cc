// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/shared_state.h"

#include <cmath>

#include "models/parameter.h"

namespace octant {
namespace {

/// Of a site or of a deployment.
template <class Receivers>
std::vector<Eigen::Vector3d> axes_of(const Receivers& receivers,
                                     const std::optional<AttenuationModel>& attenuation) {
  std::vector<Eigen::Vector3d> axes;
  if (!attenuation || !attenuation->directional()) return axes;
  for (const auto& receiver : receivers) axes.push_back(receiver.axis.value_or(Eigen::Vector3d::Zero()));
  return axes;
}

/// Visitor: see visit_parameter.
struct InState {
  SharedState& state;
  [[nodiscard]] static double* at(std::vector<double>& all, std::size_t i) {
    return i < all.size() ? &all[i] : nullptr;
  }
  [[nodiscard]] double* beacon_position(std::size_t b, std::size_t axis) const {
    return &state.beacon_p_map_m[b][static_cast<Eigen::Index>(axis)];
  }
  [[nodiscard]] double* beacon_delay(std::size_t b) const { return at(state.beacon_delay_s, b); }
  [[nodiscard]] double* beacon_gain(std::size_t b) const { return at(state.beacon_log_gain, b); }
  [[nodiscard]] double* receiver_position(std::size_t r, std::size_t axis) const {
    return &state.receiver_p_vehicle_m[r][static_cast<Eigen::Index>(axis)];
  }
  [[nodiscard]] double* receiver_delay(std::size_t r) const { return at(state.receiver_delay_s, r); }
  [[nodiscard]] static double* array(std::size_t, std::size_t) { return nullptr; }
  [[nodiscard]] double* site_delay() const { return &state.site_delay_s; }
  [[nodiscard]] double* speed(std::size_t run) const {
    return &state.speed_offset_mps[run > 0 ? run - 1 : 0];
  }
  [[nodiscard]] double* attenuation(std::size_t unknown) const {
    return state.attenuation ? &attenuation_unknown(*state.attenuation, unknown) : nullptr;
  }
  [[nodiscard]] double* clock_drift(std::size_t v) const { return at(state.clock_drift, v); }
  [[nodiscard]] double* pair_bias(std::size_t b, std::size_t r) const {
    return &state.pair_bias_s[b * state.receiver_delay_s.size() + r];
  }
};

}  // namespace

double* value_in(SharedState& state, const ParameterId& id) { return visit_parameter(id, InState{state}); }

SharedState prior_state(const Site& site) {
  SharedState state;
  const Timing& timing = site.timing;
  for (const SiteBeacon& beacon : site.beacons) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) p[i] = beacon.position_m[static_cast<std::size_t>(i)].value_or(0.0);
    state.beacon_p_map_m.push_back(p);
  }
  for (const SiteReceiver& receiver : site.receivers)
    state.receiver_p_vehicle_m.push_back(receiver.position_m);
  // The prior mean stands once: on the first kind of delay that is in use, or on the site's where none is an
  // unknown.
  const bool on_beacons = timing.delay_per.beacon;
  const bool on_receivers = !on_beacons && timing.delay_per.receiver;
  for (std::size_t b = 0; b < site.beacons.size(); ++b)
    state.beacon_delay_s.push_back(on_beacons ? beacon_delay_prior(site, b).value : 0.0);
  state.receiver_delay_s.assign(site.receivers.size(), on_receivers ? timing.delay_s : 0.0);
  state.site_delay_s = on_beacons || on_receivers ? 0.0 : timing.delay_s;
  if (site.attenuation) state.attenuation = site.attenuation->mean();
  if (site.attenuation)
    for (const SiteBeacon& b : site.beacons) state.beacon_log_gain.push_back(b.log_gain.value);
  state.receiver_axis = axes_of(site.receivers, state.attenuation);
  state.clock_drift.assign(site.vehicles.size(), timing.drift);
  if (site.noise.pair_sigma_s) state.pair_bias_s.assign(site.beacons.size() * site.receivers.size(), 0.0);
  return state;
}

SharedState shared_state(const Deployment& deployment) {
  SharedState state;
  for (const DeploymentBeacon& beacon : deployment.beacons) {
    state.beacon_p_map_m.push_back(beacon.position_m);
    state.beacon_delay_s.push_back(beacon.delay_s);
    if (deployment.attenuation) state.beacon_log_gain.push_back(std::log(beacon.gain));
  }
  for (const DeploymentReceiver& receiver : deployment.receivers) {
    state.receiver_p_vehicle_m.push_back(receiver.position_m);
    state.receiver_delay_s.push_back(receiver.delay_s);
  }
  state.speed_offset_mps = {deployment.speed_offset_mps};
  state.attenuation = deployment.attenuation;
  state.receiver_axis = axes_of(deployment.receivers, state.attenuation);
  for (const SiteVehicle& vehicle : deployment.vehicles) state.clock_drift.push_back(vehicle.clock_drift);
  return state;
}

}  // namespace octant
