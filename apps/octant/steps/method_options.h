// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "models/deployment.h"
#include "models/localizers/methods.h"

namespace octant::app {

/// --method, and further inputs of some methods.
struct MethodArgs {
  Method method = Method::kAuto;
  std::string map;  ///< run with scans and measured poses for a line map; empty: none
  KleemanHeading heading = KleemanHeading::kInterpolation;
};
[[nodiscard]] MethodInput method_input(const MethodArgs& args, const Deployment& deployment);

/// A line map starts at the run's first measured pose; other methods do not use poses.tum.
[[nodiscard]] inline bool looks_at_poses(const MethodArgs& args) {
  return args.method == Method::kLineMap || !args.map.empty();
}

/// Adds --method and the options of some methods to a command that localizes.
void add_method_options(CLI::App& command, MethodArgs& args);

}  // namespace octant::app
