// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace octant::calib {

/// A beacon that the data do not determine.
struct UndeterminedBeacon {
  std::string beacon, why, remedy;
  double sigma_m = 0.0;  ///< sigma of its position if that is the reason, otherwise 0
};

/// Sigma from which a position is described as unknown.
inline constexpr double kNothingM = 1e4;

/// A length in words; "nothing" from kNothingM on.
[[nodiscard]] std::string length_in_words(double length_m);

/// Groups beacons by reason: "beacon A4 (it was not heard)"; inaccurate ones together as "beacons A1, A2, A3
/// (their positions are known to 34 to 49 mm only, the tolerance is 30 mm)".
/// @param limit_m  the tolerance
[[nodiscard]] std::vector<std::string> in_groups(const std::vector<UndeterminedBeacon>& beacons,
                                                 double limit_m);

/// A warning for each group, with its remedy.
[[nodiscard]] std::vector<std::string> warnings_of(const std::vector<UndeterminedBeacon>& beacons,
                                                   double limit_m);

}  // namespace octant::calib
