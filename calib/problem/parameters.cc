// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/parameters.h"

#include <cmath>

#include <Eigen/Cholesky>

namespace octant::calib {
namespace {

class LayoutBuilder {
 public:
  LayoutBuilder(const Problem& problem, const SharedState& state, const std::vector<bool>& held)
      : problem_(problem), site_(problem.site), state_(state), held_(held) {}

  ParameterLayout build() {
    layout_.fixed = state_;
    layout_.nominal_speed_mps = speed_mps(site_.medium);
    add_beacons();
    add_delays();
    add_speed();
    add_receivers();
    add_drift();
    add_attenuation();
    add_gains();
    add_pairs();
    return std::move(layout_);
  }

 private:
  int add(ParameterId id, double mean, double sigma, double si_per_unit, double lower = -INFINITY,
          double upper = INFINITY) {
    layout_.parameters.push_back({id, mean, sigma, si_per_unit, lower, upper});
    return layout_.size() - 1;
  }
  void block_from(int first) {
    if (layout_.size() > first) layout_.blocks.push_back({first, layout_.size() - first});
  }

  void add_beacons() {
    layout_.beacon.assign(site_.beacons.size(), {-1, -1, -1});
    for (std::size_t b = 0; b < site_.beacons.size(); ++b) {
      const SiteBeacon& beacon = site_.beacons[b];
      if (held_[b]) continue;
      const int first = layout_.size();
      for (std::size_t i = 0; i < 3; ++i) {
        const bool prior = beacon.position_m[i] && beacon.sigma_m[i];
        if (prior && *beacon.sigma_m[i] == 0.0) continue;
        layout_.beacon[b][i] = add(parameters::beacon_position(b, i), prior ? *beacon.position_m[i] : 0.0,
                                   prior ? *beacon.sigma_m[i] : INFINITY, 1.0);
      }
      block_from(first);
    }
  }

  void add_delays() {
    const Timing& timing = site_.timing;
    const double c = layout_.nominal_speed_mps;
    layout_.beacon_delay.assign(site_.beacons.size(), -1);
    layout_.receiver_delay.assign(site_.receivers.size(), -1);
    const SharedState prior = prior_state(site_);
    auto single = [&](ParameterId id, double mean_s, double sigma_s) {
      if (!(sigma_s > 0)) return -1;
      const int first = layout_.size();
      add(id, c * mean_s, c * sigma_s, 1.0 / c);
      block_from(first);
      return first;
    };
    if (timing.delay_per.beacon)
      for (std::size_t b = 0; b < site_.beacons.size(); ++b)
        if (!held_[b])
          layout_.beacon_delay[b] = single(parameters::beacon_delay(b), prior.beacon_delay_s[b],
                                           beacon_delay_prior(site_, b).sigma);
    if (timing.delay_per.receiver)
      for (std::size_t r = 0; r < site_.receivers.size(); ++r)
        layout_.receiver_delay[r] =
            single(parameters::receiver_delay(r), prior.receiver_delay_s[r], timing.delay_sigma_s);
    if (timing.delay_per.site)
      layout_.site_delay = single(parameters::site_delay(), prior.site_delay_s, timing.delay_sigma_s);
  }

  void add_speed() {
    if (!(site_.speed_sigma_mps > 0)) return;
    const double c = layout_.nominal_speed_mps;
    const std::size_t count = site_.speed_offset_per_run ? problem_.runs.size() : 1;
    for (std::size_t i = 0; i < count; ++i) {
      const int first = layout_.size();
      layout_.speed.push_back(
          add(parameters::speed(count > 1 ? i + 1 : 0), 0.0, site_.speed_sigma_mps / c, c));
      block_from(first);
    }
  }

  void add_receivers() {
    layout_.receiver.assign(site_.receivers.size(), {-1, -1, -1});
    for (const SiteReceiver& receiver : site_.receivers)
      layout_.vehicle_of_receiver.push_back(receiver.vehicle);
    add_arrays();
    for (std::size_t r = 0; r < site_.receivers.size(); ++r) {
      if (layout_.has_array(site_.receivers[r].vehicle)) continue;
      const int first = layout_.size();
      for (std::size_t i = 0; i < 3; ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        if (site_.receivers[r].sigma_m[k] > 0)
          layout_.receiver[r][i] = add(parameters::receiver_position(r, i), site_.receivers[r].position_m[k],
                                       site_.receivers[r].sigma_m[k], 1.0);
      }
      block_from(first);
    }
  }

