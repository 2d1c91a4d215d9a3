// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "calib/problem/parameters.h"
#include "calib/problem/problem.h"
#include "models/deployment.h"

namespace octant::calib {

/// Describes what defines position, orientation and scale of the map: control points first, then measured
/// poses, approximate positions (priors), taped distances. Also names undefined components.
[[nodiscard]] Datum datum_of(const Problem& problem);

/// Sets the datum of a map without any reference, which inner constraints define.
void set_free_network(Datum& datum);

/// Motions of the whole map that the problem determines no better than a quarter of the typical range
/// (planar: x, y, heading; spatial: six), as orthonormal columns over the free parameters. Empty if the datum
/// is fixed.
/// @param information  dense or sparse
template <class Matrix>
[[nodiscard]] Eigen::MatrixXd free_datum(const Problem& problem, const ParameterLayout& layout,
                                         const SharedState& state, const Matrix& information);

}  // namespace octant::calib
