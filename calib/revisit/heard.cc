// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/heard.h"

#include <algorithm>
#include <utility>

#include "calib/problem/log_totals.h"
#include "calib/problem/ranges.h"
#include "calib/problem/trilaterate.h"
#include "calib/revisit/receptions.h"

namespace octant::calib {
namespace {

/// Share of rejected arrivals from which the position of a beacon is in doubt.
constexpr double kManyOut = 0.15;

/// Counts, and median residual in a state, of the arrivals for which `mine` is true.
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

/// Computes these values for each beacon or receiver.
/// @param as_before  restores the earlier values of one of them
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

/// Adds the numbers of received and expected arrivals.
std::vector<Heard> with_receptions(std::vector<Heard> heard, const std::vector<Reception>& receptions) {
  for (std::size_t i = 0; i < heard.size(); ++i) {
    heard[i].reception = receptions[i];
    heard[i].reception.silence.subject = heard[i].name;
  }
  return heard;
}

}  // namespace

std::vector<Silence> silent_of(const std::vector<Heard>& beacons, const std::vector<Heard>& receivers) {
  std::vector<Silence> silent;
  for (const std::vector<Heard>* list : {&beacons, &receivers})
    for (const Heard& h : *list)
      if (h.reception.is_silent) silent.push_back(h.reception.silence);
  return silent;
}

std::vector<std::string> not_observed_of(const Deployment& before, const std::vector<Heard>& beacons) {
  std::vector<std::string> names;
  for (std::size_t b = 0; b < beacons.size(); ++b)
    if (beacons[b].reception.received == 0 && !beacons[b].reception.is_silent &&
        before.beacons[b].status != BeaconStatus::kUndetermined)
      names.push_back(beacons[b].name);
  return names;
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
  return with_receptions(
      heard_of_each(
          before.beacons.size(), trajectories, now, [&](std::size_t b) { return before.beacons[b].name; },
          [&](std::size_t b, SharedState& state) {
            if (before.beacons[b].status != BeaconStatus::kUndetermined) set_beacon(state, b, then);
          },
          [](const ArrivalObservation& a) { return a.beacon.index(); }),
      receptions_of_beacons(before, trajectories));
}

std::vector<Heard> heard_by_receivers(const Deployment& before, const std::vector<Trajectory>& trajectories,
                                      const SharedState& now) {
  const SharedState then = shared_state(before);
  return with_receptions(heard_of_each(
                             before.receivers.size(), trajectories, now,
                             [&](std::size_t r) { return receiver_path(r, names_of(before)); },
                             [&](std::size_t r, SharedState& state) {
                               state.receiver_p_vehicle_m[r] = then.receiver_p_vehicle_m[r];
                               state.receiver_delay_s[r] = then.receiver_delay_s[r];
                             },
                             [](const ArrivalObservation& a) { return a.receiver.index(); }),
                         receptions_by_receivers(before, trajectories));
}

}  // namespace octant::calib
