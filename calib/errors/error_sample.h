// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "calib/adjust/covariance.h"
#include "calib/errors/draw_kernel.h"
#include "calib/problem/parameters.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

/// A row for each observation, many columns: a pass over the rows takes all columns of each together.
using ByRow = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Used observations as an error model needs them: residuals, influences, positions and times.
struct ErrorSample {
  enum class Kind {
    kArrival,
    kBearing,
    kOther
  };  ///< other: amplitudes, poses, odometry, motion; used with their given sigmas
  struct Row {
    Kind kind = Kind::kArrival;
    std::size_t run = 0;
    int beacon = 0, receiver = 0;
    double time_s = 0.0;
    Eigen::Vector3d p_map_m =
        Eigen::Vector3d::Zero();  ///< position of the receiver; for bearings of the vehicle
    double direction_rad = 0.0;   ///< to the beacon, in the vehicle frame
    double aspect_rad = 0.0;      ///< from the beacon to the receiver, in the map
    double range_m = 0.0;
  };
  std::vector<Row> rows;
  Eigen::VectorXd residual;  ///< whitened
  Eigen::VectorXd pattern;   ///< effect of a common error of size one on the residuals; may be empty
  ByRow F;                   ///< rows x rank: d theta = -L f' e
  Eigen::MatrixXd L;         ///< root of the white covariance
  double share = 1.0;        ///< fraction of all arrivals and bearings in the sample

  Eigen::MatrixXd
      /// K K' = I - F'F: covariance of the contribution of priors, tapes and other terms without a row to F'e
      prior_root;

  StateTaps J;  ///< derivatives by the states of the vehicle
  StateChains chains;
};

/// @param most  arrivals; longer logs of stops are sampled evenly
[[nodiscard]] ErrorSample error_sample(const ParameterLayout& layout,
                                       const std::vector<Trajectory>& trajectories, const SharedState& state,
                                       const Covariance& C, std::size_t most);

}  // namespace octant::calib
