// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/suspicions.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calib/problem/clock_check.h"
#include "calib/problem/ranges.h"
#include "models/support/normal_noise.h"

namespace octant::calib {
namespace {

constexpr std::size_t kArrivalsNeeded = 20;
/// A receiver is suspected if its residuals exceed the noise kOffSigmas times. Another position explains them
/// if the residuals decrease to the share kBetter.
constexpr double kOffSigmas = 4.0, kBetter = 0.3;

/// Median size of the residuals, in sigmas, of the ranges of receiver r at the position of receiver s.
double misfit(const Adjusted& f, const SharedState& state, ReceiverId r, ReceiverId s, std::size_t& count) {
  std::vector<double> sizes;
  for (const Trajectory& t : f.trajectories)
    for (ArrivalObservation a : t.arrivals) {
      if (a.receiver != r || a.rejection == Rejection::kBeaconUnusable || !t.nodes[a.node].placed) continue;
      if (a.alpha > 0 && !t.nodes[a.node + 1].placed) continue;
      a.receiver = s;
      sizes.push_back(std::abs(arrival_residual(t, a, state)));
    }
  count = sizes.size();
  return median(std::move(sizes)) / kMedianOfNormal;
}

/// Returns the state with receivers at the positions of the site file; the adjustment may have displaced an
/// exchanged receiver.
SharedState with_stated_receivers(const Adjusted& f) {
  SharedState state = f.state;
  for (std::size_t r = 0; r < f.site.receivers.size(); ++r)
    state.receiver_p_vehicle_m[r] = f.site.receivers[r].position_m;
  return state;
}

struct SuspectReceiver {
  /// receiver: suspect; fits: receiver whose position its ranges fit; not valid() if no position fits
  ReceiverId receiver, fits;
  double sigmas = 0.0;
};

std::vector<SuspectReceiver> suspects(const Adjusted& f) {
  const Site& site = f.site;
  const SharedState stated = with_stated_receivers(f);
  std::vector<double> own(site.receivers.size(), 0.0), heard;
  std::vector<std::size_t> count(site.receivers.size(), 0);
  for (std::size_t r = 0; r < own.size(); ++r) {
    own[r] = misfit(f, stated, ReceiverId(r), ReceiverId(r), count[r]);
    if (count[r] >= kArrivalsNeeded) heard.push_back(own[r]);
  }
  const double limit = std::max(kOffSigmas, 3 * median(heard));
  std::vector<SuspectReceiver> found;
  for (std::size_t r = 0; r < own.size(); ++r) {
    if (count[r] < kArrivalsNeeded || own[r] < limit) continue;
    SuspectReceiver suspect{ReceiverId(r), {}, own[r]};
    double best = kBetter * own[r];
    for (std::size_t s = 0; s < own.size(); ++s) {
      if (s == r || site.receivers[s].vehicle != site.receivers[r].vehicle) continue;
      const double as_other = misfit(f, stated, ReceiverId(r), ReceiverId(s), count[r]);
      if (as_other >= best) continue;
      best = as_other;
      suspect.fits = ReceiverId(s);
    }
    found.push_back(suspect);
  }
  return found;
}

std::vector<Finding> receiver_labels(const Adjusted& f) {
  const Site& site = f.site;
  const std::vector<SuspectReceiver> found = suspects(f);
  const auto name = [&](ReceiverId r) { return site.receivers[r.index()].name; };
  std::vector<Finding> findings;
  for (const SuspectReceiver& a : found) {
    const std::string& vehicle = site.vehicles[site.receivers[a.receiver.index()].vehicle.index()].name;
    const auto partner = std::ranges::find_if(found, [&](const SuspectReceiver& b) {
      return a.fits.valid() && b.receiver == a.fits && b.fits == a.receiver;
    });
    if (partner != found.end()) {
      if (a.receiver < partner->receiver)
        findings.push_back(
            {"receiver_label", fmt::format("receivers {} and {} of {} are exchanged: the ranges of each fit "
                                           "the place of the other; check the cables and the site file",
                                           name(a.receiver), name(a.fits), vehicle)});
    } else if (a.fits.valid()) {
      findings.push_back({"receiver_label",
                          fmt::format("the ranges of receiver {} of {} fit the place of {}; check its label",
                                      name(a.receiver), vehicle, name(a.fits))});
    } else {
      findings.push_back(
          {"receiver_label", fmt::format("the ranges of receiver {} of {} contradict those of the others "
                                         "(off by {:.3g} sigma on the median); check its place and its label",
                                         name(a.receiver), vehicle, a.sigmas)});
    }
  }
  return findings;
}

}  // namespace

std::vector<Finding> suspicions(const Adjusted& f, std::vector<RunHealth>& runs) {
  std::vector<Finding> findings = receiver_labels(f);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (const ClockStep& s : steps_between_stops(f.trajectories, i, f.state)) {
      runs[i].clock_steps.push_back(s);
      findings.push_back(
          {"clock_step",
           fmt::format("{}: from {:.6g} s on times of flight are {:.4g} ms {}{}: a clock jumped there",
                       runs[i].path, s.time_s, 1e3 * std::abs(s.step_s), s.step_s > 0 ? "longer" : "shorter",
                       f.stride > 1.5 ? fmt::format(" (looking at every {:.0f}th stop)", f.stride) : "")});
    }
  }
  return findings;
}

}  // namespace octant::calib
