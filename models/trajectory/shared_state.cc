// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/trajectory/shared_state.h"

#include <cmath>
#include <tuple>

namespace octant {
namespace {

/// Lists of a state that have an entry for each beacon, or are empty.
template <class State>
auto lists_of_beacons(State& state) {
  return std::tie(state.beacon_p_map_m, state.beacon_delay_s, state.beacon_log_gain);
}

/// Axes of the receivers of a site or a deployment.
template <class Receivers>
std::vector<Eigen::Vector3d> axes_of(const Receivers& receivers,
                                     const std::optional<AttenuationModel>& attenuation) {
  std::vector<Eigen::Vector3d> axes;
  if (!attenuation || !attenuation->directional()) return axes;
  for (const auto& receiver : receivers) axes.push_back(receiver.axis.value_or(Eigen::Vector3d::Zero()));
  return axes;
}

/// Visitor for visit_parameter. Parameters of an array act through its receivers.
struct InState : HasNothing<double*> {
  SharedState& state;
  explicit InState(SharedState& of) : state(of) {}
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

class PriorList {
 public:
  PriorList(const Site& site, std::size_t runs) : site_(site), runs_(runs), c_(speed_mps(site.medium)) {}

  std::vector<SharedPrior> all() {
    add_beacons();
    add_delays();
    const std::size_t speeds = site_.speed_offset_per_run ? runs_ : 1;
    for (std::size_t i = 0; i < speeds; ++i)
      add(parameters::speed(speeds > 1 ? i + 1 : 0), {0.0, site_.speed_sigma_mps}, c_);
    add_receivers();
    if (site_.timing.clock == Clock::kCycleOffset)  // error in metres of an arrival one second into its cycle
      for (std::size_t v = 0; v < site_.vehicles.size(); ++v)
        add(parameters::clock_drift(v), {site_.timing.drift, site_.timing.drift_sigma}, 1.0 / c_);
    add_attenuation();
    if (const auto pair_sigma_s = site_.noise.pair_sigma_s)
      for (std::size_t b = 0; b < site_.beacons.size(); ++b)
        for (std::size_t r = 0; r < site_.receivers.size(); ++r)
          add(parameters::pair_bias(b, r), {0.0, *pair_sigma_s}, 1.0 / c_);
    return std::move(all_);
  }

 private:
  /// Parameters with sigma 0 are fixed and not added.
  void add(ParameterId id, const Prior& prior, double si_per_unit, double lower = -INFINITY,
           double upper = INFINITY) {
    if (prior.sigma > 0) all_.push_back({id, prior.value, prior.sigma, si_per_unit, lower, upper});
  }

  void add_beacons() {
    for (std::size_t b = 0; b < site_.beacons.size(); ++b)
      for (std::size_t i = 0; i < 3; ++i) {
        const SiteBeacon& beacon = site_.beacons[b];
        const bool known = beacon.position_m[i] && beacon.sigma_m[i];
        add(parameters::beacon_position(b, i),
            known ? Prior{*beacon.position_m[i], *beacon.sigma_m[i]} : Prior{0.0, INFINITY}, 1.0);
      }
  }

  void add_delays() {
    const Timing& timing = site_.timing;
    const SharedState means = prior_state(site_);
    if (timing.delay_per.beacon)
      for (std::size_t b = 0; b < site_.beacons.size(); ++b)
        add(parameters::beacon_delay(b), {means.beacon_delay_s[b], beacon_delay_prior(site_, b).sigma},
            1.0 / c_);
    if (timing.delay_per.receiver)
      for (std::size_t r = 0; r < site_.receivers.size(); ++r)
        add(parameters::receiver_delay(r), {means.receiver_delay_s[r], timing.delay_sigma_s}, 1.0 / c_);
    if (timing.delay_per.site)
      add(parameters::site_delay(), {means.site_delay_s, timing.delay_sigma_s}, 1.0 / c_);
  }

