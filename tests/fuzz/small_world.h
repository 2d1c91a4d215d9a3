// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "models/run.h"
#include "models/site.h"

namespace octant::fuzz {

/// A small site and a recording at it.
struct SmallWorld {
  Site site;
  MeasurementLog run;
};

/// A well-formed world: the first bytes select a simulated world (any sizes, sigmas, clocks, delays, media),
/// and the following bytes distort it. It is written, and read back by the readers of files. At most eight
/// beacons, three receivers and about a hundred arrivals. No value if the readers refuse it.
[[nodiscard]] std::optional<SmallWorld> small_world(std::string_view input);

}  // namespace octant::fuzz
