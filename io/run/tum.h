// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "models/fix.h"
#include "models/run.h"
#include "models/site.h"
#include "models/support/result.h"

namespace octant::io {

class ContinuedClock;

/// Reads `time_s x y z qx qy qz qw` rows, strictly increasing in time; # starts a comment. Quaternions are
/// normalised. Errors name line and column.
/// @param file   for messages
/// @param clock  continues a clock that starts again; without it, a step back is an error
[[nodiscard]] Result<std::vector<TimedPose>> tum_from_text(std::string_view text, const std::string& file,
                                                           ContinuedClock* clock = nullptr);
/// Motion from each pose to the next, in the frame of the first of the two. The first step is zero.
[[nodiscard]] std::vector<OdometryStep> steps_between(const std::vector<TimedPose>& poses, VehicleId vehicle);
[[nodiscard]] std::string poses_to_tum(const std::vector<TimedPose>& poses);
/// The fixes that are ok, as TUM.
[[nodiscard]] std::string fixes_to_tum(const std::vector<Fix>& fixes);
/// All fixes, as CSV with the contract's columns; fields of a missing fix are empty, status says why.
[[nodiscard]] std::string fixes_to_csv(const std::vector<Fix>& fixes, const NameTable& names);

}  // namespace octant::io
