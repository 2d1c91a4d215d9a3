// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/tof/tof_rows.h"

#include <algorithm>

#include <fmt/format.h>

#include "models/repeated_row.h"

namespace octant::io {
namespace {

constexpr std::array<const char*, 6> kReasons = {"",
                                                 "tof_s is empty",
                                                 "tof_s is not a number",
                                                 "tof_s is not positive",
                                                 "tof_s is impossibly large",
                                                 kRepeatedRow};

/// Amplitude of the row. Level only where there is no amplitude.
bool read_amplitude(CsvReader& csv, const TofColumns& columns, double& amplitude_v) {
  if (columns.amplitude >= 0 && !csv.number_or_nan(columns.amplitude, amplitude_v)) return false;
  if (columns.level >= 0 && !(amplitude_v > 0.0)) {
    double level_dbm = 0.0;
    if (!csv.number_or_nan(columns.level, level_dbm)) return false;
    amplitude_v = amplitude_of_level(level_dbm);
  }
  amplitude_v = usable_amplitude(amplitude_v);
  return true;
}

bool read_temperature(CsvReader& csv, int column, double& temperature_degC) {
  if (!csv.number_or_nan(column, temperature_degC)) return false;
  if (is_temperature(temperature_degC)) return true;
  return csv.fail_at(column, fmt::format("temperature_degC is {}", exact(temperature_degC)),
                     "degrees Celsius from -100 to 100 (20 degC are 293 K)");
}

/// Returns true if distance_m replaces tof_s; an error if it has to and the speed is not known.
bool has_distance(CsvReader& csv, const DistanceAsTime& as_time) {
  const auto has = [&csv](const char* name) {
    return std::ranges::find(csv.header(), name) != csv.header().end();
  };
  if (has("tof_s") || !has("distance_m")) return false;
  if (as_time.per_m_s > 0.0) return true;
  csv.fail_at(
      -1,
      "column 'tof_s' is missing, and 'distance_m' stands for it only where the medium's speed is constant",
      "tof_s, or medium.model: constant in the site file",
      "state medium: {model: constant, speed_mps: ...}, the speed at which the device turned times into "
      "distances");
  return false;
}

}  // namespace

TofColumns::TofColumns(CsvReader& csv, const DistanceAsTime& as_time)
    : time(csv.require("time_s")),
      beacon(csv.require("beacon")),
      distance(has_distance(csv, as_time)),
      tof(distance ? csv.find("distance_m") : csv.require("tof_s")),
      epoch(csv.find("epoch")),
      vehicle(csv.find("vehicle")),
      receiver(csv.find("receiver")),
      amplitude(csv.find("amplitude_v")),
      level(csv.find("level_dbm")),
      temperature(csv.find("temperature_degC")),
      received(csv.find("received_s")) {}

double amplitude_of_level(double level_dbm) { return std::sqrt(0.05 * std::pow(10.0, level_dbm / 10.0)); }

void TofRefusals::add(Refusal refusal, int line, std::string_view text) {
  const auto kind = static_cast<std::size_t>(refusal);
  CountOfKind& count = counts_[kind];
  if (count.count++ == 0) {
    count.first_line = line;
    if (refusal != Refusal::kEmpty && !text.empty())
      count.first_text = fmt::format(" ({})", text.substr(0, 24));
  }
  rows_.push_back({line, kReasons[kind]});
}

std::vector<RejectedRow> TofRefusals::take() {
  std::ranges::stable_sort(rows_, {}, &RejectedRow::line);
  return std::exchange(rows_, {});
}

void TofRefusals::warn(const std::string& file, std::vector<std::string>& warnings) const {
  for (std::size_t kind = 1; kind < counts_.size(); ++kind) {
    const CountOfKind& c = counts_[kind];
    if (c.count == 0) continue;
    warnings.push_back(fmt::format("{}:{}: {}{}; {} arrival{} rejected for this reason", file, c.first_line,
                                   kReasons[kind], c.first_text, c.count, c.count == 1 ? "" : "s"));
  }
}

bool read_tof_row(CsvReader& csv, const TofColumns& columns, const NameLookup& names, OrderWatch& order,
                  Arrival& arrival) {
  if (!csv.number_or_nan(columns.tof, arrival.tof_s)) return false;
  if (!csv.number(columns.time, arrival.time_s) || !order.time(csv, arrival.time_s)) return false;
  if (!names.beacon(csv, columns.beacon, arrival.beacon)) return false;
  if (!names.vehicle(csv, columns.vehicle, arrival.vehicle)) return false;
  if (!names.receiver(csv, columns.receiver, arrival.vehicle, arrival.receiver)) return false;
  if (columns.epoch >= 0) {
    if (!csv.integer(columns.epoch, arrival.epoch) || !order.epoch(csv, arrival.vehicle, arrival.epoch))
      return false;
  }
  if (!read_amplitude(csv, columns, arrival.amplitude_v)) return false;
  if (columns.temperature >= 0 && !read_temperature(csv, columns.temperature, arrival.temperature_degC))
    return false;
  double received_s = std::numeric_limits<double>::quiet_NaN();
  if (columns.received >= 0 && !csv.number_or_nan(columns.received, received_s)) return false;
  arrival.received_after_s = reception_delay_s(arrival.time_s, received_s);
  arrival.line = csv.line();
  return true;
}

}  // namespace octant::io
