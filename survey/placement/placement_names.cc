// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "survey/placement/placement.h"

namespace octant::survey {
namespace {

template <class Enum, std::size_t N>
std::optional<Enum> by_name(const std::string& name, const std::pair<const char*, Enum> (&names)[N]) {
  for (const auto& [spelled, value] : names)
    if (name == spelled) return value;
  return {};
}

constexpr std::pair<const char*, PlacementGoal> kGoals[] = {
    {"worst", PlacementGoal::kWorst}, {"p95", PlacementGoal::kP95}, {"mean", PlacementGoal::kMean}};
constexpr std::pair<const char*, GlobalAlgorithm> kGlobals[] = {{"none", GlobalAlgorithm::kNone},
                                                                {"crs2", GlobalAlgorithm::kCrs2},
                                                                {"direct", GlobalAlgorithm::kDirect},
                                                                {"isres", GlobalAlgorithm::kIsres},
                                                                {"esch", GlobalAlgorithm::kEsch}};
constexpr std::pair<const char*, LocalAlgorithm> kLocals[] = {{"none", LocalAlgorithm::kNone},
                                                              {"bobyqa", LocalAlgorithm::kBobyqa},
                                                              {"cobyla", LocalAlgorithm::kCobyla},
                                                              {"sbplx", LocalAlgorithm::kSbplx}};

}  // namespace

std::optional<PlacementGoal> placement_goal(const std::string& name) { return by_name(name, kGoals); }
std::optional<GlobalAlgorithm> global_algorithm(const std::string& name) { return by_name(name, kGlobals); }
std::optional<LocalAlgorithm> local_algorithm(const std::string& name) { return by_name(name, kLocals); }

}  // namespace octant::survey
