// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/parameter.h"

namespace octant {

/// Shared parameters of a deployment with their joint covariance. SI units.
struct KnownParameters {
  std::vector<ParameterId> parameters;
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;  ///< fixed parameters have zero rows
  double speed_mps = 343.0;    ///< speed of the medium, which converts delays into ranges

  [[nodiscard]] Eigen::Index size() const { return value.size(); }
  /// Index of a parameter; -1 if it is not known.
  [[nodiscard]] int index_of(const ParameterId& id) const { return octant::index_of(parameters, id); }
};

/// All parameters except those of undetermined beacons. A common delay appears on every beacon, fully
/// correlated. Receivers of an octagon that was adjusted as a whole have the covariance that follows from its
/// radius and turn.
[[nodiscard]] KnownParameters known_parameters(const Deployment& deployment);

/// Variances of the expected drift; for amplitude, absorption and rise time relative to their values.
[[nodiscard]] Eigen::VectorXd drift_variances(const KnownParameters& known, const Drift& drift);

/// Motions of the whole map as columns: along x, y and about z (planar), or all six. Rotations are about the
/// centre of the beacons [m, m/rad].
[[nodiscard]] Eigen::MatrixXd map_motions(const KnownParameters& known, Motion motion);

}  // namespace octant
