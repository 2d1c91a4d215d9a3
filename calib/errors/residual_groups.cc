// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/residual_groups.h"

#include <algorithm>
#include <cmath>

namespace octant::calib {
namespace {

constexpr std::size_t kFewest = 20;

/// Accumulates sums, which finish() converts to means.
void add(ResidualGroup& group, const GroupedResidual& r) {
  const double m = r.residual_s * r.speed_mps;
  ++group.count;
  group.mean_s += r.residual_s;
  group.mean_m += m;
  group.rms_s += r.residual_s * r.residual_s;
  group.rms_m += m * m;
}

void finish(ResidualGroup& group) {
  if (group.count == 0) return;
  const auto n = static_cast<double>(group.count);
  group.mean_s /= n;
  group.mean_m /= n;
  group.rms_s = std::sqrt(group.rms_s / n);
  group.rms_m = std::sqrt(group.rms_m / n);
}

}  // namespace

std::vector<ResidualGroup> groups_by_name(const std::vector<GroupedResidual>& residuals,
                                          const std::vector<std::string>& names) {
  std::vector<ResidualGroup> groups(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) groups[i].name = names[i];
  for (const GroupedResidual& r : residuals) add(groups[static_cast<std::size_t>(r.key)], r);
  for (ResidualGroup& g : groups) finish(g);
  return groups;
}

std::vector<ResidualGroup> groups_by_quantity(std::vector<GroupedResidual> residuals, std::size_t bins) {
  std::vector<ResidualGroup> groups;
  if (residuals.empty()) return groups;
  std::ranges::stable_sort(residuals, {}, &GroupedResidual::key);
  bins = std::clamp<std::size_t>(residuals.size() / kFewest, 1, bins);
  for (std::size_t first = 0, bin = 1; first < residuals.size(); ++bin) {
    const std::size_t rest = residuals.size() - first, bins_left = bins - std::min(bin, bins) + 1;
    std::size_t last = first + (rest < 2 * kFewest ? rest : std::max(rest / bins_left, kFewest));
    while (last < residuals.size() && residuals[last].key == residuals[last - 1].key) ++last;
    ResidualGroup group;
    group.from = residuals[first].key;
    group.to = residuals[last - 1].key;
    for (std::size_t i = first; i < last; ++i) add(group, residuals[i]);
    finish(group);
    groups.push_back(std::move(group));
    first = last;
  }
  return groups;
}

}  // namespace octant::calib