  /// Circumradius and turn of the octagons that are adjusted as a whole; turns in metres of arc.
  void add_arrays() {
    layout_.array.assign(site_.vehicles.size(), {-1, -1});
    for (std::size_t v = 0; v < site_.vehicles.size(); ++v) {
      const SiteVehicle& vehicle = site_.vehicles[v];
      if (!vehicle.array || vehicle.receiver_count == 0) continue;
      const Eigen::Vector3d& corner_m = site_.receivers[vehicle.first_receiver].position_m;
      const double radius_m = corner_m.head<2>().norm();
      const int first = layout_.size();
      if (vehicle.array->radius_sigma_m > 0)
        layout_.array[v][0] =
            add(parameters::array_radius(v), radius_m, vehicle.array->radius_sigma_m, 1.0, 1e-3 * radius_m);
      if (vehicle.array->turn_sigma_rad > 0)
        layout_.array[v][1] =
            add(parameters::array_turn(v), radius_m * std::atan2(corner_m.y(), corner_m.x()),
                radius_m * vehicle.array->turn_sigma_rad, 1.0 / radius_m);
      block_from(first);
    }
  }

  /// In metres by which an arrival a second into its cycle is off.
  void add_drift() {
    layout_.clock_drift.assign(site_.vehicles.size(), -1);
    const Timing& timing = site_.timing;
    if (timing.clock != Clock::kCycleOffset || !(timing.drift_sigma > 0)) return;
    const double c = layout_.nominal_speed_mps;
    for (std::size_t v = 0; v < site_.vehicles.size(); ++v) {
      const int first = layout_.size();
      layout_.clock_drift[v] =
          add(parameters::clock_drift(v), c * timing.drift, c * timing.drift_sigma, 1.0 / c);
      block_from(first);
    }
  }

  void add_attenuation() {
    if (!site_.attenuation) return;
    const AttenuationPrior& a = *site_.attenuation;
    const double c = layout_.nominal_speed_mps;
    layout_.nominal_amplitude_v = a.amplitude_1m_v.value;
    const int first = layout_.size();
    if (a.amplitude_1m_v.sigma > 0)
      layout_.attenuation[0] =
          add(parameters::attenuation(0), 1.0, a.amplitude_1m_v.sigma / a.amplitude_1m_v.value,
              a.amplitude_1m_v.value, 1e-3);
    if (a.absorption_np_per_m.sigma > 0)
      layout_.attenuation[1] =
          add(parameters::attenuation(1), a.absorption_np_per_m.value, a.absorption_np_per_m.sigma, 1.0);
    if (a.rise_time_s.sigma > 0)
      layout_.attenuation[2] =
          add(parameters::attenuation(2), c * a.rise_time_s.value, c * a.rise_time_s.sigma, 1.0 / c, 0.0);
    if (a.half_power_angle_rad.sigma > 0)
      layout_.attenuation[3] =
          add(parameters::attenuation(3), a.half_power_angle_rad.value, a.half_power_angle_rad.sigma, 1.0,
              kLeastHalfPowerAngle_rad, kMostHalfPowerAngle_rad);
    block_from(first);
  }

  void add_gains() {
    layout_.beacon_gain.assign(site_.beacons.size(), -1);
    if (!site_.attenuation) return;
    for (std::size_t b = 0; b < site_.beacons.size(); ++b) {
      const Prior& gain = site_.beacons[b].log_gain;
      if (held_[b] || !(gain.sigma > 0)) continue;
      layout_.beacon_gain[b] = add(parameters::beacon_gain(b), gain.value, gain.sigma, 1.0);
      block_from(layout_.beacon_gain[b]);
    }
  }

  void add_pairs() {
    if (!site_.noise.pair_sigma_s || !(*site_.noise.pair_sigma_s > 0)) return;
    const double c = layout_.nominal_speed_mps;
    for (std::size_t b = 0; b < site_.beacons.size(); ++b)
      for (std::size_t r = 0; r < site_.receivers.size(); ++r) {
        const int first = layout_.size();
        layout_.pair_bias.push_back(
            held_[b] ? -1 : add(parameters::pair_bias(b, r), 0.0, c * *site_.noise.pair_sigma_s, 1.0 / c));
        block_from(first);
      }
  }

