// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/common/localizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "models/support/largest.h"

namespace octant {
namespace {

bool is_known(const Arrival& a, std::size_t beacons, std::size_t receivers) {
  return a.beacon.valid() && a.beacon.index() < beacons && a.receiver.valid() &&
         a.receiver.index() < receivers;
}

/// NaN is accepted here: drivers write it when there was no signal, and every method ignores it.
bool is_possible(const Arrival& a) { return !(std::abs(a.tof_s) > kLargestTof_s); }
bool is_possible(const Bearing&) { return true; }

/// An unlabelled bearing counts as known; its reflector is identified later.
bool is_known(const Bearing& b, std::size_t beacons) {
  return !b.reflector.valid() || b.reflector.index() < beacons;
}

}  // namespace

bool Localizer::knows(const Arrival& arrival) const noexcept {
  return is_known(arrival, beacons_, receivers_);
}

bool Localizer::knows(const Bearing& bearing) const noexcept { return is_known(bearing, beacons_); }

void Localizer::locate(const Observations& observations, Fix& fix) noexcept {
  const auto known = [this](const auto& row) { return knows(row) && is_possible(row); };
  const bool all_arrivals = std::ranges::all_of(observations.arrivals, known);
  const bool all_bearings = std::ranges::all_of(observations.bearings, known);
  if (all_arrivals && all_bearings) return locate_known(observations, fix);

  const auto keep = [&known](const auto& rows, auto& kept) {
    kept.clear();
    std::ranges::copy_if(rows, std::back_inserter(kept), known);
  };
  keep(observations.arrivals, known_arrivals_);
  keep(observations.bearings, known_bearings_);
  locate_known(Observations{known_arrivals_, known_bearings_}, fix);

  // Expands the rejections to one entry for each original row. Goes backwards, so that no entry is
  // overwritten before it has moved.
  const auto spread = [&](const auto& rows, std::size_t kept) {
    if (fix.rejections.size() == kept && (kept > 0 || fix.ok())) {
      fix.rejections.resize(rows.size());
      for (std::size_t i = rows.size(); i-- > 0;)
        fix.rejections[i] = known(rows[i])   ? fix.rejections[--kept]
                            : knows(rows[i]) ? Rejection::kOutOfRange
                                             : Rejection::kUnknownId;
    }
  };
  if (rejections_of_ == RejectionsOf::kArrivals) {
    fix.arrivals_rejected += static_cast<int>(observations.arrivals.size() - known_arrivals_.size());
    spread(observations.arrivals, known_arrivals_.size());
  } else {
    fix.arrivals_rejected += static_cast<int>(observations.bearings.size() - known_bearings_.size());
    spread(observations.bearings, known_bearings_.size());
  }
}

std::size_t usable_beacons(const Deployment& deployment) {
  return static_cast<std::size_t>(std::ranges::count_if(
      deployment.beacons, [](const DeploymentBeacon& b) { return b.status != BeaconStatus::kUndetermined; }));
}

tl::unexpected<Error> MisfitOf::operator()(const std::string& found, std::string expected) const {
  return fail({.code = Errc::kUsage,
               .found = std::string(method_).append(": ").append(found),
               .expected = std::move(expected)});
}

Result<void> MisfitOf::in_the_plane(const Deployment& deployment) const {
  if (deployment.motion != Motion::kPlanar) return (*this)("the motion is spatial", "a planar one");
  if (deployment.timing.clock != Clock::kSynchronised)
    return (*this)("the clock has a cycle offset", "a synchronised one");
  return {};
}

const MeasurementLog& known_rows(const MeasurementLog& log, const Deployment& deployment,
                                 MeasurementLog& room) {
  const auto strange_arrival = [&](const Arrival& a) {
    return !is_known(a, deployment.beacons.size(), deployment.receivers.size()) || !is_possible(a) ||
           !std::isfinite(a.time_s);
  };
  const auto strange_bearing = [&](const Bearing& b) { return !is_known(b, deployment.beacons.size()); };
  if (std::ranges::none_of(log.arrivals, strange_arrival) &&
      std::ranges::none_of(log.bearings, strange_bearing))
    return log;
  room = log;
  std::erase_if(room.arrivals, strange_arrival);
  std::erase_if(room.bearings, strange_bearing);
  return room;
}

}  // namespace octant
