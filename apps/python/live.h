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

/// What octant.Fixes is.
struct Fixes {
  std::vector<Fix> fixes;
  NameTable names;
  std::optional<RunSpeed> speed{};  ///< of a run at an unknown temperature
};

/// Raises ValueError where there is no such method.
[[nodiscard]] Method method_named(const std::string& name);

/// A dict with the keys of run.yaml's block `odometry`; none: what holds where that says nothing.
using OdometrySigmas = std::optional<std::map<std::string, double>>;
[[nodiscard]] OdometryAccuracy odometry_noise(const OdometrySigmas& sigmas);

/// octant.Follower.
void bind_live(pybind11::module_& m);

}  // namespace octant::python
