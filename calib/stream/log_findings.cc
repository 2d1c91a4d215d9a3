// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/log_findings.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "calib/errors/reliability.h"
#include "calib/problem/flips.h"
#include "calib/problem/thin.h"
#include "calib/verdict/validity.h"

namespace octant::calib {

FindingsGatherer::FindingsGatherer(const Problem& frame, const ArrivalSource& source, const LogIndex& index,
                                   const TrajectoryModel& model, const Estimate& estimate)
    : frame_(frame),
      source_(source),
      index_(index),
      model_(model),
      site_(frame.site),
      state_(estimate.state()),
      sigma_s_(site_.noise.tof_sigma_s * estimate.noise_factor) {
  for (const LogChunk& chunk : index.chunks())
    whole_.epochs += std::accumulate(chunk.epochs.begin(), chunk.epochs.end(), std::size_t{0});
  whole_.every = looked_at_every(whole_.epochs);
  whole_.of_beacon.assign(site_.beacons.size(), {});
}

void FindingsGatherer::write(const ChunkWork& w, const ChunkStops& stops, std::size_t chunk,
                             std::vector<double>& numbers) const {
  TapeWriter tape(numbers);
  tape.put_count(chunk);
  std::vector<std::array<std::size_t, kRejections>> of_beacon(site_.beacons.size());
  std::vector<Eigen::Vector2d> places;
  double coldest = INFINITY, hottest = -INFINITY;
  std::size_t node = 0;
  for (const Trajectory& t : w.trajectories) {
    write_counts(t, tape);
    write_series(t, tape);
    std::vector<std::int64_t> flipped;
    for (const Node& n : t.nodes) {
      if (n.placed) places.emplace_back(n.T_map_vehicle.translation_m.head<2>());
      if (is_flipped(n, static_cast<double>(stops.start_heading_rad[node++]))) flipped.push_back(n.epoch);
    }
    tape.put_count(flipped.size());
    for (const std::int64_t epoch : flipped) tape.put_integer(epoch);
    write_some_epochs(w, t, tape);
    for (const ArrivalObservation& a : t.arrivals) {
      ++of_beacon[a.beacon.index()][static_cast<std::size_t>(a.rejection)];
      const double degC = temperature_of(w.log.arrivals[a.arrival], w.log, site_);
      coldest = std::min(coldest, degC);
      hottest = std::max(hottest, degC);
    }
  }
  for (const auto& counts : of_beacon)
    for (const std::size_t count : counts) tape.put_count(count);
  places = convex_hull(std::move(places));
  tape.put_count(places.size());
  for (const Eigen::Vector2d& p : places) tape.put(p.x()), tape.put(p.y());
  tape.put(coldest);
  tape.put(hottest);
}

void FindingsGatherer::read(const std::vector<double>& numbers) {
  findings_.arrivals.resize(source_.runs());
  for (TapeReader tape(numbers); !tape.ended();) {
    const LogChunk& chunk = index_.chunks()[tape.count()];
    for (std::size_t v = 0; v < chunk.arrivals.size(); ++v)
      if (chunk.arrivals[v] > 0) read_trajectory(chunk.run, v, tape);
    for (auto& counts : whole_.of_beacon)
      for (std::size_t& count : counts) count += tape.count();
    for (std::size_t n = tape.count(); n > 0; --n) {
      const double x_m = tape.get();
      whole_.area_m.emplace_back(x_m, tape.get());
    }
    whole_.coldest_degC = std::min(whole_.coldest_degC, tape.get());
    whole_.hottest_degC = std::max(whole_.hottest_degC, tape.get());
  }
}

LogFindings FindingsGatherer::findings(const Estimate& estimate) && {
  Findings& f = findings_.findings;
  f.statistics = statistics_of(frame_, estimate.layout, counts_, estimate.last.cost);
  std::vector<std::vector<PairSeries>> series;
  for (auto& [key, of] : of_trajectory_) {
    series.push_back(std::move(of.series));
    if (!has_heading(frame_.site, VehicleId(key.second), false)) of.flipped.clear();
    for (std::string& words : flips_in_words(frame_.runs[key.first], of.flipped))
      f.flips.push_back(std::move(words));
    findings_.trajectories.push_back(trajectory_of(key.first, key.second, of));
  }
  f.whiteness = whiteness_of(series);
  whole_.area_m = convex_hull(std::move(whole_.area_m));
  f.whole = std::move(whole_);
  return std::move(findings_);
}

void FindingsGatherer::write_counts(const Trajectory& t, TapeWriter& tape) const {
  const ObservationCounts counts = count_observations(t, state_);
  for (const std::size_t count : {counts.used, counts.rejected, counts.states}) tape.put_count(count);
  tape.put(counts.observations);
  tape.put(counts.squares_s2);
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

void FindingsGatherer::write_some_epochs(const ChunkWork& w, const Trajectory& t, TapeWriter& tape) const {
  const std::size_t before = w.chunk->epochs_before[t.vehicle.index()], every = whole_.every;
  const std::size_t first = (every - before % every) % every;
  tape.put_count(first < t.nodes.size() ? (t.nodes.size() - first + every - 1) / every : 0);
  for (std::size_t k = first; k < t.nodes.size(); k += every) {
    const Segment& s = t.segments[k];
    const Node& n = t.nodes[k];
    tape.put(n.T_map_vehicle.translation_m.x());
    tape.put(n.T_map_vehicle.translation_m.y());
    tape.put(n.placed ? n.T_map_vehicle.heading_rad() : NAN);
    tape.put_count(s.last_arrival - s.first_arrival);
    for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
      const Arrival& a = w.log.arrivals[t.arrivals[i].arrival];
      for (const double number : {a.time_s, a.tof_s, a.amplitude_v, a.temperature_degC}) tape.put(number);
      tape.put_count(a.beacon.index());
      tape.put_count(a.receiver.index());
      tape.put_integer(a.epoch);
      tape.put_integer(a.line);
      tape.put_count(static_cast<std::size_t>(t.arrivals[i].rejection));
    }
  }
}

void FindingsGatherer::read_trajectory(std::size_t run, std::size_t vehicle, TapeReader& tape) {
  OfTrajectory& of = of_trajectory_[{run, vehicle}];
  ObservationCounts counts;
  counts.used = tape.count();
  counts.rejected = tape.count();
  counts.states = tape.count();
  counts.observations = tape.get();
  counts.squares_s2 = tape.get();
  counts_.add(counts);
  of.series.resize(state_.beacon_p_map_m.size() * state_.receiver_p_vehicle_m.size());
  for (std::size_t n = tape.count(); n > 0; --n) {
    PairSeries& pair = of.series[tape.count()];
    PairSeries s;
    s.count = tape.count();
    for (double* number : {&s.sum, &s.squares, &s.products, &s.first, &s.last}) *number = tape.get();
    pair.append(s);
  }
  for (std::size_t n = tape.count(); n > 0; --n) of.flipped.push_back(tape.integer());
  for (std::size_t n = tape.count(); n > 0; --n) read_epoch(vehicle, of, tape);
}

void FindingsGatherer::read_epoch(std::size_t vehicle, OfTrajectory& of, TapeReader& tape) {
  std::array<double, 3> pose{};
  for (double& number : pose) number = tape.get();
  of.pose.push_back(pose);
  for (std::size_t n = tape.count(); n > 0; --n) {
    Arrival a;
    for (double* number : {&a.time_s, &a.tof_s, &a.amplitude_v, &a.temperature_degC}) *number = tape.get();
    a.beacon = BeaconId(tape.count());
    a.receiver = ReceiverId(tape.count());
    a.vehicle = VehicleId(vehicle);
    a.epoch = tape.integer();
    a.line = static_cast<int>(tape.integer());
    of.arrivals.push_back(a);
    of.marks.push_back(static_cast<Rejection>(tape.count()));
  }
}

Trajectory FindingsGatherer::trajectory_of(std::size_t run, std::size_t vehicle, OfTrajectory& of) {
  MeasurementLog log = without_lists(source_.log(run));
  std::vector<Arrival>& all = findings_.arrivals[run];
  const std::size_t before = all.size();
  log.arrivals = std::move(of.arrivals);
  Trajectory t = make_trajectory(log, run, VehicleId(vehicle), model_);
  for (std::size_t k = 0; k < t.nodes.size(); ++k) {
    const auto& [x_m, y_m, heading_rad] = of.pose[k];
    t.nodes[k].placed = !std::isnan(heading_rad);
    if (t.nodes[k].placed) t.nodes[k].T_map_vehicle = Pose::planar(x_m, y_m, heading_rad);
  }
  for (std::size_t i = 0; i < t.arrivals.size(); ++i) {
    t.arrivals[i].rejection = of.marks[i];
    t.arrivals[i].sigma_s = sigma_s_;
    t.arrivals[i].arrival += static_cast<std::uint32_t>(before);
  }
  all.insert(all.end(), log.arrivals.begin(), log.arrivals.end());
  return t;
}

}  // namespace octant::calib
