// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "models/fix.h"
#include "models/localizers/methods.h"
#include "models/localizers/speed/run_speed.h"
#include "models/run.h"
#include "models/site.h"

namespace octant::python {

/// Implementation of octant.Fixes.
struct Fixes {
  std::vector<Fix> fixes;
  NameTable names;
  std::optional<RunSpeed> speed{};  ///< set for a run at an unknown temperature
};

/// Raises ValueError for an unknown method.
[[nodiscard]] Method method_named(const std::string& name);

/// Dictionary with the keys of the block `odometry` in run.yaml; without one the defaults apply.
using OdometrySigmas = std::optional<std::map<std::string, double>>;
[[nodiscard]] OdometryAccuracy odometry_noise(const OdometrySigmas& sigmas);

/// Implementation of octant.Follower.
void bind_live(pybind11::module_& m);

}  // namespace octant::python
