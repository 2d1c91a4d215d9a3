// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
/// Least-squares adjustment of a survey network (Gauss-Markov model), with Baarda's reliability.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "models/network/network.h"

namespace octant::calib {

struct NetworkOptions {
  double sigma_unit = 1.0;           ///< a priori sigma of unit weight
  bool sigmas_a_posteriori = false;  ///< scale covariances by the estimated variance factor
  int max_iterations = 50;           ///< Gauss-Newton steps
  double tolerance_m = 1e-9;         ///< largest coordinate step of a converged adjustment
  /// Inner constraints refer to the coordinates before each step instead of the approximate coordinates.
  bool datum_follows = false;
  int dense_limit = 1000;  ///< largest number of unknowns whose whole covariance matrix is computed
};

enum class NetworkStatus {
  kConverged,
  kNotConverged,
  kUndetermined,  ///< the datum coordinates or the observations do not determine all unknowns
};

/// Reliability of one observation. Units of the observation: [rad] or [m].
struct ObservationResult {
  double residual = 0.0;         ///< adjusted less observed
  double redundancy = 0.0;       ///< 0 (not checked) to 1
  double w = 0.0;                ///< standardised residual; 0 without redundancy
  double detectable_bias = 0.0;  ///< minimal detectable bias; infinite without redundancy
};

struct NetworkSolution {
  NetworkStatus status = NetworkStatus::kNotConverged;
  int iterations = 0;
  int defect = 0;                 ///< datum defect, fixed by inner constraints over the datum coordinates
  int redundancy = 0;             ///< observations less unknowns plus defect
  double variance_factor = 1.0;   ///< a posteriori, relative to sigma_unit squared; 1 without redundancy
  std::vector<int> undetermined;  ///< unknowns that observations and datum do not determine
  std::vector<Eigen::Vector3d> points_m;              ///< adjusted, in the order of the network
  std::vector<Eigen::Matrix3d> point_covariances_m2;  ///< zero where a coordinate is fixed or absent
  Eigen::VectorXd unknowns;    ///< coordinates [m], orientations [rad], scales less one, constants [m]
  Eigen::MatrixXd covariance;  ///< of the unknowns; empty beyond the dense limit
  std::vector<ObservationResult> observations;
};

/// Adjusts a network from approximate coordinates, which must be near enough for Gauss-Newton to converge.
/// A rank defect of the normal equations is removed by inner constraints over the datum coordinates: their
/// corrections against the approximate coordinates have the smallest sum of squares.
[[nodiscard]] NetworkSolution adjust_network(const Network& network, const NetworkOptions& options = {});

}  // namespace octant::calib
