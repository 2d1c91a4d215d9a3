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
#include "calib/stream/trajectory_tape.h"
#include "calib/verdict/validity.h"

namespace octant::calib {

FindingsGatherer::FindingsGatherer(const Problem& frame, const Estimate& estimate, std::size_t states)
    : frame_(frame), model_(trajectory_model(frame.site)), state_(estimate.state()) {
  whole_.epochs = states;
  whole_.every = looked_at_every(states);
  whole_.of_beacon.assign(frame.site.beacons.size(), {});
  findings_.arrivals.resize(frame.runs.size());
  for (const MeasurementLog& run : frame.runs) carried_.emplace_back(run.bearings.size(), false);
}

void FindingsGatherer::write(const PartFindings& part, std::vector<double>& numbers) const {
  TapeWriter tape(numbers);
  tape.put_count(part.trajectory.run);
  tape.put_count(part.trajectory.vehicle.index());
  write_counts(part, tape);
  write_stateless(part, tape);
  write_series(part.trajectory, tape);
  tape.put_count(part.flipped.size());
  for (const std::int64_t epoch : part.flipped) tape.put_integer(epoch);
  write_bearings(part.trajectory, tape);
  write_extent(part, tape);
  write_trajectory(part.looked_at, part.log.arrivals, tape);
}

void FindingsGatherer::read(const std::vector<double>& numbers) {
  for (TapeReader tape(numbers); !tape.ended();) {
    const std::size_t run = tape.count(), vehicle = tape.count();
    OfTrajectory& of = of_trajectory_[{run, vehicle}];
    of.some.run = run;
    of.some.vehicle = VehicleId(vehicle);
    read_counts(tape);
    read_stateless(of, tape);
    of.series.resize(state_.beacon_p_map_m.size() * state_.receiver_p_vehicle_m.size());
    read_series(of.series, tape);
    for (std::size_t n = tape.count(); n > 0; --n) of.flipped.push_back(tape.integer());
    read_bearings(run, tape);
    read_extent(tape);
    read_trajectory(model_, tape, of.some, findings_.arrivals[run]);
  }
}

void FindingsGatherer::count_stateless(std::size_t beacon, std::size_t arrivals) {
  counts_.rejected += arrivals;
  whole_.of_beacon[beacon][static_cast<std::size_t>(Rejection::kNoPose)] += arrivals;
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
  whole_.area_m = convex_hull(std::move(whole_.area_m));
  f.whole = std::move(whole_);
  return std::move(findings_);
}

void FindingsGatherer::leave_out_bearings_of_no_state() {
  for (std::size_t run = 0; run < carried_.size(); ++run) {
    const auto count = std::count(carried_[run].begin(), carried_[run].end(), false);
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

void FindingsGatherer::write_counts(const PartFindings& part, TapeWriter& tape) const {
  const ObservationCounts counts = count_observations(part.trajectory, state_);
  for (const std::size_t count : {counts.used, counts.rejected, counts.states - part.told_before})
    tape.put_count(count);
  tape.put(counts.observations);
  tape.put(counts.squares_s2);
}

void FindingsGatherer::write_stateless(const PartFindings& part, TapeWriter& tape) {
  const std::vector<std::size_t>& stateless = part.trajectory.stateless_arrivals;
  tape.put_count(stateless.size());
  if (!stateless.empty()) tape.put_integer(part.log.arrivals[stateless.front()].line);
}

void FindingsGatherer::read_stateless(OfTrajectory& of, TapeReader& tape) {
  const std::size_t count = tape.count();
  if (count == 0) return;
  const auto line = static_cast<int>(tape.integer());
  if (of.stateless == 0) of.stateless_line = line;
  of.stateless += count;
}

void FindingsGatherer::read_counts(TapeReader& tape) {
  ObservationCounts counts;
  for (std::size_t* count : {&counts.used, &counts.rejected, &counts.states}) *count = tape.count();
  counts.observations = tape.get();
  counts.squares_s2 = tape.get();
  counts_.add(counts);
}

void FindingsGatherer::write_series(const Trajectory& t, TapeWriter& tape) const {
  const std::vector<PairSeries> series = pair_series(t, state_);
  tape.put_count(static_cast<std::size_t>(
      std::count_if(series.begin(), series.end(), [](const PairSeries& s) { return s.count > 0; })));
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (series[i].count == 0) continue;
    tape.put_count(i);
    tape.put_count(series[i].count);
    for (const double number :
         {series[i].sum, series[i].squares, series[i].products, series[i].first, series[i].last})
      tape.put(number);
  }
}

void FindingsGatherer::read_series(std::vector<PairSeries>& series, TapeReader& tape) {
  for (std::size_t n = tape.count(); n > 0; --n) {
    PairSeries& pair = series[tape.count()];
    PairSeries s;
    s.count = tape.count();
    for (double* number : {&s.sum, &s.squares, &s.products, &s.first, &s.last}) *number = tape.get();
    pair.append(s);
  }
}

/// All bearings of a part, with what they are off by where they do not fit.
void FindingsGatherer::write_bearings(const Trajectory& t, TapeWriter& tape) const {
  tape.put_count(t.bearings.size());
  for (std::size_t i = 0; i < t.bearings.size(); ++i) {
    tape.put_count(t.bearings[i].bearing);
    tape.put_count(static_cast<std::size_t>(t.bearings[i].rejection));
    tape.put(misfit_rad(t, i, state_));
  }
}

void FindingsGatherer::read_bearings(std::size_t run, TapeReader& tape) {
  for (std::size_t n = tape.count(); n > 0; --n) {
    const std::size_t bearing = tape.count();
    const auto reason = static_cast<Rejection>(tape.count());
    const double misfit_rad = tape.get();
    carried_[run][bearing] = true;
    if (reason != Rejection::kUsed)
      findings_.findings.left_out.bearings.push_back({run, bearing, reason, misfit_rad});
  }
}

/// Where states were, how warm it was, and what became of the arrivals.
void FindingsGatherer::write_extent(const PartFindings& part, TapeWriter& tape) const {
  std::vector<std::array<std::size_t, kRejections>> of_beacon(frame_.site.beacons.size());
  double coldest = INFINITY, hottest = -INFINITY;
  for (const ArrivalObservation& a : part.trajectory.arrivals) {
    ++of_beacon[a.beacon.index()][static_cast<std::size_t>(a.rejection)];
    const double degC = temperature_of(part.log.arrivals[a.arrival], part.log, frame_.site);
    coldest = std::min(coldest, degC);
    hottest = std::max(hottest, degC);
  }
  for (const std::size_t a : part.trajectory.stateless_arrivals)
    ++of_beacon[part.log.arrivals[a].beacon.index()][static_cast<std::size_t>(Rejection::kNoPose)];
  for (const auto& counts : of_beacon)
    for (const std::size_t count : counts) tape.put_count(count);
  std::vector<Eigen::Vector2d> places;
  for (const Node& n : part.trajectory.nodes)
    if (n.placed) places.emplace_back(n.T_map_vehicle.translation_m.head<2>());
  places = convex_hull(std::move(places));
  tape.put_count(places.size());
  for (const Eigen::Vector2d& p : places) tape.put(p.x()), tape.put(p.y());
  tape.put(coldest);
  tape.put(hottest);
}

void FindingsGatherer::read_extent(TapeReader& tape) {
  for (auto& counts : whole_.of_beacon)
    for (std::size_t& count : counts) count += tape.count();
  for (std::size_t n = tape.count(); n > 0; --n) {
    const double x_m = tape.get();
    whole_.area_m.emplace_back(x_m, tape.get());
  }
  whole_.coldest_degC = std::min(whole_.coldest_degC, tape.get());
  whole_.hottest_degC = std::max(whole_.hottest_degC, tape.get());
}

}  // namespace octant::calib
