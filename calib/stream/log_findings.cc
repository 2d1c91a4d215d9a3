// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/log_findings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "calib/errors/reliability.h"
#include "calib/problem/flips.h"
#include "calib/stream/trajectory_buffer.h"
#include "calib/verdict/validity.h"
#include "models/physics/polygon.h"

namespace octant::calib {
namespace {

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<ObservationCounts> auto&& counts) {
  buffer.exchange(counts.used, counts.rejected, counts.states, counts.observations, counts.squares_s2);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<PairSeries> auto&& series) {
  buffer.exchange(series.count, series.sum, series.squares, series.products, series.first, series.last);
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<LeftOutBearing> auto&& b) {
  buffer.exchange(b.run, b.bearing, b.reason, b.residual_rad);
}

}  // namespace

FindingsGatherer::FindingsGatherer(const Problem& frame, const Estimate& estimate, std::size_t states)
    : frame_(frame), model_(trajectory_model(frame.site)), state_(estimate.state()) {
  totals_.epochs = states;
  totals_.stride = sample_stride(states);
  totals_.of_beacon.assign(frame.site.beacons.size(), {});
  findings_.arrivals.resize(frame.runs.size());
  for (const MeasurementLog& run : frame.runs) carried_.emplace_back(run.bearings.size(), false);
}

void FindingsGatherer::write(const TrajectoryFindings& part, std::vector<double>& numbers) const {
  BufferWriter buffer(numbers);
  buffer.put_count(part.trajectory.run);
  buffer.put_count(part.trajectory.vehicle.index());
  write_counts(part, buffer);
  write_stateless(part, buffer);
  write_series(part.trajectory, buffer);
  buffer.put_count(part.flipped.size());
  for (const std::int64_t epoch : part.flipped) buffer.put_integer(epoch);
  write_bearings(part.trajectory, buffer);
  write_extent(part, buffer);
  write_trajectory(part.sampled, part.log.arrivals, buffer);
}

void FindingsGatherer::read(const std::vector<double>& numbers) {
  for (BufferReader buffer(numbers); !buffer.ended();) {
    const std::size_t run = buffer.count(), vehicle = buffer.count();
    GatheredTrajectory& of = of_trajectory_[{run, vehicle}];
    of.some.run = run;
    of.some.vehicle = VehicleId(vehicle);
    read_counts(buffer);
    read_stateless(of, buffer);
    of.series.resize(state_.beacon_p_map_m.size() * state_.receiver_p_vehicle_m.size());
    read_series(of.series, buffer);
    for (std::size_t n = buffer.count(); n > 0; --n) of.flipped.push_back(buffer.integer());
    read_bearings(buffer);
    read_extent(buffer);
    read_trajectory(model_, buffer, of.some, findings_.arrivals[run]);
  }
}

void FindingsGatherer::count_stateless(std::size_t beacon, std::size_t arrivals) {
  counts_.rejected += arrivals;
  totals_.of_beacon[beacon].add(Rejection::kNoPose, arrivals);
}

