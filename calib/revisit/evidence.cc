// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "models/changes/chi_square.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {
namespace {

/// A stop, or a second of a drive.
using Occasion = std::pair<std::size_t, std::int64_t>;
Occasion occasion_of(const Trajectory& t, std::size_t trajectory, const ArrivalObservation& a) {
  return {trajectory, t.moving ? static_cast<std::int64_t>(std::floor(a.time_s)) : a.node};
}

/// Calls visit(trajectory, arrival, group) for the arrivals that were used or rejected by their residual.
template <class Visit>
void for_each_judged(const std::vector<Trajectory>& trajectories, Visit&& visit) {
  for (std::size_t k = 0; k < trajectories.size(); ++k)
    for (const ArrivalObservation& a : trajectories[k].arrivals)
      if (is_by_residual(a.rejection) && trajectories[k].nodes[a.node].placed)
        visit(trajectories[k], a, occasion_of(trajectories[k], k, a));
}

bool is_of_receiver(const ChangeHypothesis& h) { return h.kind == ChangeKind::kReceiver; }
/// Returns true if the hypothesis concerns a single beacon or receiver.
bool has_owner(const ChangeHypothesis& h) {
  return h.kind != ChangeKind::kSpeed && h.kind != ChangeKind::kDatum && h.owner != kAllBeacons;
}
bool is_owner(const ChangeHypothesis& h, const ArrivalObservation& a) {
  return h.owner == (is_of_receiver(h) ? a.receiver.index() : a.beacon.index());
}

}  // namespace

double truncated_squares(const Fit& fit, double limit, double noise_ratio) {
  const SharedState state = fit.state();
  double squares = 2 * fit.last.cost;
  for_each_judged(fit.trajectories, [&](const Trajectory& t, const ArrivalObservation& a, const Occasion&) {
    const double r2 = std::pow(arrival_residual(t, a, state), 2);
    if (a.rejection == Rejection::kUsed) squares -= r2;
    squares += std::min(r2 * noise_ratio * noise_ratio, limit * limit);
  });
  return squares;
}

double price_of(const ChangeSearch& search) {
  double price = 0.0;
  for (const TestedChange& t : search.tested)
    if (t.held)
      price += chi_square_beyond(kFalseAlarm / static_cast<double>(search.tested.size()),
                                 std::max(1, t.degrees_of_freedom));
  return price;
}

double possible_gain(const Fit& fit, const ChangeHypothesis& hypothesis, double limit) {
  if (!has_owner(hypothesis)) return INFINITY;
  const SharedState state = fit.state();
  double squares = 0.0;
  for_each_judged(fit.trajectories, [&](const Trajectory& t, const ArrivalObservation& a, const Occasion&) {
    if (is_owner(hypothesis, a))
      squares += std::min(std::pow(arrival_residual(t, a, state), 2), limit * limit);
  });
  return squares;
}

bool is_supported(const Fit& fit, const Deployment& before, const ChangeHypothesis& hypothesis,
                  double limit) {
  if (!has_owner(hypothesis) || hypothesis.kind == ChangeKind::kAmplitude) return true;
  const SharedState now = fit.state(), then = shared_state(before);
  SharedState reverted = now;
  if (is_of_receiver(hypothesis)) {
    reverted.receiver_p_vehicle_m[hypothesis.owner] = then.receiver_p_vehicle_m[hypothesis.owner];
  } else {
    set_beacon(reverted, hypothesis.owner, then);
  }
  std::map<Occasion, double> gain;
  for_each_judged(fit.trajectories, [&](const Trajectory& t, const ArrivalObservation& a, const Occasion& g) {
    if (!is_owner(hypothesis, a)) return;
    const auto squares = [&](const SharedState& state) {
      return std::min(std::pow(arrival_residual(t, a, state), 2), limit * limit);
    };
    gain[g] += squares(reverted) - squares(now);
  });
  double sum = 0.0, largest = 0.0;
  for (const auto& [group, squares] : gain) {
    sum += squares;
    largest = std::max(largest, squares);
  }
  constexpr double kOfOneArrival = 0.5;  // share of what an arrival at another stop can explain at most
  return sum - largest > kOfOneArrival * limit * limit;
}

std::vector<std::string> received_once(const Fit& fit, const Deployment& before) {
  std::vector<std::set<Occasion>> groups(before.beacons.size());
  for_each_judged(fit.trajectories, [&](const Trajectory&, const ArrivalObservation& a, const Occasion& g) {
    groups[a.beacon.index()].insert(g);
  });
  std::vector<std::string> names;
  for (std::size_t b = 0; b < groups.size(); ++b)
    if (groups[b].size() == 1) names.push_back(before.beacons[b].name);
  return names;
}

}  // namespace octant::calib
