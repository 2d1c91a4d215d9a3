// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/sums/reduced_system.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

namespace octant::calib {
namespace {

/// Above this number, parts are joined even if that needs more memory, because a new part is compared with
/// all of them.
constexpr std::size_t kMostParts = 256;

std::vector<int> joined_columns(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> all;
  all.reserve(a.size() + b.size());
  std::ranges::set_union(a, b, std::back_inserter(all));
  return all;
}

/// @param columns  among those of `to`
void add_within(const std::vector<int>& columns, const ReducedSystem& system, SystemPart& to) {
  to.system.cost += system.cost;
  if (columns.size() == to.columns.size()) {
    to.system.gradient += system.gradient;
    to.system.H += system.H;
    return;
  }
  std::vector<int> places;
  places.reserve(columns.size());
  auto at = to.columns.begin();
  for (const int column : columns) {
    at = std::lower_bound(at, to.columns.end(), column);
    places.push_back(static_cast<int>(at - to.columns.begin()));
  }
  to.system.gradient(places) += system.gradient;
  to.system.H(places, places) += system.H;
}

double squared(std::size_t columns) { return static_cast<double>(columns) * static_cast<double>(columns); }

}  // namespace

std::vector<int> all_columns(int parameters) {
  std::vector<int> all(static_cast<std::size_t>(parameters));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

SystemPart empty_part(std::vector<int> columns) {
  const auto n = static_cast<Eigen::Index>(columns.size());
  return {std::move(columns), {0.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)}};
}

void SystemParts::add(const SystemPart& part) {
  SystemPart* best = nullptr;
  double least_growth = std::numeric_limits<double>::infinity();
  std::vector<int> of_best;
  for (SystemPart& to : parts_) {
    std::vector<int> columns = joined_columns(to.columns, part.columns);
    const double growth = squared(columns.size()) - squared(to.columns.size());
    if (growth >= least_growth) continue;
    least_growth = growth;
    best = &to;
    of_best = std::move(columns);
    if (growth == 0) break;
  }
  if (best == nullptr || (least_growth > squared(part.columns.size()) && parts_.size() < kMostParts)) {
    parts_.push_back(part);
    return;
  }
  if (of_best.size() > best->columns.size()) {
    SystemPart wider = empty_part(std::move(of_best));
    add_within(best->columns, best->system, wider);
    *best = std::move(wider);
  }
  add_within(part.columns, part.system, *best);
}

void SystemParts::add(const SystemParts& other) {
  for (const SystemPart& part : other.parts_) add(part);
}

void SystemParts::scale(double factor) {
  for (SystemPart& part : parts_) {
    part.system.cost *= factor;
    part.system.gradient *= factor;
    part.system.H *= factor;
  }
}

double SystemParts::cost() const {
  double cost = 0.0;
  for (const SystemPart& part : parts_) cost += part.system.cost;
  return cost;
}

ReducedSystem& SystemParts::whole_part(int parameters) {
  if (parts_.empty()) parts_.push_back(empty_part(all_columns(parameters)));
  return parts_.front().system;
}

ReducedSystem SystemParts::whole(int parameters) const {
  SystemPart whole = empty_part(all_columns(parameters));
  for (const SystemPart& part : parts_) add_within(part.columns, part.system, whole);
  return std::move(whole.system);
}

}  // namespace octant::calib
