// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace octant::fuzz {

/// Lines of `octant localize --follow`, after a byte that chooses method and watch: what comes out is JSON
/// and NMEA 0183 without NaN, the same however the bytes are cut into pieces.
void take_live(std::string_view input);

}  // namespace octant::fuzz