GatheredFindings FindingsGatherer::findings(const Estimate& estimate) && {
  Findings& f = findings_.findings;
  f.statistics = statistics_of(frame_, estimate.layout, counts_, estimate.last.cost);
  std::vector<std::vector<PairSeries>> series;
  for (auto& [key, of] : of_trajectory_) {
    series.push_back(std::move(of.series));
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
  f.whiteness = whiteness_of(series);
  totals_.area_m = convex_hull(std::move(totals_.area_m));
  f.totals = std::move(totals_);
  return std::move(findings_);
}

void FindingsGatherer::leave_out_bearings_of_no_state() {
  for (std::size_t run = 0; run < carried_.size(); ++run) {
    const auto count = std::ranges::count(carried_[run], false);
    for (std::size_t i = 0; i < carried_[run].size(); ++i)
      if (!carried_[run][i])
        findings_.findings.left_out.bearings.push_back({run, i, Rejection::kNoPose, 0.0});
    // Held in memory such a stop is a state; a log that is read in chunks is known by its arrivals alone.
    if (count > 0 && frame_.runs[run].has_epochs)
      findings_.warnings.push_back(
          fmt::format("{}: {} bearing{} left out, of stops at which nothing was heard, as the log is read in "
                      "chunks; with more --memory-mb they take part",
                      frame_.runs[run].path, count, count == 1 ? " is" : "s are"));
  }
}

void FindingsGatherer::write_counts(const TrajectoryFindings& part, BufferWriter& buffer) const {
  ObservationCounts counts = count_observations(part.trajectory, state_);
  counts.states -= part.counted_before;
  exchange(buffer, counts);
}

void FindingsGatherer::write_stateless(const TrajectoryFindings& part, BufferWriter& buffer) {
  const std::vector<std::size_t>& stateless = part.trajectory.stateless_arrivals;
  buffer.put_count(stateless.size());
  if (!stateless.empty()) buffer.put_integer(part.log.arrivals[stateless.front()].line);
}

void FindingsGatherer::read_stateless(GatheredTrajectory& of, BufferReader& buffer) {
  const std::size_t count = buffer.count();
  if (count == 0) return;
  const auto line = static_cast<int>(buffer.integer());
  if (of.stateless == 0) of.stateless_line = line;
  of.stateless += count;
}

void FindingsGatherer::read_counts(BufferReader& buffer) {
  ObservationCounts counts;
  exchange(buffer, counts);
  counts_.add(counts);
}

void FindingsGatherer::write_series(const Trajectory& t, BufferWriter& buffer) const {
  const std::vector<PairSeries> series = pair_series(t, state_);
  buffer.put_count(static_cast<std::size_t>(
      std::ranges::count_if(series, [](const PairSeries& s) { return s.count > 0; })));
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (series[i].count == 0) continue;
    buffer.put_count(i);
    exchange(buffer, series[i]);
  }
}

void FindingsGatherer::read_series(std::vector<PairSeries>& series, BufferReader& buffer) {
  for (std::size_t n = buffer.count(); n > 0; --n) {
    PairSeries& pair = series[buffer.count()];
    PairSeries later;
    exchange(buffer, later);
    pair.append(later);
  }
}

/// All bearings of a part, with what they are off by where they do not fit.
void FindingsGatherer::write_bearings(const Trajectory& t, BufferWriter& buffer) const {
  buffer.put_count(t.bearings.size());
  for (std::size_t i = 0; i < t.bearings.size(); ++i)
    exchange(buffer,
             LeftOutBearing{t.run, t.bearings[i].bearing, t.bearings[i].rejection, misfit_rad(t, i, state_)});
}

void FindingsGatherer::read_bearings(BufferReader& buffer) {
  for (std::size_t n = buffer.count(); n > 0; --n) {
    LeftOutBearing bearing;
    exchange(buffer, bearing);
    carried_[bearing.run][bearing.bearing] = true;
    if (bearing.reason != Rejection::kUsed) findings_.findings.left_out.bearings.push_back(bearing);
  }
}

/// Where states were, how warm it was, and what became of the arrivals.
void FindingsGatherer::write_extent(const TrajectoryFindings& part, BufferWriter& buffer) const {
  std::vector<RejectionCounts> of_beacon(frame_.site.beacons.size());
  for (const ArrivalObservation& a : part.trajectory.arrivals) of_beacon[a.beacon.index()].add(a.rejection);
  for (const std::size_t a : part.trajectory.stateless_arrivals)
    of_beacon[part.log.arrivals[a].beacon.index()].add(Rejection::kNoPose);
  for (const RejectionCounts& counts : of_beacon)
    for (const std::size_t count : counts) buffer.put_count(count);
  LogExtent extent;
  extent.add(part.trajectory, part.log, frame_.site);
  const std::vector<Eigen::Vector2d> corners = convex_hull(std::move(extent.places_m));
  buffer.put_count(corners.size());
  for (const Eigen::Vector2d& p : corners) buffer.exchange(p);
  buffer.exchange(extent.coldest_degC, extent.hottest_degC);
}

void FindingsGatherer::read_extent(BufferReader& buffer) {
  for (auto& counts : totals_.of_beacon)
    for (std::size_t& count : counts) count += buffer.count();
  for (std::size_t n = buffer.count(); n > 0; --n) {
    buffer.exchange(totals_.area_m.emplace_back());
  }
  totals_.coldest_degC = std::min(totals_.coldest_degC, buffer.get());
  totals_.hottest_degC = std::max(totals_.hottest_degC, buffer.get());
}

}  // namespace octant::calib
