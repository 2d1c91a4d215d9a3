// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/imported_log.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "io/run/tum.h"
#include "io/text/text.h"
#include "io/tof/continued_clock.h"
#include "io/tof/run_parts.h"

namespace octant::io {
namespace {

template <class Rows>
bool put_in_order(Rows& rows) {
  const auto earlier = [](const auto& a, const auto& b) { return a.time_s < b.time_s; };
  if (std::ranges::is_sorted(rows, earlier)) return false;
  std::ranges::stable_sort(rows, earlier);
  return true;
}

/// Sorts poses by time and keeps the first one of each time.
void one_an_instant(std::vector<TimedPose>& poses, const char* what, ImportedLog& log) {
  put_in_order(poses);
  const std::size_t before = poses.size();
  poses.erase(std::unique(poses.begin(), poses.end(),
                          [](const TimedPose& a, const TimedPose& b) { return a.time_s == b.time_s; }),
              poses.end());
  if (poses.size() != before)
    log.warnings.push_back(fmt::format("{}: {} {} of an instant that there was already are left out",
                                       log.path, before - poses.size(), what));
}

template <class Test>
bool any_arrival(const ImportedLog& log, Test test) {
  return std::ranges::any_of(log.arrivals, test);
}

std::string tof_text(const ImportedLog& log, std::optional<double> speed_mps, bool distances) {
  const bool epoch = any_arrival(log, [](const auto&a) { return a.epoch != kNoEpoch; }),
             vehicle = any_arrival(log, [](const auto&a) { return a.vehicle >= 0; }),
             receiver = any_arrival(log, [](const auto&a) { return a.receiver >= 0; }),
             amplitude = any_arrival(log, [](const auto&a) { return std::isfinite(a.amplitude_v); }),
             temperature = any_arrival(log, [](const auto&a) { return std::isfinite(a.temperature_degC); }),
             received = any_arrival(log, [](const auto&a) { return std::isfinite(a.received_after_s); });
  std::vector<std::string> fields;
  for (const std::string& name : log.names.all()) fields.push_back(csv_field(name));
  const auto name = [&](int number) { return number < 0 ? "" : fields[static_cast<std::size_t>(number)]; };
  std::string text = distances ? "time_s,beacon,distance_m" : "time_s,beacon,tof_s";
  if (epoch) text += ",epoch";
  if (vehicle) text += ",vehicle";
  if (receiver) text += ",receiver";
  if (amplitude) text += ",amplitude_v";
  if (temperature) text += ",temperature_degC";
  if (received) text += ",received_s";
  text += '\n';
  const auto out = std::back_inserter(text);
  for (const ImportedArrival& a : log.arrivals) {
    fmt::format_to(out, "{},{},{}", a.time_s, name(a.beacon),
                   number_field(a.is_distance && speed_mps ? a.value / *speed_mps : a.value));
    if (epoch) fmt::format_to(out, ",{}", a.epoch != kNoEpoch ? std::to_string(a.epoch) : "");
    if (vehicle) fmt::format_to(out, ",{}", name(a.vehicle));
    if (receiver) fmt::format_to(out, ",{}", name(a.receiver));
    if (amplitude) fmt::format_to(out, ",{}", number_field(a.amplitude_v));
    if (temperature) fmt::format_to(out, ",{}", number_field(a.temperature_degC));
    if (received) fmt::format_to(out, ",{}", number_field(a.time_s + a.received_after_s));
    text += '\n';
  }
  return text;
}

void remove_only(int ImportedArrival::*name, ImportedLog& log) {
  const bool one = std::ranges::all_of(
      log.arrivals, [&](const ImportedArrival& a) { return a.*name == log.arrivals.front().*name; });
  if (!one) return;
  for (ImportedArrival& a : log.arrivals) a.*name = -1;
}

}  // namespace

void remove_only_receiver(ImportedLog& log) { remove_only(&ImportedArrival::receiver, log); }
void remove_only_vehicle(ImportedLog& log) { remove_only(&ImportedArrival::vehicle, log); }

int ImportedNames::number_of(std::string_view name) {
  const auto known = numbers_.find(name);
  if (known != numbers_.end()) return known->second;
  if (names_.size() >= kMostImportedNames) return -1;
  const int number = static_cast<int>(names_.size());
  names_.emplace_back(name);
  numbers_.emplace(names_.back(), number);
  return number;
}

std::size_t ImportedLog::ignored_rows() const {
  std::size_t rows = 0;
  for (const auto& [name, count] : ignored) rows += count;
  return rows;
}

Result<std::vector<FileContent>> run_files(ImportedLog& log, const std::string& folder,
                                           std::optional<double> speed_mps) {
  const bool distances = any_arrival(log, [](const auto& a) { return a.is_distance; });
  if (distances && !speed_mps && any_arrival(log, [](const auto& a) { return !a.is_distance; }))
    return fail({.file = log.path,
                 .found = "both times of flight and distances",
                 .expected = "one of the two",
                 .advice = "name the speed that the distances were made with: --speed-mps"});
  if (log.arrivals.empty() && log.odometry.empty() && log.poses.empty() && log.truth.empty())
    return fail({.file = log.path,
                 .found = "no row that was asked for",
                 .expected = "distances, times of flight, odometry or poses"});
  for (const auto& [name, rows] : log.ignored)
    log.warnings.push_back(
        fmt::format("{}: {} rows of beacon {}, which is ignored", log.path, rows, in_quotes(name)));
  if (log.not_heard > 0)
    log.warnings.push_back(fmt::format("{}: {} rows without a distance are left out: none was measured",
                                       log.path, log.not_heard));
  ContinuedClock clock;
  for (std::size_t i = 1; i < log.arrivals.size(); ++i)
    log.arrivals[i].time_s = clock.continued(log.arrivals[i].time_s, log.arrivals[i - 1].time_s, 0);
  if (const auto restarts = clock.note(log.path)) log.warnings.push_back(*restarts);
  if (put_in_order(log.arrivals))
    log.warnings.push_back(log.path + ": the rows are not in the order of time; they were sorted");
  one_an_instant(log.odometry, "poses of the odometry", log);
  one_an_instant(log.poses, "poses", log);
  one_an_instant(log.truth, "reference poses", log);

  std::vector<FileContent> files;
  const auto add = [&](const char* name, std::string content) {
    files.push_back({folder + "/" + name, std::move(content)});
  };
  if (!log.arrivals.empty()) add("tof.csv", tof_text(log, speed_mps, distances && !speed_mps));
  if (!log.odometry.empty()) {
    MeasurementLog steps;
    steps.odometry = steps_between(log.odometry, VehicleId(0));
    add("odometry.csv", odometry_to_csv(steps, {}));
  }
  if (!log.poses.empty()) add("poses.tum", poses_to_tum(log.poses));
  if (!log.truth.empty()) add("truth.tum", poses_to_tum(log.truth));
  if (!log.run_yaml.empty()) add("run.yaml", log.run_yaml);
  return files;
}

}  // namespace octant::io