  const Problem& problem_;
  const Site& site_;
  const SharedState& state_;
  const std::vector<bool>& held_;
  ParameterLayout layout_;
};

/// Circumradius and direction of the first corner of a vehicle's octagon.
Eigen::Vector2d corner_of(const ParameterLayout& layout, const SharedState& state, std::size_t vehicle) {
  for (std::size_t r = 0; r < layout.vehicle_of_receiver.size(); ++r)
    if (layout.vehicle_of_receiver[r].index() == vehicle) {
      const Eigen::Vector3d& p = state.receiver_p_vehicle_m[r];
      return {p.head<2>().norm(), std::atan2(p.y(), p.x())};
    }
  return Eigen::Vector2d::Zero();
}

/// Turns and widens the octagons of a state to what the unknowns say.
void shape_arrays(const ParameterLayout& layout, const Eigen::VectorXd& x, SharedState& state) {
  for (std::size_t v = 0; v < layout.array.size(); ++v) {
    if (!layout.has_array(VehicleId(v))) continue;
    const Eigen::Vector2d now = corner_of(layout, state, v);
    const auto value = [&](int column, double held) {
      return column < 0 ? held : x[column] * layout.parameters[static_cast<std::size_t>(column)].si_per_unit;
    };
    const Eigen::Matrix2d shape =
        value(layout.array[v][0], now[0]) / now[0] *
        Eigen::Rotation2Dd(value(layout.array[v][1], now[1]) - now[1]).toRotationMatrix();
    for (std::size_t r = 0; r < layout.vehicle_of_receiver.size(); ++r)
      if (layout.vehicle_of_receiver[r].index() == v)
        state.receiver_p_vehicle_m[r].head<2>() = (shape * state.receiver_p_vehicle_m[r].head<2>()).eval();
  }
}

/// Visitor: see visit_parameter.
struct InLayout {
  const ParameterLayout& of;
  [[nodiscard]] int beacon_position(std::size_t b, std::size_t axis) const { return of.beacon[b][axis]; }
  [[nodiscard]] int beacon_delay(std::size_t b) const { return of.beacon_delay[b]; }
  [[nodiscard]] int beacon_gain(std::size_t b) const { return of.beacon_gain[b]; }
  [[nodiscard]] int receiver_position(std::size_t r, std::size_t axis) const { return of.receiver[r][axis]; }
  [[nodiscard]] int receiver_delay(std::size_t r) const { return of.receiver_delay[r]; }
  [[nodiscard]] int array(std::size_t v, std::size_t unknown) const { return of.array[v][unknown]; }
  [[nodiscard]] int site_delay() const { return of.site_delay; }
  [[nodiscard]] int speed(std::size_t run) const { return of.speed_column(run > 0 ? run - 1 : 0); }
  [[nodiscard]] int attenuation(std::size_t unknown) const { return of.attenuation[unknown]; }
  [[nodiscard]] int clock_drift(std::size_t v) const { return of.clock_drift[v]; }
  [[nodiscard]] int pair_bias(std::size_t b, std::size_t r) const {
    return of.pair_bias.empty() ? -1 : of.pair_bias[b * of.receiver.size() + r];
  }
};

}  // namespace

int ParameterLayout::column_of(const ParameterId& id) const { return visit_parameter(id, InLayout{*this}); }

SharedState ParameterLayout::state_of(const Eigen::VectorXd& x) const {
  SharedState state = fixed;
  if (state.speed_offset_mps.size() < speed.size())
    state.speed_offset_mps.resize(speed.size(), state.speed_offset_mps[0]);
  for (int i = 0; i < size(); ++i) {
    const Parameter& p = parameters[static_cast<std::size_t>(i)];
    if (double* value = value_in(state, p.id)) *value = x[i] * p.si_per_unit;
  }
  shape_arrays(*this, x, state);
  return state;
}

Eigen::VectorXd ParameterLayout::vector_of(const SharedState& state) const {
  SharedState copy = state;
  if (copy.speed_offset_mps.size() < speed.size())
    copy.speed_offset_mps.resize(speed.size(), copy.speed_offset_mps[0]);
  Eigen::VectorXd x(size());
  for (int i = 0; i < size(); ++i) {
    const Parameter& p = parameters[static_cast<std::size_t>(i)];
    if (const double* value = value_in(copy, p.id)) x[i] = *value / p.si_per_unit;
  }
  for (std::size_t v = 0; v < array.size(); ++v) {
    if (!has_array(VehicleId(v))) continue;
    const Eigen::Vector2d now = corner_of(*this, state, v);
    if (array[v][0] >= 0) x[array[v][0]] = now[0];
    if (const int turn = array[v][1]; turn >= 0) {
      const Parameter& p = parameters[static_cast<std::size_t>(turn)];
      x[turn] = p.prior_mean + wrap_angle(now[1] - p.prior_mean * p.si_per_unit) / p.si_per_unit;
    }
  }
  return x;
}

Eigen::VectorXd JointPrior::residual(const Eigen::VectorXd& x) const { return root * (x(columns) - mean); }

JointPrior joint_prior(std::vector<int> columns, Eigen::VectorXd mean, const Eigen::MatrixXd& covariance) {
  // C = L L', so that R = L^-1; millimetres beside metres are scaled alike first.
  const Eigen::VectorXd inverse = covariance.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd root = inverse.asDiagonal();
  Eigen::LLT<Eigen::MatrixXd>(inverse.asDiagonal() * covariance * inverse.asDiagonal())
      .matrixL()
      .solveInPlace(root);
  return {std::move(columns), std::move(mean), std::move(root)};
}

ParameterLayout make_layout(const Problem& problem, const SharedState& state, const std::vector<bool>& held) {
  return LayoutBuilder(problem, state, held).build();
}

}  // namespace octant::calib
