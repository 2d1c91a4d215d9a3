// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "calib/problem/parameters.h"
#include "calib/problem/problem.h"
#include "models/deployment.h"

namespace octant::calib {

/// What fixes position, orientation and scale of the map, in words and as data: control points first, then
/// measured poses, approximate positions (priors), taped distances; what nothing fixes is said so.
[[nodiscard]] Datum datum_of(const Problem& problem);

/// Makes the datum that of a map which turned out to hang on nothing: inner constraints carry it.
void set_free_network(Datum& datum);

/// Motions of the whole map that nothing in a problem tells to better than a quarter of the typical range
/// (planar: x, y, heading; spatial: six), as columns over the free parameters; orthonormal, none where the
/// datum is fixed.
/// @param information  dense or sparse
template <class Matrix>
[[nodiscard]] Eigen::MatrixXd free_datum(const Problem& problem, const ParameterLayout& layout,
                                         const SharedState& state, const Matrix& information);

}  // namespace octant::calib
