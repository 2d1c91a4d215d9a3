// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/parameters.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/Cholesky>

#include "models/support/unit_diagonal.h"

namespace octant::calib {
namespace {

/// Circumradius and direction of the first corner of a vehicle's octagon.
Eigen::Vector2d corner_of(const ParameterLayout& layout, const SharedState& state, std::size_t vehicle) {
  for (std::size_t r = 0; r < layout.vehicle_of_receiver.size(); ++r)
    if (layout.vehicle_of_receiver[r].index() == vehicle) {
      const Eigen::Vector3d& p = state.receiver_p_vehicle_m[r];
      return {p.head<2>().norm(), std::atan2(p.y(), p.x())};
    }
  return Eigen::Vector2d::Zero();
}

/// Rotates and scales the octagons of a state by their unknowns.
void shape_arrays(const ParameterLayout& layout, const Eigen::VectorXd& x, SharedState& state) {
  for (std::size_t v = 0; v < layout.vehicles(); ++v) {
    if (!layout.has_array(VehicleId(v))) continue;
    const Eigen::Vector2d now = corner_of(layout, state, v);
    const auto value = [&](int column, double held) {
      return column < 0 ? held : x[column] * layout.parameter(column).si_per_unit;
    };
    const Eigen::Matrix2d shape =
        value(layout.column_of(parameters::array_radius(v)), now[0]) / now[0] *
        Eigen::Rotation2Dd(value(layout.column_of(parameters::array_turn(v)), now[1]) - now[1])
            .toRotationMatrix();
    for (std::size_t r = 0; r < layout.vehicle_of_receiver.size(); ++r)
      if (layout.vehicle_of_receiver[r].index() == v)
        state.receiver_p_vehicle_m[r].head<2>() = (shape * state.receiver_p_vehicle_m[r].head<2>()).eval();
  }
}

/// Parameters of a block have one owner and kind; those of pairs are separate blocks.
bool shares_block(const ParameterId& a, const ParameterId& b) {
  return a.kind == b.kind && a.owner == b.owner && a.kind != ParameterKind::kPairBias;
}

}  // namespace

void ParameterLayout::add(const SharedPrior& p) {
  const int column = size();
  if (column > 0 && shares_block(parameters.back().id, p.id)) {
    ++blocks.back().size;
  } else {
    blocks.push_back({column, 1});
  }
  parameters.push_back({p.id, p.mean / p.si_per_unit, p.sigma / p.si_per_unit, p.si_per_unit,
                        p.lower / p.si_per_unit, p.upper / p.si_per_unit});
  column_.set(p.id, column);
  if (p.id.kind == ParameterKind::kBeaconPosition) beacon[p.id.owner][p.id.component] = column;
  if (p.id.kind == ParameterKind::kReceiverPosition) receiver[p.id.owner][p.id.component] = column;
  if (p.id.kind == ParameterKind::kSpeed) speed.push_back(column);
}

ParameterLayout make_layout(const Problem& problem, const SharedState& state,
                            const std::vector<bool>& beacon_usable) {
  const Site& site = problem.site;
  ParameterLayout layout;
  layout.fixed = state;
  layout.nominal_speed_mps = speed_mps(site.medium);
  layout.beacon.assign(site.beacons.size(), {-1, -1, -1});
  layout.receiver.assign(site.receivers.size(), {-1, -1, -1});
  layout.vehicles_ = site.vehicles.size();
  for (const SiteReceiver& receiver : site.receivers) layout.vehicle_of_receiver.push_back(receiver.vehicle);
  for (const SharedPrior& prior : shared_priors(site, problem.runs.size())) {
    const ParameterOwner owner = row_of(prior.id.kind).owner;
    const bool is_of_beacon = owner == ParameterOwner::kBeacon || owner == ParameterOwner::kPair;
    if (!is_of_beacon || beacon_usable.empty() || beacon_usable[prior.id.owner]) layout.add(prior);
  }
  return layout;
}

Eigen::VectorXd ParameterLayout::si_per_unit() const {
  Eigen::VectorXd si(size());
  for (int i = 0; i < size(); ++i) si[i] = parameter(i).si_per_unit;
  return si;
}

std::vector<int> ParameterLayout::beacon_columns() const {
  std::vector<int> columns;
  for (const std::array<int, 3>& place : beacon)
    std::ranges::copy_if(place, std::back_inserter(columns), [](int c) { return c >= 0; });
  return columns;
}

void ParameterLayout::set_place(std::size_t b, const Eigen::Vector3d& p_map_m, Eigen::VectorXd& x) const {
  for (std::size_t i = 0; i < 3; ++i)
    if (const int c = beacon[b][i]; c >= 0) x[c] = p_map_m[static_cast<Eigen::Index>(i)];
}

SharedState ParameterLayout::state_of(const Eigen::VectorXd& x) const {
  SharedState state = fixed;
  if (state.speed_offset_mps.size() < speed.size())
    state.speed_offset_mps.resize(speed.size(), state.speed_offset_mps[0]);
  for (int i = 0; i < size(); ++i) {
    const Parameter& p = parameter(i);
    if (double* value = value_in(state, p.id)) *value = x[i] * p.si_per_unit;
  }
  shape_arrays(*this, x, state);
  return state;
}

Eigen::VectorXd ParameterLayout::vector_of(const SharedState& state) const {
  SharedState copy = state;
  if (copy.speed_offset_mps.size() < speed.size())
    copy.speed_offset_mps.resize(speed.size(), copy.speed_offset_mps[0]);
  Eigen::VectorXd x = Eigen::VectorXd::Constant(size(), NAN);  // what the state has not is seen
  for (int i = 0; i < size(); ++i) {
    const Parameter& p = parameter(i);
    if (const double* value = value_in(copy, p.id)) x[i] = *value / p.si_per_unit;
  }
  for (std::size_t v = 0; v < vehicles_; ++v) {
    if (!has_array(VehicleId(v))) continue;
    const Eigen::Vector2d now = corner_of(*this, state, v);
    if (const int radius = column_of(parameters::array_radius(v)); radius >= 0) x[radius] = now[0];
    if (const int turn = column_of(parameters::array_turn(v)); turn >= 0) {
      const Parameter& p = parameter(turn);
      x[turn] = p.prior_mean + wrap_angle(now[1] - p.prior_mean * p.si_per_unit) / p.si_per_unit;
    }
  }
  return x;
}

Eigen::VectorXd JointPrior::residual(const Eigen::VectorXd& x) const { return root * (x(columns) - mean); }

JointPrior joint_prior(std::vector<int> columns, Eigen::VectorXd mean, const Eigen::MatrixXd& covariance) {
  // C = L L', so that the root is L^-1.
  const UnitDiagonal<Eigen::MatrixXd> unit(covariance);
  Eigen::MatrixXd root = unit.inverse_scale.asDiagonal();
  Eigen::LLT<Eigen::MatrixXd>(unit.scaled).matrixL().solveInPlace(root);
  return {std::move(columns), std::move(mean), std::move(root)};
}

}  // namespace octant::calib