  void add_receivers() {
    std::vector<bool> is_of_array(site_.vehicles.size(), false);
    for (std::size_t v = 0; v < site_.vehicles.size(); ++v) is_of_array[v] = add_array(v);
    for (std::size_t r = 0; r < site_.receivers.size(); ++r) {
      const SiteReceiver& receiver = site_.receivers[r];
      if (is_of_array[receiver.vehicle.index()]) continue;
      for (Eigen::Index i = 0; i < 3; ++i)
        add(parameters::receiver_position(r, static_cast<std::size_t>(i)),
            {receiver.position_m[i], receiver.sigma_m[i]}, 1.0);
    }
  }

  /// Adds circumradius and turn (in metres of arc) of an octagon that is adjusted as a whole.
  /// @return false if the vehicle has no such array
  bool add_array(std::size_t v) {
    const SiteVehicle& vehicle = site_.vehicles[v];
    if (!vehicle.array || vehicle.receiver_count == 0) return false;
    const Eigen::Vector3d& corner_m = site_.receivers[vehicle.first_receiver].position_m;
    const double radius_m = corner_m.head<2>().norm();
    const std::size_t before = all_.size();
    add(parameters::array_radius(v), {radius_m, vehicle.array->radius_sigma_m}, 1.0, 1e-3 * radius_m);
    add(parameters::array_turn(v), {std::atan2(corner_m.y(), corner_m.x()), vehicle.array->turn_sigma_rad},
        1.0 / radius_m);
    return all_.size() > before;
  }

  void add_attenuation() {
    if (!site_.attenuation) return;
    const AttenuationPrior& a = *site_.attenuation;
    const double nominal_v = a.amplitude_1m_v.value;
    add(parameters::attenuation(0), a.amplitude_1m_v, nominal_v, 1e-3 * nominal_v);
    add(parameters::attenuation(1), a.absorption_np_per_m, 1.0);
    add(parameters::attenuation(2), a.rise_time_s, 1.0 / c_, 0.0);
    add(parameters::attenuation(3), a.half_power_angle_rad, 1.0, kLeastHalfPowerAngle_rad,
        kMostHalfPowerAngle_rad);
    for (std::size_t b = 0; b < site_.beacons.size(); ++b)
      add(parameters::beacon_gain(b), site_.beacons[b].log_gain, 1.0);
  }

  const Site& site_;
  std::size_t runs_;
  double c_;  ///< converts delays into metres
  std::vector<SharedPrior> all_;
};

}  // namespace

std::vector<SharedPrior> shared_priors(const Site& site, std::size_t runs) {
  return PriorList(site, runs).all();
}

double* value_in(SharedState& state, const ParameterId& id) { return visit_parameter(id, InState(state)); }

void add_copy_of_beacon(SharedState& state, std::size_t beacon) {
  const auto add = [&](auto& list) {
    if (list.empty()) return;
    const auto copy = list[beacon];
    list.push_back(copy);
  };
  std::apply([&](auto&... lists) { (add(lists), ...); }, lists_of_beacons(state));
  if (state.pair_bias_s.empty()) return;
  const std::size_t receivers = state.receiver_delay_s.size();
  for (std::size_t r = 0; r < receivers; ++r) {
    const double bias_s = state.pair_bias_s[beacon * receivers + r];
    state.pair_bias_s.push_back(bias_s);
  }
}

void set_beacon(SharedState& state, std::size_t beacon, const SharedState& from) {
  const auto set = [&](auto& list, const auto& other) {
    if (!list.empty() && !other.empty()) list[beacon] = other[beacon];
  };
  std::apply(
      [&](auto&... lists) {
        std::apply([&](const auto&... others) { (set(lists, others), ...); }, lists_of_beacons(from));
      },
      lists_of_beacons(state));
}

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
  // The prior mean is assigned once: to the first kind of delay in use, or to the site's if no delay is an
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
