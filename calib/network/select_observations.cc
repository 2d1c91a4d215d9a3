// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/network/select_observations.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <set>
#include <utility>

#include "calib/network/survey_row.h"

namespace octant::calib {
namespace {

/// Coordinates of the points that an observation depends on.
std::array<bool, 3> needed_axes(SurveyKind kind) {
  switch (kind) {
    case SurveyKind::kHeightDifference:
    case SurveyKind::kZ:
    case SurveyKind::kDz: return {false, false, true};
    case SurveyKind::kZenithAngle:
    case SurveyKind::kSlopeDistance: return {true, true, true};
    case SurveyKind::kX:
    case SurveyKind::kDx: return {true, false, false};
    case SurveyKind::kY:
    case SurveyKind::kDy: return {false, true, false};
    default: return {true, true, false};
  }
}

bool is_usable(const Network& network, const SurveyObservation& o, bool need_coordinates) {
  const std::array<bool, 3> needed = needed_axes(o.kind);
  for (const int p : {o.from, o.to, o.second}) {
    if (p < 0) continue;
    const NetworkPoint& point = network.points[static_cast<std::size_t>(p)];
    for (std::size_t i = 0; i < 3; ++i) {
      if (!needed[i]) continue;
      const bool has_role = point.role[i] != CoordinateRole::kAbsent;
      if (need_coordinates && !point.known[i]) return false;
      if (!has_role && !(o.kind == SurveyKind::kZenithAngle && i < 2 && point.known[i])) return false;
    }
  }
  return true;
}

/// Sets of directions with fewer than two targets, whose orientation absorbs their directions.
void exclude_single_targets(const Network& network, std::vector<bool>& keep) {
  std::map<int, std::set<int>> targets;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (const SurveyObservation& o = network.observations[i]; keep[i] && o.kind == SurveyKind::kDirection)
      targets[o.set].insert(o.to);
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (const SurveyObservation& o = network.observations[i]; o.kind == SurveyKind::kDirection)
      keep[i] = keep[i] && targets[o.set].size() > 1;
}

/// Renumbers the unknowns that members of the observations refer to, without those that no one refers to.
void renumber(std::vector<SurveyObservation>& observations,
              std::initializer_list<int SurveyObservation::*> members, int& count) {
  std::map<int, int> renumbered;
  for (const SurveyObservation& o : observations)
    for (const auto member : members)
      if (o.*member >= 0) renumbered.emplace(o.*member, 0);
  count = 0;
  for (auto& [old, number] : renumbered) number = count++;
  for (SurveyObservation& o : observations)
    for (const auto member : members)
      if (o.*member >= 0) o.*member = renumbered.at(o.*member);
}

}  // namespace

void keep_observations(Network& network, const std::vector<bool>& keep) {
  std::vector<SurveyObservation> kept;
  std::vector<int> index(keep.size(), -1);
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    index[i] = static_cast<int>(kept.size());
    kept.push_back(network.observations[i]);
  }
  renumber(kept, {&SurveyObservation::set}, network.sets);
  renumber(kept, {&SurveyObservation::scale}, network.scales);
  renumber(kept, {&SurveyObservation::constant, &SurveyObservation::target_constant}, network.constants);
  std::vector<ObservationCovariance> blocks;
  for (const ObservationCovariance& block : network.covariances) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < block.covariance.rows(); ++i)
      if (index[static_cast<std::size_t>(block.first + i)] >= 0) rows.push_back(i);
    if (!rows.empty())
      blocks.push_back(
          {index[static_cast<std::size_t>(block.first + rows.front())], block.covariance(rows, rows)});
  }
  network.covariances = std::move(blocks);
  network.observations = std::move(kept);
}

std::size_t remove_unusable(Network& network, bool need_coordinates) {
  std::vector<bool> keep;
  for (const SurveyObservation& o : network.observations)
    keep.push_back(is_usable(network, o, need_coordinates));
  exclude_single_targets(network, keep);
  const auto removed = static_cast<std::size_t>(std::ranges::count(keep, false));
  if (removed > 0) keep_observations(network, keep);
  return removed;
}

std::vector<SurveyObservation> remove_outlying(Network& network, double limit_m) {
  const NetworkColumns columns = network_columns(network);
  const Eigen::VectorXd x = initial_unknowns(network, columns);
  std::vector<bool> keep;
  std::vector<SurveyObservation> removed;
  for (const SurveyObservation& o : network.observations) {
    double lever_m = 1.0;
    if (o.kind <= SurveyKind::kZenithAngle) {
      const Eigen::Vector3d sight = network.points[static_cast<std::size_t>(o.to)].p_map_m -
                                    network.points[static_cast<std::size_t>(o.from)].p_map_m;
      lever_m = o.kind == SurveyKind::kZenithAngle ? sight.norm() : sight.head<2>().norm();
    }
    const double misclosure_m = lever_m * survey_row(network, columns, o, x).misclosure;
    keep.push_back(!(std::abs(misclosure_m) > limit_m));
    if (!keep.back()) removed.push_back(o);
  }
  if (!removed.empty()) {
    exclude_single_targets(network, keep);
    keep_observations(network, keep);
  }
  return removed;
}

}  // namespace octant::calib
