// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the unit that the name of a column states.

#include <string_view>

#include "models/support/result.h"

namespace octant::io {

/// Value in the unit of a column of tof.csv: factor * value + offset.
struct UnitConversion {
  double factor = 1.0, offset = 0.0;
};

/// Reads the unit at the end of a column's name: in brackets ("Laufzeit [ms]", "range (cm)", "T in degF"), or
/// behind an underscore ("timestamp_ms"), or as the whole name (Arduino's "micros"). A name without a unit is
/// in the unit of the target.
/// @param target  column of tof.csv whose name ends with its unit: time_s, tof_s, distance_m, ...
/// Errors: kBadInput without a place: a unit in brackets that is not known, or a unit of another quantity.
[[nodiscard]] Result<UnitConversion> unit_of_column(std::string_view name, std::string_view target);

/// The name without the unit at its end.
[[nodiscard]] std::string_view without_unit(std::string_view name);
/// True for a unit alone, with or without brackets.
[[nodiscard]] bool is_unit(std::string_view text);

/// The factor of a unit behind an underscore that may be another word too ("time_min", "distance_in"), and
/// is therefore not used; 1 without one.
[[nodiscard]] double factor_of_doubtful_unit(std::string_view name, std::string_view target);

}  // namespace octant::io
