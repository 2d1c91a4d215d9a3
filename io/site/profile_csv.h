// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/physics/speed_profile.h"
#include "models/support/result.h"

namespace octant::io {

/// Reads a profile of the speed of sound (contract: medium.profile): `depth_m` or `height_m`, and `speed_mps`
/// or `temperature_degC` with `salinity` [parts per thousand]. Rows run upwards or downwards.
/// Errors: a missing column, a speed that is not positive, depths that do not run in one direction.
[[nodiscard]] Result<SpeedProfile> read_profile(const std::string& path);

}  // namespace octant::io
