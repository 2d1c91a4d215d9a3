// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/problem/problem.h"
#include "models/parameter.h"
#include "models/trajectory/shared_state.h"

namespace octant::calib {

/// One shared unknown. Inside the adjustment all are metres or pure numbers, so that radio and sound scale
/// alike.
struct Parameter {
  ParameterId id;
  double prior_mean = 0.0;                     ///< internal unit
  double prior_sigma = 0.0;                    ///< internal unit; infinite: no prior
  double si_per_unit = 1.0;                    ///< SI value = internal value times this
  double lower = -INFINITY, upper = INFINITY;  ///< bounds, internal unit
};

/// Joint prior of some parameters, in internal units: root (x - mean) has the covariance of unit noise.
struct JointPrior {
  std::vector<int> columns;  ///< ascending; their own Parameter::prior_sigma is infinite
  Eigen::VectorXd mean;
  Eigen::MatrixXd root;  ///< the same number of columns; R'R is the inverse of the covariance

  /// root (x - mean) at a vector of all parameters.
  [[nodiscard]] Eigen::VectorXd residual(const Eigen::VectorXd& x) const;
};
/// @param covariance  positive definite
[[nodiscard]] JointPrior joint_prior(std::vector<int> columns, Eigen::VectorXd mean,
                                     const Eigen::MatrixXd& covariance);

/// Free parameters that belong together: one parameter block of the solver.
struct ParameterBlock {
  int first = 0;  ///< column of its first parameter
  int size = 0;
};

/// Number of parameters up to which one dense system is the fastest.
inline constexpr int kDenseLimit = 600;

/// Free shared numbers, and their columns in the vector of unknowns (-1: fixed).
struct ParameterLayout {
  std::vector<Parameter> parameters;
  std::vector<ParameterBlock> blocks;
  std::vector<std::array<int, 3>> beacon, receiver;  ///< columns of their positions
  std::vector<int> speed;  ///< columns of the offsets: none, one for all, or one for each run
  std::vector<VehicleId> vehicle_of_receiver;
  double nominal_speed_mps = 343.0;       ///< turns delays into metres
  int dense_limit = kDenseLimit;          ///< largest number of parameters with dense matrices
  SharedState fixed;                      ///< values of the fixed numbers
  std::optional<JointPrior> joint_prior;  ///< in addition to the priors of single parameters

  [[nodiscard]] int size() const { return static_cast<int>(parameters.size()); }
  [[nodiscard]] const Parameter& parameter(Eigen::Index column) const {
    return parameters[static_cast<std::size_t>(column)];
  }
  [[nodiscard]] Parameter& parameter(Eigen::Index column) {
    return parameters[static_cast<std::size_t>(column)];
  }
  [[nodiscard]] Eigen::VectorXd si_per_unit() const;  ///< units of all parameters
  /// Columns of all free coordinates of beacons.
  [[nodiscard]] std::vector<int> beacon_columns() const;
  /// Columns of a beacon's position and delay; -1: fixed.
  [[nodiscard]] std::array<int, 4> columns_of_beacon(std::size_t b) const {
    return {beacon[b][0], beacon[b][1], beacon[b][2], column_of(parameters::beacon_delay(b))};
  }
  /// Sets the position of a beacon, as far as its coordinates are free.
  void set_place(std::size_t beacon, const Eigen::Vector3d& p_map_m, Eigen::VectorXd& x) const;
  /// -1: fixed. A single offset of the speed is that of every run; of several, the first one represents all
  /// runs.
  [[nodiscard]] int column_of(const ParameterId& id) const {
    if (id.kind == ParameterKind::kSpeed) return speed_column(id.owner > 0 ? id.owner - 1 : 0);
    return column_[id];
  }
  /// Column of the speed offset of a run; -1: not free.
  [[nodiscard]] int speed_column(std::size_t run) const {
    return speed.empty() ? -1 : speed[speed.size() > 1 ? run : 0];
  }
  [[nodiscard]] SharedState state_of(const Eigen::VectorXd& x) const;
  [[nodiscard]] Eigen::VectorXd vector_of(const SharedState& state) const;
  [[nodiscard]] std::size_t vehicles() const { return vehicles_; }
  /// Returns true if the vehicle's receivers are adjusted as a rigid array.
  [[nodiscard]] bool has_array(VehicleId vehicle) const {
    return column_of(parameters::array_radius(vehicle.index())) >= 0 ||
           column_of(parameters::array_turn(vehicle.index())) >= 0;
  }

 private:
  friend ParameterLayout make_layout(const Problem&, const SharedState&, const std::vector<bool>&);
  void add(const SharedPrior& prior);

  ParameterIndex column_;
  std::size_t vehicles_ = 0;
};

[[nodiscard]] inline bool is_dense(const ParameterLayout& layout) {
  return layout.size() <= layout.dense_limit;
}

/// Free parameters of a problem.
/// @param beacon_usable  all others keep the position and delay they have in `state`; empty: all are
[[nodiscard]] ParameterLayout make_layout(const Problem& problem, const SharedState& state,
                                          const std::vector<bool>& beacon_usable = {});

}  // namespace octant::calib
