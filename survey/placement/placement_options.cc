// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/placement/placement_options.h"

#include "models/support/enum_names.h"

namespace octant::survey {

std::optional<PlacementGoal> placement_goal(const std::string& name) {
  return enum_names<PlacementGoal>("worst", "p95", "mean").find(name);
}
std::optional<GlobalAlgorithm> global_algorithm(const std::string& name) {
  return enum_names<GlobalAlgorithm>("none", "crs2", "direct", "isres", "esch").find(name);
}
std::optional<LocalAlgorithm> local_algorithm(const std::string& name) {
  return enum_names<LocalAlgorithm>("none", "bobyqa", "cobyla", "sbplx").find(name);
}

}  // namespace octant::survey
