// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "models/network/network.h"

namespace octant::calib {

/// Column of each unknown of a network; -1 where a coordinate is fixed or absent.
struct NetworkColumns {
  std::vector<std::array<int, 3>> point;
  std::vector<int> datum;  ///< columns of datum coordinates
  int first_set = 0, first_scale = 0, first_constant = 0, size = 0;
};

[[nodiscard]] NetworkColumns network_columns(const Network& network);

/// Misclosure of an observation and its derivatives.
struct SurveyRow {
  double misclosure = 0.0;                      ///< observed less computed [rad] or [m]; angles in (-pi, pi]
  std::vector<std::pair<int, double>> entries;  ///< derivative of the computed value by column
};

/// @param x  all unknowns in the order of `columns`: coordinates [m], orientations [rad], scales less one,
/// constants [m]
[[nodiscard]] SurveyRow survey_row(const Network& network, const NetworkColumns& columns,
                                   const SurveyObservation& observation, const Eigen::VectorXd& x);

/// Unknowns at the approximate coordinates; the orientation of a set is the median over its directions.
[[nodiscard]] Eigen::VectorXd initial_unknowns(const Network& network, const NetworkColumns& columns);

}  // namespace octant::calib
