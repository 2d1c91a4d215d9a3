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

/// Any well-formed one: what the bytes choose of a simulated world (any sizes, sigmas, clocks, delays,
/// media), distorted by what they say after that, written and read back by the readers of files. At most
/// eight beacons, three receivers and some hundred arrivals. Nothing where the readers refuse it, as they
/// may.
[[nodiscard]] std::optional<SmallWorld> small_world(std::string_view input);

}  // namespace octant::fuzz
