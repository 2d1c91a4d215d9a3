// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/heard.h"

#include <algorithm>
#include <utility>

#include "calib/problem/log_totals.h"
#include "calib/problem/ranges.h"
#include "calib/problem/trilaterate.h"
#include "calib/verdict/hearing_pairs.h"

namespace octant::calib {
namespace {

/// Share of a beacon's arrivals left out, of those in use, from which its place is doubted.
constexpr double kManyOut = 0.15;

/// Counts, and the median of the residuals in a state, of those arrivals that are `mine`.
template <class Mine>
Heard heard_of(std::string name, const std::vector<Trajectory>& trajectories, const SharedState& state,
               Mine&& mine) {
  Heard h;
  h.name = std::move(name);
  std::vector<double> misfits;
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals) {
      if (!mine(a) || !t.nodes[a.node].placed) continue;
      const bool late = a.rejection == Rejection::kLate, early = a.rejection == Rejection::kEarly,
                 used = a.rejection == Rejection::kUsed;
      h.used += used;
      h.late += late;
      h.early += early;
      if (used || late || early) misfits.push_back(arrival_residual(t, a, state) * a.sigma_s);
    }
  h.misfit_s = median(std::move(misfits));
  return h;
}

/// Of each of so many beacons or receivers. @param as_before  puts one back to where it was
/// @param owner  beacon or receiver of an arrival
template <class Name, class AsBefore, class Owner>
std::vector<Heard> heard_of_each(std::size_t count, const std::vector<Trajectory>& trajectories,
                                 const SharedState& now, Name&& name, AsBefore&& as_before, Owner&& owner) {
  std::vector<Heard> all;
  for (std::size_t i = 0; i < count; ++i) {
    SharedState state = now;
    as_before(i, state);
    all.push_back(
        heard_of(name(i), trajectories, state, [&](const ArrivalObservation& a) { return owner(a) == i; }));
  }
  return all;
}

/// Arrivals of each beacon or by each receiver, whatever became of them.
template <class Owner>
std::vector<std::size_t> arrivals_of_each(std::size_t count, const std::vector<Trajectory>& trajectories,
                                          Owner&& owner) {
  std::vector<std::size_t> n(count, 0);
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals) ++n[owner(a)];
  return n;
}

/// Distances from beacons to the places where something was heard, with whether each was heard there.
struct HearingPair {
  std::size_t beacon = 0;
  double distance_m = 0.0;
  bool heard = false;
};
std::vector<HearingPair> hearing_pairs(const Deployment& before,
                                       const std::vector<Trajectory>& trajectories) {
  std::vector<HearingPair> pairs;
  for (const Trajectory& t : trajectories)
    for_each_hearing_pair(
        t, before.beacons, 1, [](const ArrivalObservation&) { return true; },
        [&](std::size_t b, double distance_m, bool heard) {
          pairs.push_back({b, distance_m, heard});
        });
  return pairs;
}

}  // namespace

std::vector<std::string> silent_beacons(const Deployment& before,
                                        const std::vector<Trajectory>& trajectories) {
  // Beyond the reach nothing is missed; a beacon behind obstacles is no beacon that is off, so that the
  // others have to be heard from most places.
  constexpr double kMostDistances = 0.95, kMostHeard = 0.5, kMissed = 5.0;
  const std::vector<std::size_t> arrivals = arrivals_of_each(
      before.beacons.size(), trajectories, [](const ArrivalObservation& a) { return a.beacon.index(); });
  if (std::ranges::find(arrivals, 0U) == arrivals.end()) return {};
  const std::vector<HearingPair> pairs = hearing_pairs(before, trajectories);
  std::vector<double> heard_m;
  for (const HearingPair& p : pairs)
    if (p.heard) heard_m.push_back(p.distance_m);
  if (heard_m.empty()) return {};
  double reach_m = nth_smallest(
      heard_m, static_cast<std::size_t>(kMostDistances * static_cast<double>(heard_m.size() - 1)));
  if (before.validity_reach_m) reach_m = std::min(reach_m, *before.validity_reach_m);
  double near = 0.0, near_heard = 0.0;
  std::vector<double> expected(arrivals.size(), 0.0);
  for (const HearingPair& p : pairs) {
    if (p.distance_m > reach_m) continue;
    expected[p.beacon] += 1.0;
    if (arrivals[p.beacon] == 0) continue;
    near += 1.0;
    near_heard += p.heard ? 1.0 : 0.0;
  }
  std::vector<std::string> silent;
  for (std::size_t b = 0; b < arrivals.size(); ++b)
    if (arrivals[b] == 0 && near_heard > kMostHeard * near && expected[b] * near_heard > kMissed * near)
      silent.push_back(before.beacons[b].name);
  return silent;
}

