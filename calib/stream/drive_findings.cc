// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drive_findings.h"

#include <algorithm>
#include <utility>

#include "calib/errors/reliability.h"
#include "calib/verdict/validity.h"
#include "models/trajectory/settle.h"

namespace octant::calib {
namespace {

/// Appends a list of observations whose nodes and own indices stand so much further.
template <class Observation>
void append_moved(std::vector<Observation>& to, const std::vector<Observation>& from, std::size_t nodes) {
  for (Observation o : from) {
    o.node = static_cast<decltype(o.node)>(o.node + nodes);
    to.push_back(o);
  }
}

}  // namespace

DriveFindings::DriveFindings(const Problem& frame, const DriveIndex& index, const Estimate& estimate)
    : frame_(frame),
      index_(index),
      estimate_(estimate),
      state_(estimate.state()),
      every_(looked_at_every(index.nodes())),
      of_piece_(index.pieces().size()) {}

void DriveFindings::take(std::size_t piece, const DriveWork& w) {
  OfPiece& of = of_piece_[piece];
  const Trajectory& t = w.t();
  of.counts = count_observations(t, state_);
  if (w.piece->open_left && t.nodes.front().placed) of.counts.states -= 3;  // told by the piece before
  of.series = pair_series(t, state_);
  of.of_beacon.assign(frame_.site.beacons.size(), {});
  for (const ArrivalObservation& a : t.arrivals) {
    ++of.of_beacon[a.beacon.index()][static_cast<std::size_t>(a.rejection)];
    const double degC = temperature_of(w.log.arrivals[a.arrival], w.log, frame_.site);
    of.coldest_degC = std::min(of.coldest_degC, degC);
    of.hottest_degC = std::max(of.hottest_degC, degC);
  }
  for (const Node& n : t.nodes)
    if (n.placed) of.area_m.emplace_back(n.T_map_vehicle.translation_m.head<2>());
  of.area_m = convex_hull(std::move(of.area_m));
  take_stretches(w, of);
}

void DriveFindings::take_stretches(const DriveWork& w, OfPiece& of) const {
  const Trajectory& t = w.t();
  std::vector<Segment> some;
  for (std::size_t u = w.piece->first_unit; u < w.piece->last_unit; ++u) {
    if (u % every_ != 0) continue;
    const std::size_t first = (u - w.piece->first_unit) * kUnitNodes;
    some.push_back(stretch_of(t, t.segments.front(), first, std::min(first + kUnitNodes, t.nodes.size())));
  }
  of.some = pick_segments(t, some);
  for (const Segment& s : of.some.segments)
    if (of.some.nodes[s.first_node].placed) octant::settle(of.some, s, state_, {});
  for (ArrivalObservation& a : of.some.arrivals) {
    of.arrivals.push_back(w.log.arrivals[a.arrival]);
    a.arrival = static_cast<std::uint32_t>(of.arrivals.size() - 1);
  }
}

/// @param arrivals  of the run, as far as they are at hand
void DriveFindings::add_stretches(OfPiece& of, Trajectory& to, std::vector<Arrival>& arrivals) const {
  if (to.nodes.empty()) {
    to = std::move(of.some);
    for (ArrivalObservation& a : to.arrivals) a.arrival += static_cast<std::uint32_t>(arrivals.size());
  } else {
    const std::size_t nodes = to.nodes.size(), heard = to.arrivals.size(), steps = to.odometry.size();
    for (ArrivalObservation& a : of.some.arrivals) a.arrival += static_cast<std::uint32_t>(arrivals.size());
    append_moved(to.arrivals, of.some.arrivals, nodes);
    append_moved(to.odometry, of.some.odometry, nodes);
    to.nodes.insert(to.nodes.end(), of.some.nodes.begin(), of.some.nodes.end());
    for (Segment s : of.some.segments) {
      s.first_node += nodes, s.last_node += nodes;
      s.first_arrival += heard, s.last_arrival += heard;
      s.first_odometry += steps, s.last_odometry += steps;
      to.segments.push_back(s);
    }
  }
  arrivals.insert(arrivals.end(), of.arrivals.begin(), of.arrivals.end());
  of.arrivals = {};
  of.some = {};
}

LogFindings DriveFindings::findings() && {
  LogFindings out;
  out.arrivals.resize(frame_.runs.size());
  WholeLog whole;
  whole.every = every_;
  whole.epochs = index_.nodes();
  whole.of_beacon.assign(frame_.site.beacons.size(), {});
  ObservationCounts counts;
  std::vector<std::vector<PairSeries>> series(index_.chains().size());
  std::vector<Trajectory> trajectories(index_.chains().size());
  for (std::size_t k = 0; k < of_piece_.size(); ++k) {
    OfPiece& of = of_piece_[k];
    const std::size_t c = index_.pieces()[k].chain;
    counts.add(of.counts);
    series[c].resize(of.series.size());
    for (std::size_t i = 0; i < of.series.size(); ++i) series[c][i].append(of.series[i]);
    for (std::size_t b = 0; b < whole.of_beacon.size(); ++b)
      for (std::size_t r = 0; r < kRejections; ++r) whole.of_beacon[b][r] += of.of_beacon[b][r];
    whole.area_m.insert(whole.area_m.end(), of.area_m.begin(), of.area_m.end());
    whole.coldest_degC = std::min(whole.coldest_degC, of.coldest_degC);
    whole.hottest_degC = std::max(whole.hottest_degC, of.hottest_degC);
    add_stretches(of, trajectories[c], out.arrivals[index_.chains()[c].run]);
  }
  for (std::size_t c = 0; c < trajectories.size(); ++c) {
    const DriveChain& chain = index_.chains()[c];
    counts.rejected += chain.stateless_count;
    for (std::size_t b = 0; b < whole.of_beacon.size(); ++b)
      whole.of_beacon[b][static_cast<std::size_t>(Rejection::kNoPose)] += chain.stateless[b];
    if (!trajectories[c].nodes.empty()) out.trajectories.push_back(std::move(trajectories[c]));
  }
  std::erase_if(series, [](const std::vector<PairSeries>& of_chain) { return of_chain.empty(); });
  out.findings.statistics = statistics_of(frame_, estimate_.layout, counts, estimate_.last.cost);
  out.findings.whiteness = whiteness_of(series);
  whole.area_m = convex_hull(std::move(whole.area_m));
  out.findings.whole = std::move(whole);
  return out;
}

}  // namespace octant::calib
