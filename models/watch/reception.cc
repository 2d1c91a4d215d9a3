// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/watch/reception.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace octant {
namespace {

constexpr double kCell_m = 2.0;
/// Least probability of a miss, for example behind a person; and at places where the beacon was never
/// received, for example behind a wall.
constexpr double kLeastMiss = 0.05, kLeastMissElsewhere = 0.2;
/// Number of places at a distance, or farther away, from which their misses count.
constexpr double kEnoughPlaces = 10.0;

constexpr int kMostPlaces = 200;

std::size_t distance_class(double distance_m, std::size_t classes) {
  const double at = 8.0 * std::log2(std::max(distance_m, 0.5) / 0.5);  // steps of 9 %
  return std::min(static_cast<std::size_t>(at), classes - 1);
}

}  // namespace

ReceptionWatch::ReceptionWatch(std::vector<Eigen::Vector3d> beacons_map_m, double threshold)
    : threshold_(threshold), cells_(kCells, 0), history_(kCells * beacons_map_m.size()) {
  for (const Eigen::Vector3d& p : beacons_map_m) beacons_.push_back({.p_map_m = p});
}

void ReceptionWatch::restart() {
  for (Beacon& b : beacons_) b = Beacon{.p_map_m = b.p_map_m};
  by_distance_.fill({});
  std::ranges::fill(cells_, 0);
  std::ranges::fill(history_, History{});
  begun_ = false;
}

/// Index of a place's cell; kCells if the table is full.
std::size_t ReceptionWatch::cell_of(const Eigen::Vector3d& p) {
  const auto i = static_cast<std::int64_t>(std::floor(p.x() / kCell_m)),
             j = static_cast<std::int64_t>(std::floor(p.y() / kCell_m));
  const std::int64_t key = ((i & 0x3fffffff) << 31) + (j & 0x3fffffff) + 1;
  std::size_t at = (static_cast<std::uint64_t>(key) * 0x9e3779b97f4a7c15u >> 32) % kCells;
  for (std::size_t tries = 0; tries < 64; ++tries, at = (at + 1) % kCells) {
    if (cells_[at] == 0) cells_[at] = key;
    if (cells_[at] == key) return at;
  }
  return kCells;
}

/// Counts the misses since the last reception, because the beacon was not silent.
void ReceptionWatch::close_misses(std::size_t beacon) {
  for (std::size_t d = 0; d < kDistances; ++d) {
    by_distance_[d].places += beacons_[beacon].missed[d];
    by_distance_[d].missed += beacons_[beacon].missed[d];
  }
  beacons_[beacon].missed.fill(0.0F);
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    History& history = history_[cell * beacons_.size() + beacon];
    const int more = std::min<int>(history.open, kMostPlaces - history.places);
    history.places = static_cast<std::uint8_t>(history.places + more);
    history.missed = static_cast<std::uint8_t>(history.missed + more);
    history.open = 0;
  }
}

std::optional<BeaconId> ReceptionWatch::leave_place(const Eigen::Vector3d& p_map_m, double time_s) {
  const std::size_t cell = cell_of(p_map_m);
  std::optional<BeaconId> silent;
  for (std::size_t b = 0; b < beacons_.size(); ++b) {
    Beacon& beacon = beacons_[b];
    const std::size_t distance = distance_class((p_map_m - beacon.p_map_m).norm(), kDistances);
    History none;
    History& here = cell < kCells ? history_[cell * beacons_.size() + b] : none;
    if (!begun_) beacon.since_s = time_s;
    if (std::exchange(beacon.received, false)) {
      if (beacon.evidence > 0.0) close_misses(b);
      by_distance_[distance].places += 1.0;
      if (here.places < kMostPlaces) ++here.places;
      beacon.evidence = 0.0;
      beacon.silent = false;
      beacon.since_s = time_s;
      continue;
    }
    beacon.missed[distance] += 1.0F;
    if (here.open < kMostPlaces) ++here.open;
    beacon.evidence -= std::log(miss_probability(distance, here));
    if (beacon.evidence < threshold_ || beacon.silent || silent) continue;
    beacon.silent = true;
    silent = BeaconId(b);
  }
  begun_ = true;
  return silent;
}

double ReceptionWatch::miss_probability(std::size_t distance, const History& here) const {
  // Beacons that are farther away are missed at least as often, so their places bound the probability.
  Count alike;
  for (std::size_t d = distance; d < kDistances && alike.places < kEnoughPlaces; ++d) {
    alike.places += by_distance_[d].places;
    alike.missed += by_distance_[d].missed;
  }
  const double elsewhere = alike.places < kEnoughPlaces
                               ? 1.0
                               : std::max(kLeastMissElsewhere, (alike.missed + 1.0) / (alike.places + 2.0));
  return std::max(kLeastMiss, (here.missed + elsewhere) / (here.places + 1.0));
}

}  // namespace octant
