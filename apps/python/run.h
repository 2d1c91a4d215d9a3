// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "models/run.h"
#include "models/site.h"

namespace octant::python {

/// A recording with the names of its ids.
struct Run {
  MeasurementLog log;
  NameTable names;
};

/// Returns true if the ids of beacons, vehicles and receivers have the same names in both tables.
[[nodiscard]] bool same_names(const NameTable& a, const NameTable& b);

}  // namespace octant::python