std::vector<std::string> silent_receivers(const Deployment& before,
                                          const std::vector<Trajectory>& trajectories) {
  constexpr std::size_t kEnough = 20;  ///< arrivals by each of the others
  const std::vector<std::size_t> arrivals = arrivals_of_each(
      before.receivers.size(), trajectories, [](const ArrivalObservation& a) { return a.receiver.index(); });
  std::vector<std::string> silent;
  for (std::size_t r = 0; r < arrivals.size(); ++r) {
    std::size_t others = 0, taken = 0;
    for (std::size_t o = 0; o < arrivals.size(); ++o)
      if (before.receivers[o].vehicle == before.receivers[r].vehicle && arrivals[o] > 0) {
        ++others;
        taken += arrivals[o];
      }
    if (arrivals[r] == 0 && others > 0 && taken >= kEnough * others)
      silent.push_back(receiver_path(r, names_of(before)));
  }
  return silent;
}

std::vector<std::size_t> doubtful_beacons(const Deployment& before,
                                          const std::vector<Trajectory>& trajectories) {
  const std::vector<RejectionCounts> counts = rejections_by_beacon(trajectories, before.beacons.size());
  const auto share = [&](std::size_t b) {
    return static_cast<double>(counts[b].outliers()) /
           static_cast<double>(std::max<std::size_t>(counts[b].of(Rejection::kUsed), 1));
  };
  std::vector<std::size_t> doubtful;
  for (std::size_t b = 0; b < counts.size(); ++b)
    if (before.beacons[b].status != BeaconStatus::kUndetermined && counts[b].outliers() > 0 &&
        share(b) >= kManyOut)
      doubtful.push_back(b);
  std::ranges::stable_sort(doubtful, [&](std::size_t a, std::size_t b) { return share(a) > share(b); });
  return doubtful;
}

bool turn_to_known_side(const Deployment& before, const ParameterLayout& layout, Eigen::VectorXd& x) {
  if (before.motion != Motion::kPlanar || before.receivers.empty()) return false;
  bool any = false;
  for (std::size_t b = 0; b < before.beacons.size(); ++b) {
    const int c = layout.beacon[b][2];
    if (c < 0) continue;
    const double found_m = x[c];
    x[c] = height_on_known_side_m(before.receivers, before.beacons[b].position_m.z(), found_m);
    any = any || x[c] != found_m;
  }
  return any;
}

std::vector<Heard> heard_of_beacons(const Deployment& before, const std::vector<Trajectory>& trajectories,
                                    const SharedState& now) {
  const SharedState then = shared_state(before);
  return heard_of_each(
      before.beacons.size(), trajectories, now, [&](std::size_t b) { return before.beacons[b].name; },
      [&](std::size_t b, SharedState& state) {
        if (before.beacons[b].status != BeaconStatus::kUndetermined) set_beacon(state, b, then);
      },
      [](const ArrivalObservation& a) { return a.beacon.index(); });
}

std::vector<Heard> heard_by_receivers(const Deployment& before, const std::vector<Trajectory>& trajectories,
                                      const SharedState& now) {
  const SharedState then = shared_state(before);
  return heard_of_each(
      before.receivers.size(), trajectories, now,
      [&](std::size_t r) { return receiver_path(r, names_of(before)); },
      [&](std::size_t r, SharedState& state) {
        state.receiver_p_vehicle_m[r] = then.receiver_p_vehicle_m[r];
        state.receiver_delay_s[r] = then.receiver_delay_s[r];
      },
      [](const ArrivalObservation& a) { return a.receiver.index(); });
}

}  // namespace octant::calib
