// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "models/deployment.h"
#include "models/parameter.h"

namespace octant {

/// What a deployment knows of its shared numbers, together. SI units.
struct KnownParameters {
  std::vector<ParameterId> parameters;
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;  ///< zero rows: held fixed
  double speed_mps = 343.0;    ///< of the medium, for what delays are worth

  [[nodiscard]] Eigen::Index size() const { return value.size(); }
  /// Where a parameter stands; -1: not known.
  [[nodiscard]] int index_of(const ParameterId& id) const { return octant::index_of(parameters, id); }
};

/// All but beacons that are undetermined. A site's one delay stands on every beacon, fully correlated;
/// receivers of an octagon that was adjusted as a whole have the covariance that its radius and turn give
/// them.
[[nodiscard]] KnownParameters known_parameters(const Deployment& deployment);

/// Variances by which they may have drifted; those of amplitude, absorption and rise time in proportion to
/// the values.
[[nodiscard]] Eigen::VectorXd drift_variances(const KnownParameters& known, const Drift& drift);

/// Motions of the whole map as columns: along x, y and about z (planar), or all six; turns about the beacons'
/// centre [m, m/rad].
[[nodiscard]] Eigen::MatrixXd map_motions(const KnownParameters& known, Motion motion);

}  // namespace octant
