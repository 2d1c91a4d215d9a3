// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/map/losses.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "survey/geometry/layer_sigma.h"

namespace octant::survey {
namespace {

bool matters_more(const Loss& a, const Loss& b) {
  if (a.poses_out != b.poses_out) return a.poses_out > b.poses_out;
  if (a.poses_without_fix != b.poses_without_fix) return a.poses_without_fix > b.poses_without_fix;
  return a.spread_ppm > b.spread_ppm;
}

void merge_into(std::vector<Loss>& all, const std::vector<Loss>& more) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].poses_out += more[i].poses_out;
    all[i].poses_without_fix += more[i].poses_without_fix;
    all[i].worst_sigma_m = std::max(all[i].worst_sigma_m, more[i].worst_sigma_m);
    all[i].spread_ppm += more[i].spread_ppm;
  }
}

}  // namespace

LossAccount::LossAccount(const KernelModel& kernel, int at_once)
    : beacons_(kernel.beacons.size()), at_once_(at_once) {
  if (at_once < 1) return;
  const auto entries = static_cast<std::size_t>(kernel.unknowns.entries());
  layers_.resize(beacons_ * entries * kTilePoses);
  heard_.resize(beacons_ * kTilePoses);
  total_.resize(entries * kTilePoses);
  for (std::size_t a = 0; a < beacons_; ++a) {
    Loss one;
    one.first = a;
    singles_.push_back(one);
  }
  if (at_once > 1)
    for (std::size_t a = 0; a < beacons_; ++a)
      for (std::size_t b = a + 1; b < beacons_; ++b) {
        Loss two;
        two.first = a, two.second = b;
        pairs_.push_back(two);
      }
}

void LossAccount::count(const double* before, const double* after, const Cells& cells, std::size_t size,
                        Loss& loss) const {
  const double limit2 = cells.tolerance_m * cells.tolerance_m;
  for (std::size_t i = 0; i < size; ++i) {
    if (std::isinf(before[i]) || after[i] == before[i]) continue;
    const bool fix = !std::isinf(after[i]);
    const double other = cells.other_m2[i];
    if (!fix)
      ++loss.poses_without_fix;
    else
      loss.worst_sigma_m = std::max(loss.worst_sigma_m, after[i]);
    if (before[i] * before[i] + other <= limit2 && !(fix && after[i] * after[i] + other <= limit2))
      ++loss.poses_out;
    loss.spread_ppm += fix ? std::llround(1e6 * std::clamp(after[i] / before[i] - 1, 0.0, 10.0)) : 10'000'000;
  }
}

void LossAccount::add(const KernelModel& kernel, const KernelTile& tile, const Cells& cells) {
  if (at_once_ < 1) return;
  const int unknowns = kernel.unknowns.count();
  const std::size_t entries = static_cast<std::size_t>(kernel.unknowns.entries()),
                    size = entries * kTilePoses;
  alignas(64) double before[kTilePoses], after[kTilePoses];
  std::ranges::fill(total_, 0.0);
  std::vector<std::size_t> here;
  for (std::size_t b = 0; b < beacons_; ++b) {
    if (tile.skip[b]) continue;
    double* heard = heard_.data() + b * kTilePoses;
    layer_tile(kernel, tile, b, layers_.data() + b * size, heard);
    if (std::none_of(heard, heard + tile.count, [](double h) { return h > 0; })) continue;
    add_to(layers_.data() + b * size, size, total_.data());
    here.push_back(b);
  }
  sigma_of_packed(unknowns, total_.data(), nullptr, nullptr, kTilePoses, tile.count, before);
  std::copy(before, before + tile.count, cells.one_m.begin());
  std::copy(before, before + tile.count, cells.two_m.begin());
  std::ranges::fill(cells.one_beacon, -1);
  for (std::size_t k = 0; k < here.size(); ++k) {
    const std::size_t a = here[k];
    const double* of_a = layers_.data() + a * size;
    sigma_of_packed(unknowns, total_.data(), of_a, nullptr, kTilePoses, tile.count, after);
    for (std::size_t i = 0; i < tile.count; ++i) {
      if (heard_[a * kTilePoses + i] <= 0) after[i] = before[i];
      if (after[i] > cells.one_m[i])
        cells.one_m[i] = after[i], cells.one_beacon[i] = static_cast<std::int32_t>(a);
    }
    count(before, after, cells, tile.count, singles_[a]);
    for (std::size_t m = k + 1; m < here.size() && at_once_ > 1; ++m) {
      const std::size_t b = here[m];
      sigma_of_packed(unknowns, total_.data(), of_a, layers_.data() + b * size, kTilePoses, tile.count,
                      after);
      for (std::size_t i = 0; i < tile.count; ++i) {
        if (heard_[a * kTilePoses + i] <= 0 && heard_[b * kTilePoses + i] <= 0) after[i] = before[i];
        cells.two_m[i] = std::max(cells.two_m[i], after[i]);
      }
      count(before, after, cells, tile.count, pairs_[pair_index(a, b)]);
    }
    // A second failure may be that of a beacon that is not received here.
    for (std::size_t i = 0; i < tile.count; ++i) cells.two_m[i] = std::max(cells.two_m[i], cells.one_m[i]);
  }
  if (at_once_ < 2) return;
  // If one beacon of a pair is not received here, the failure of the other one alone counts for the pair too.
  for (const std::size_t a : here) {
    sigma_of_packed(unknowns, total_.data(), layers_.data() + a * size, nullptr, kTilePoses, tile.count,
                    after);
    for (std::size_t i = 0; i < tile.count; ++i)
      if (heard_[a * kTilePoses + i] <= 0) after[i] = before[i];
    for (std::size_t b = 0; b < beacons_; ++b)
      if (std::ranges::find(here, b) == here.end())
        count(before, after, cells, tile.count, pairs_[pair_index(std::min(a, b), std::max(a, b))]);
  }
}

void LossAccount::merge(const LossAccount& other) {
  merge_into(singles_, other.singles_);
  merge_into(pairs_, other.pairs_);
}

std::vector<Loss> LossAccount::singles() const {
  std::vector<Loss> sorted = singles_;
  std::ranges::stable_sort(sorted, matters_more);
  return sorted;
}

std::vector<Loss> LossAccount::pairs(std::size_t most) const {
  std::vector<Loss> sorted;
  std::ranges::copy_if(pairs_, std::back_inserter(sorted),
                       [](const Loss& loss) { return loss.spread_ppm > 0; });
  std::ranges::stable_sort(sorted, matters_more);
  sorted.resize(std::min(most, sorted.size()));
  return sorted;
}

}  // namespace octant::survey
