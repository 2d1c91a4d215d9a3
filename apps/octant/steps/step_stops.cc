// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Received arrivals at stops, and along parts of drives, for the report.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "apps/octant/steps/reporting.h"

namespace octant::app {
namespace {

constexpr std::size_t kMostStops = 1000, kMostMisses = 2000;
constexpr std::size_t kStretches = 60;  // number of parts of a drive

using RowKey = std::pair<std::size_t, std::size_t>;  // run, arrival

/// Number of nodes in one entry: one for stops, several for drives.
std::size_t nodes_together(const Trajectory& t) {
  return t.moving ? std::max<std::size_t>(1, (t.nodes.size() + kStretches - 1) / kStretches) : 1;
}

std::string stop_name(const Trajectory& t, std::size_t first, std::size_t last,
                      const calib::Problem& problem) {
  const Node& node = t.nodes[first];
  std::string name;
  if (problem.runs.size() > 1) name += fmt::format("run {}: ", t.run + 1);
  if (problem.site.vehicles.size() > 1) name += problem.site.vehicles[t.vehicle.index()].name + ": ";
  if (!t.moving && node.epoch != kNoEpoch) return name + std::to_string(node.epoch);
  return name + (t.moving ? fmt::format("{:.6g} to {:.6g} s", node.time_s, t.nodes[last].time_s)
                          : fmt::format("{:.6g} s", node.time_s));
}

struct MissCount {
  std::size_t late = 0, early = 0, other = 0;
};

/// Counts and residuals of the stops of one trajectory.
class StopsOf {
 public:
  StopsOf(const Trajectory& t, const calib::Problem& problem, const std::map<RowKey, double>& residuals)
      : t_(t), problem_(problem), residuals_(residuals), together_(nodes_together(t)) {}

  void add_to(survey::ReportInput& input) {
    const std::size_t stops = (t_.nodes.size() + together_ - 1) / together_;
    notes_.resize(stops);
    misses_.resize(stops);
    for (const ArrivalObservation& a : t_.arrivals) count(a);
    for (std::size_t k = 0; k < stops; ++k) finish(k, input);
  }

 private:
  void count(const ArrivalObservation& a) {
    survey::StopNote& note = notes_[a.node / together_];
    if (a.rejection == Rejection::kUsed) {
      ++note.used;
      if (const auto at = residuals_.find({t_.run, a.arrival}); at != residuals_.end()) {
        ++note.looked_at;
        note.mean_s += at->second;
        note.rms_s += at->second * at->second;
      }
      return;
    }
    MissCount& miss = misses_[a.node / together_][a.beacon.index()];
    if (a.rejection == Rejection::kLate) {
      ++note.late;
      ++miss.late;
    } else if (a.rejection == Rejection::kEarly) {
      ++note.early;
      ++miss.early;
    } else {
      ++note.other;
      ++miss.other;
    }
  }

  void finish(std::size_t k, survey::ReportInput& input) {
    survey::StopNote& note = notes_[k];
    const std::size_t first = k * together_, last = std::min(first + together_, t_.nodes.size()) - 1;
    const Node& middle = t_.nodes[(first + last) / 2];
    if (!middle.placed || note.used + note.left_out() == 0) return;
    note.name = stop_name(t_, first, last, problem_);
    note.moving = t_.moving;
    note.at_m = middle.T_map_vehicle.translation_m.head<2>();
    if (!note.at_m.allFinite()) return;
    if (note.looked_at > 0) {
      note.mean_s /= static_cast<double>(note.looked_at);
      note.rms_s = std::sqrt(note.rms_s / static_cast<double>(note.looked_at));
    }
    for (const auto& [beacon, miss] : misses_[k])
      input.misses.push_back(
          {problem_.site.beacons[beacon].name, note.at_m, miss.late, miss.early, miss.other});
    input.stops.push_back(std::move(note));
  }

  const Trajectory& t_;
  const calib::Problem& problem_;
  const std::map<RowKey, double>& residuals_;
  std::size_t together_;
  std::vector<survey::StopNote> notes_;
  std::vector<std::map<std::size_t, MissCount>> misses_;
};

/// Keeps the most conspicuous stops, in their order.
void keep_few(std::vector<survey::StopNote>& stops) {
  if (stops.size() <= kMostStops) return;
  std::vector<std::pair<std::size_t, double>> worth;
  for (const survey::StopNote& stop : stops) worth.emplace_back(stop.left_out(), stop.rms_s);
  std::vector<std::pair<std::size_t, double>> order = worth;
  std::ranges::nth_element(order, order.begin() + kMostStops, std::greater<>());
  std::vector<survey::StopNote> few;
  for (std::size_t i = 0; i < stops.size() && few.size() < kMostStops; ++i)
    if (worth[i] >= order[kMostStops]) few.push_back(std::move(stops[i]));
  stops = std::move(few);
}

/// Adds residuals by stop to those by beacon.
void add_stop_chart(survey::ReportInput& input) {
  survey::ResidualChart chart{"stop", "", {}};
  for (const survey::StopNote& stop : input.stops)
    if (!stop.moving && stop.looked_at > 0)
      chart.bins.push_back({stop.name, 0.0, 0.0, stop.looked_at, stop.mean_s, stop.rms_s});
  if (chart.bins.empty() || input.residuals.empty()) return;
  input.residuals.insert(input.residuals.begin() + 1, std::move(chart));
}

}  // namespace

void add_stops(const Calibration& calibration, survey::ReportInput& input) {
  std::map<RowKey, double> residuals;
  for (const calib::ArrivalReliability& a : calibration.solution.reliability.arrivals)
    if (std::isfinite(a.residual_s)) residuals[{a.run, a.arrival}] = a.residual_s;
  for (const Trajectory& t : calibration.solution.trajectories)
    if (!t.nodes.empty()) StopsOf(t, calibration.problem, residuals).add_to(input);
  keep_few(input.stops);
  if (input.misses.size() > kMostMisses) {
    std::ranges::stable_sort(input.misses,
                             [](const auto& a, const auto& b) { return a.count() > b.count(); });
    input.misses.resize(kMostMisses);
    const auto place = [](const survey::PlanMiss& m) { return std::pair(m.at_m.x(), m.at_m.y()); };
    std::ranges::stable_sort(input.misses, [&](const auto& a, const auto& b) { return place(a) < place(b); });
  }
  add_stop_chart(input);
}

}  // namespace octant::app
