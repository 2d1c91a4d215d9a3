// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/solve_network.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "calib/network/check_network.h"
#include "calib/network/locate_points.h"
#include "calib/network/select_observations.h"
#include "calib/network/survey_row.h"

namespace octant::calib {
namespace {

bool is_adjusted(const NetworkPoint& point) {
  return std::ranges::any_of(point.role, [](CoordinateRole r) { return r >= CoordinateRole::kFree; });
}

/// Removes the roles of a point in the plane or in height.
void leave_out(NetworkPoint& point, std::size_t axis) {
  if (axis == 2)
    point.role[2] = CoordinateRole::kAbsent;
  else
    point.role[0] = point.role[1] = CoordinateRole::kAbsent;
}

std::vector<std::string> leave_out_unlocated(Network& network) {
  std::vector<std::string> names;
  for (NetworkPoint& point : network.points)
    for (std::size_t i = 0; i < 3; ++i)
      if (point.role[i] != CoordinateRole::kAbsent && !point.known[i]) {
        leave_out(point, i);
        if (names.empty() || names.back() != point.id) names.push_back(point.id);
      }
  return names;
}

std::vector<std::string> leave_out_undetermined(Network& network, const std::vector<int>& unknowns) {
  std::vector<std::string> names;
  const NetworkColumns columns = network_columns(network);
  for (std::size_t p = 0; p < network.points.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int c = columns.point[p][i]; c >= 0 && std::ranges::binary_search(unknowns, c)) {
        leave_out(network.points[p], i);
        if (names.empty() || names.back() != network.points[p].id) names.push_back(network.points[p].id);
      }
  return names;
}

/// Unknowns that no observation depends on. Inner constraints would keep those of datum points.
std::vector<int> unobserved(const Network& network) {
  const NetworkColumns columns = network_columns(network);
  const Eigen::VectorXd x = initial_unknowns(network, columns);
  std::vector<bool> observed(static_cast<std::size_t>(columns.size), false);
  for (const SurveyObservation& o : network.observations)
    for (const auto& [column, value] : survey_row(network, columns, o, x).entries)
      observed[static_cast<std::size_t>(column)] = true;
  std::vector<int> unknowns;
  for (int c = 0; c < columns.size; ++c)
    if (!observed[static_cast<std::size_t>(c)]) unknowns.push_back(c);
  return unknowns;
}

bool can_be_adjusted(const Network& network) {
  return !network.observations.empty() && std::ranges::any_of(network.points, is_adjusted);
}

}  // namespace

Result<SolvedNetwork> solve_network(Network network, const SolveNetworkOptions& options) {
  SolvedNetwork solved;
  solved.unusable = remove_unusable(network, false);
  if (const auto checked = check_network(network); !checked) return fail(checked.error());
  LocatedNetwork located = locate_points(std::move(network));
  solved.network = std::move(located.network);
  solved.computed = std::move(located.computed);
  solved.unlocated = leave_out_unlocated(solved.network);
  solved.unusable += remove_unusable(solved.network, true);
  if (std::isfinite(options.outlier_limit_m))
    solved.outlying = remove_outlying(solved.network, options.outlier_limit_m);
  while (can_be_adjusted(solved.network)) {
    if (const auto checked = check_network(solved.network); !checked) return fail(checked.error());
    std::vector<int> open = unobserved(solved.network);
    if (open.empty()) {
      solved.solution = adjust_network(solved.network, options.adjustment);
      if (solved.solution.status != NetworkStatus::kUndetermined) return solved;
      open = solved.solution.undetermined;
    }
    std::vector<std::string> names = leave_out_undetermined(solved.network, open);
    if (names.empty()) break;
    std::ranges::move(names, std::back_inserter(solved.undetermined));
    solved.unusable += remove_unusable(solved.network, true);
  }
  solved.solution.status = NetworkStatus::kUndetermined;
  return solved;
}

}  // namespace octant::calib
