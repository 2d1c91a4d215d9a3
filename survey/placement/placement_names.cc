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
template <class Enum, std::size_t N>
const char* name_of(Enum value, const std::pair<const char*, Enum> (&names)[N]) {
  for (const auto& [spelled, other] : names)
    if (value == other) return spelled;
  return names[0].first;
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
const char* to_string(PlacementGoal goal) { return name_of(goal, kGoals); }
const char* to_string(GlobalAlgorithm algorithm) { return name_of(algorithm, kGlobals); }
const char* to_string(LocalAlgorithm algorithm) { return name_of(algorithm, kLocals); }

}  // namespace octant::survey
