// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/schedule/schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "models/localizers/kleeman/kleeman_schedule.h"

namespace octant::survey {
namespace {

constexpr double kRareSigmas = 3.0;  ///< ratio of the sum of echoes: the square of an envelope is
                                     ///< exponential, so it is exceeded for exp(-9) of the time

/// Longest path at whose end an echo is still above the threshold, each wall met taking its part.
double last_single_echo_m(const Reverberance& r) {
  const auto excess = [&](double d, double walls) {
    return r.amplitude_1m_v / d * std::exp(-r.absorption_np_per_m * d) * std::pow(r.wall_reflection, walls) -
           r.threshold_v;
  };
  // Between two multiples of the longest path the number of reflections is constant and the amplitude
  // decreases.
  for (double walls = 0.0;; walls += 1.0) {
    double low = std::max(walls * r.longest_m, 1e-6), high = (walls + 1.0) * r.longest_m;
    if (excess(low, walls) <= 0) return walls * r.longest_m;
    if (excess(high, walls) > 0) continue;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (excess(middle, walls) > 0 ? low : high) = middle;
    }
    return high;
  }
}

/// Eq. 1 with the number of reflections that its own answer makes room for.
double kleeman_s(const Reverberance& r) {
  for (int n = 0;; ++n) {
    const double fire_s = shortest_fire_s({.amplitude_1m_v = r.amplitude_1m_v,
                                           .threshold_v = r.threshold_v,
                                           .absorbed_fraction = 1 - r.wall_reflection,
                                           .reflections = n,
                                           .speed_mps = r.speed_mps});
    if (fire_s * r.speed_mps <= (n + 1) * r.longest_m) return fire_s;
  }
}

Sharing sharing_of(const Audience& audience, const ShareOptions& o, std::size_t a, std::size_t b) {
  double first[2] = {INFINITY, INFINITY}, last[2] = {0.0, 0.0};
  bool both = false;
  const std::size_t of[2] = {a, b};
  for (std::size_t i = 0; i < audience.heard[a].size(); ++i) {
    bool hears[2];
    for (int k = 0; k < 2; ++k) {
      const double d = audience.distance_m[of[k]][i];
      hears[k] = o.trust_walls ? audience.heard[of[k]][i] != 0 : d <= o.reach_m;
      if (!hears[k]) continue;
      first[k] = std::min(first[k], d / o.speed_mps);
      last[k] = std::max(last[k], d / o.speed_mps);
    }
    both = both || (hears[0] && hears[1]);
  }
  if (!both) return Sharing::kNeverBoth;
  const bool apart = last[0] + o.guard_s < first[1] || last[1] + o.guard_s < first[0];
  return o.by_time && apart ? Sharing::kApartInTime : Sharing::kConfused;
}

/// A set of beacons that all interfere with each other, as large as a greedy choice from any first one makes
/// it.
std::size_t greedy_clique(const FiringPlan& plan) {
  std::size_t largest = 0;
  for (std::size_t first = 0; first < plan.beacons; ++first) {
    std::vector<std::size_t> clique = {first};
    for (std::size_t b = 0; b < plan.beacons; ++b)
      if (b != first && std::ranges::all_of(
                            clique, [&](std::size_t c) { return plan.between(b, c) == Sharing::kConfused; }))
        clique.push_back(b);
    largest = std::max(largest, clique.size());
  }
  return largest;
}

/// DSATUR: of the beacons without a group the one next to the most groups, then the one with the most
/// neighbours.
std::vector<std::vector<std::size_t>> colour(const FiringPlan& plan) {
  const std::size_t n = plan.beacons;
  std::vector<std::set<std::size_t>> taken(n);  // groups of a beacon's neighbours
  std::vector<std::size_t> neighbours(n, 0);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) neighbours[a] += a != b && plan.between(a, b) == Sharing::kConfused;
  std::vector<bool> placed(n, false);
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t round = 0; round < n; ++round) {
    std::size_t next = n;
    for (std::size_t b = 0; b < n; ++b) {
      if (placed[b]) continue;
      if (next == n || taken[b].size() > taken[next].size() ||
          (taken[b].size() == taken[next].size() && neighbours[b] > neighbours[next]))
        next = b;
    }
    std::size_t group = 0;
    while (taken[next].contains(group)) ++group;
    if (group == groups.size()) groups.emplace_back();
    groups[group].push_back(next);
    placed[next] = true;
    for (std::size_t b = 0; b < n; ++b)
      if (b != next && plan.between(next, b) == Sharing::kConfused) taken[b].insert(group);
  }
  for (auto& group : groups) std::ranges::sort(group);
  std::ranges::sort(groups);
  return groups;
}

}  // namespace

FallSilent fall_silent(const Reverberance& r) {
  FallSilent silent;
  silent.single_echo_s = last_single_echo_m(r) / r.speed_mps;
  silent.kleeman_s = kleeman_s(r);
  // Nepers of energy lost a second.
  const double decay =
      r.speed_mps * (-2 * std::log(std::max(r.wall_reflection, 1e-9)) * r.surface_m2 / (4 * r.volume_m3) +
                     2 * r.absorption_np_per_m);
  silent.t60_s = 6 * std::log(10.0) / decay;
  const double energy_at_0 =
      r.amplitude_1m_v * r.amplitude_1m_v * 4 * M_PI * r.speed_mps * r.pulse_s / r.volume_m3;
  silent.all_echoes_s = std::max(
      0.0, std::log(kRareSigmas * kRareSigmas * energy_at_0 / (r.threshold_v * r.threshold_v)) / decay);
  silent.slot_s = std::max(silent.single_echo_s, silent.all_echoes_s) + r.pulse_s;
  return silent;
}

FiringPlan share_slots(const Audience& audience, const ShareOptions& options, double slot_s) {
  FiringPlan plan;
  plan.beacons = audience.heard.size();
  plan.slot_s = slot_s;
  plan.sharing.assign(plan.beacons * plan.beacons, Sharing::kConfused);
  for (std::size_t a = 0; a < plan.beacons; ++a)
    for (std::size_t b = 0; b < a; ++b)
      plan.sharing[a * plan.beacons + b] = plan.sharing[b * plan.beacons + a] =
          sharing_of(audience, options, a, b);
  plan.least_groups = greedy_clique(plan);
  plan.groups = colour(plan);
  return plan;
}

}  // namespace octant::survey
