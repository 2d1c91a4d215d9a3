// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "calib/readings/reading.h"
#include "calib/statements/common_errors.h"

namespace octant::calib {

/// Readings that differ by one number: by how much a clock is late, or a way too long.
struct ReadingFamily {
  std::function<Reading(double size)> reading;
  double least = 0.0, most = 0.0;           ///< sizes that are looked at, of either sign
  std::function<bool(double)> may_be = {};  ///< whether a size explains anything; empty: all do
};

/// Measured poses of a moving vehicle that are stamped late or early, up to some two seconds; none where
/// there are none. A lag that leaves arrivals without a pose explains nothing.
[[nodiscard]] std::vector<ReadingFamily> poses_stamped_late(const std::vector<MeasurementLog>& runs);

/// Odometry whose way is too long or too short (wheels of another diameter), or whose turns are (wheels
/// farther apart), by one part in a hundred to two thirds; none where there is none, or it is in space.
[[nodiscard]] std::vector<ReadingFamily> odometry_of_other_scale(const Site& site,
                                                                 const std::vector<MeasurementLog>& runs);

/// Of the errors of arrivals that the residuals show (common_errors.h) the clearest: a medium that changes, a
/// clock that drifts or jumps. The site and the runs outlive it.
[[nodiscard]] std::vector<ReadingFamily> with_common_errors(const std::vector<CommonError>& errors,
                                                            const Site& site,
                                                            const std::vector<MeasurementLog>& runs);

/// Odometry that is stamped late or early; none where there is none.
[[nodiscard]] std::vector<ReadingFamily> odometry_stamped_late(const std::vector<MeasurementLog>& runs);

/// The size that explains the recordings best: steps by factors of two, the best of them refined to a part in
/// a hundred.
/// @param loss  of the recordings when a size is taken back; some thirty are asked for
[[nodiscard]] double likeliest_size(double least, double most, const std::function<double(double)>& loss);

}  // namespace octant::calib
