// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "models/deployment.h"
#include "models/localizers/methods.h"

namespace octant::app {

/// --method and what some methods take beside deployment and run.
struct MethodArgs {
  Method method = Method::kAuto;
  std::string map;  ///< a run with scans and measured poses, for a line map; empty: none
  KleemanHeading heading = KleemanHeading::kInterpolation;
};
[[nodiscard]] MethodInput method_input(const MethodArgs& args, const Deployment& deployment);

/// A line map starts from the run's first measured pose; no other method looks at poses.tum.
[[nodiscard]] inline bool looks_at_poses(const MethodArgs& args) {
  return args.method == Method::kLineMap || !args.map.empty();
}

/// --method and what some of them take, of the commands that localize.
void add_method_options(CLI::App& command, MethodArgs& args);

}  // namespace octant::app
