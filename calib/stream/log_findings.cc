// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/log_findings.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "calib/errors/reliability.h"
#include "calib/problem/flips.h"
#include "calib/stream/trajectory_buffer.h"
#include "calib/verdict/validity.h"
#include "models/physics/polygon.h"

namespace octant::calib {
namespace {

/// Findings of a part of a log about one of its trajectories, without the sampled states.
struct PartFindings {
  std::size_t run = 0, vehicle = 0;
  ObservationCounts counts;
  std::size_t stateless = 0;  ///< arrivals
  int stateless_line = 0;     ///< line of the first of them
  std::vector<std::int64_t> flipped;
  std::vector<LeftOutBearing> bearings;    ///< all of them, those in use too
  std::vector<RejectionCounts> of_beacon;  ///< its arrivals
  LogExtent extent;                        ///< its places: the corners of their hull
};

}  // namespace

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<ObservationCounts> auto&& counts) {
  buffer.exchange(counts.used, counts.rejected, counts.states, counts.observations, counts.squares_s2);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<LeftOutBearing> auto&& b) {
  buffer.exchange(b.run, b.bearing, b.reason);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<PartFindings> auto&& f) {
  buffer.exchange(f.run, f.vehicle, f.counts, f.stateless, f.stateless_line, f.flipped, f.bearings,
                  f.of_beacon, f.extent.places_m, f.extent.lowest_m, f.extent.highest_m,
                  f.extent.coldest_degC, f.extent.hottest_degC);
}

FindingsGatherer::FindingsGatherer(const Problem& frame, const Estimate& estimate, std::size_t states)
    : frame_(frame), model_(trajectory_model(frame.site)), state_(estimate.state()) {
  totals_.epochs = states;
  totals_.stride = sample_stride(states);
  totals_.of_beacon.assign(frame.site.beacons.size(), {});
  findings_.arrivals.resize(frame.runs.size());
  for (const MeasurementLog& run : frame.runs) carried_.emplace_back(run.bearings.size(), false);
}

void FindingsGatherer::write(const TrajectoryFindings& part, std::vector<double>& numbers) const {
  const Trajectory& t = part.trajectory;
  PartFindings f;
  f.run = t.run;
  f.vehicle = t.vehicle.index();
  f.counts = count_observations(t, state_);
  f.counts.states -= part.counted_before;
  f.stateless = t.stateless_arrivals.size();
  if (f.stateless > 0) f.stateless_line = part.log.arrivals[t.stateless_arrivals.front()].line;
  f.flipped = part.flipped;
  for (const BearingObservation& b : t.bearings) f.bearings.push_back({t.run, b.bearing, b.rejection});
  f.of_beacon.resize(frame_.site.beacons.size());
  for (const ArrivalObservation& a : t.arrivals) f.of_beacon[a.beacon.index()].add(a.rejection);
  for (const std::size_t a : t.stateless_arrivals)
    f.of_beacon[part.log.arrivals[a].beacon.index()].add(Rejection::kNoPose);
  f.extent = extent_of(t, part.log, frame_.site);
  f.extent.places_m = convex_hull(std::move(f.extent.places_m));
  BufferWriter buffer(numbers);
  buffer.exchange(f);
  write_trajectory(part.sampled, part.log.arrivals, buffer);
}

void FindingsGatherer::read(const std::vector<double>& numbers) {
  for (BufferReader buffer(numbers); !buffer.ended();) {
    PartFindings f;
    buffer.exchange(f);
    GatheredTrajectory& of = of_trajectory_[{f.run, f.vehicle}];
    of.some.run = f.run;
    of.some.vehicle = VehicleId(f.vehicle);
    counts_.add(f.counts);
    if (of.stateless == 0) of.stateless_line = f.stateless_line;
    of.stateless += f.stateless;
    of.flipped.insert(of.flipped.end(), f.flipped.begin(), f.flipped.end());
    for (const LeftOutBearing& bearing : f.bearings) {
      carried_[bearing.run][bearing.bearing] = true;
      if (bearing.reason != Rejection::kUsed) findings_.left_out.bearings.push_back(bearing);
    }
    for (std::size_t b = 0; b < f.of_beacon.size(); ++b) totals_.of_beacon[b].add(f.of_beacon[b]);
    totals_.extent.include(f.extent);
    read_trajectory(model_, buffer, of.some, findings_.arrivals[f.run]);
  }
}

void FindingsGatherer::count_stateless(std::size_t beacon, std::size_t arrivals) {
  counts_.rejected += arrivals;
  totals_.of_beacon[beacon].add(Rejection::kNoPose, arrivals);
}

GatheredFindings FindingsGatherer::findings(const Estimate& estimate) && {
  Findings& f = findings_;
  f.statistics = statistics_of(frame_, estimate.layout, counts_, estimate.last.cost);
  for (auto& [key, of] : of_trajectory_) {
    const MeasurementLog& run = frame_.runs[key.first];
    if (of.stateless > 0)
      findings_.warnings.push_back(stateless_in_words(run, of.stateless_line, of.stateless));
    const bool measured = !run.poses.empty() || !run.odometry.empty();
    if (run.bearings.empty() && !has_heading(frame_.site, VehicleId(key.second), measured))
      of.flipped.clear();
    for (std::string& words : flips_in_words(run, of.flipped)) f.flips.push_back(std::move(words));
    if (!of.some.nodes.empty()) findings_.trajectories.push_back(std::move(of.some));
  }
  leave_out_bearings_of_no_state();
  totals_.extent.places_m = convex_hull(std::move(totals_.extent.places_m));
  f.totals = std::move(totals_);
  return std::move(findings_);
}

void FindingsGatherer::leave_out_bearings_of_no_state() {
  for (std::size_t run = 0; run < carried_.size(); ++run) {
    const auto count = std::ranges::count(carried_[run], false);
    for (std::size_t i = 0; i < carried_[run].size(); ++i)
      if (!carried_[run][i]) findings_.left_out.bearings.push_back({run, i, Rejection::kNoPose});
    // In memory, such a stop is a state; a streamed log knows only its arrivals.
    if (count > 0 && frame_.runs[run].has_epochs)
      findings_.warnings.push_back(
          fmt::format("{}: {} bearing{} left out, of stops at which nothing was heard, as the log is read in "
                      "chunks; with more --memory-mb they take part",
                      frame_.runs[run].path, count, count == 1 ? " is" : "s are"));
  }
}

}  // namespace octant::calib
