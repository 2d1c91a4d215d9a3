// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "io/run_parts.h"

namespace octant::io {
namespace {

struct TofColumns {
  int time, beacon, tof, epoch, vehicle, receiver, amplitude, level, temperature;
  explicit TofColumns(CsvReader& csv)
      : time(csv.require("time_s")),
        beacon(csv.require("beacon")),
        tof(csv.require("tof_s")),
        epoch(csv.find("epoch")),
        vehicle(csv.find("vehicle")),
        receiver(csv.find("receiver")),
        amplitude(csv.find("amplitude_v")),
        level(csv.find("level_dbm")),
        temperature(csv.find("temperature_degC")) {}
};

/// Effective voltage of a power into 50 ohm: V = sqrt(R P), P = 1 mW 10^(dBm / 10).
double amplitude_of_level(double level_dbm) { return std::sqrt(0.05 * std::pow(10.0, level_dbm / 10.0)); }

/// Amplitude of the row [V], NaN where none was logged. Level only where there is no amplitude.
bool read_amplitude(CsvReader& csv, const TofColumns& columns, double& amplitude_v) {
  if (columns.amplitude >= 0 && !csv.number_or_nan(columns.amplitude, amplitude_v)) return false;
  if (columns.level >= 0 && !(amplitude_v > 0.0)) {
    double level_dbm = 0.0;
    if (!csv.number_or_nan(columns.level, level_dbm)) return false;
    amplitude_v = amplitude_of_level(level_dbm);
  }
  if (!(amplitude_v > 0.0) || std::isinf(amplitude_v)) amplitude_v = std::numeric_limits<double>::quiet_NaN();
  return true;
}

bool read_temperature(CsvReader& csv, int column, double& temperature_degC) {
  if (!csv.number_or_nan(column, temperature_degC)) return false;
  if (std::isnan(temperature_degC) || std::abs(temperature_degC) <= 100.0) return true;
  return csv.fail_at(column, fmt::format("temperature_degC is {}", exact(temperature_degC)),
                     "degrees Celsius from -100 to 100 (20 degC are 293 K)");
}

enum class Refusal { kNone, kEmpty, kNotANumber, kNotPositive };
constexpr std::array<const char*, 4> kReasons = {"", "tof_s is empty", "tof_s is not a number", "tof_s is not positive"};

/// Negative times are legal where the receiver's clock has an unknown offset.
Refusal refusal_of(std::string_view text, double tof_s, Clock clock) {
  if (text.empty()) return Refusal::kEmpty;
  if (!std::isfinite(tof_s)) return Refusal::kNotANumber;
  return tof_s > 0.0 || clock == Clock::kCycleOffset ? Refusal::kNone : Refusal::kNotPositive;
}

/// Rows refused for one reason: the first one's place and how many.
struct RefusalCount {
  std::string first_place, first_text;
  std::size_t count = 0;
};

void warn_of_refusals(const std::array<RefusalCount, 4>& refusals, MeasurementLog& log) {
  for (std::size_t kind = 1; kind < refusals.size(); ++kind) {
    const RefusalCount& r = refusals[kind];
    if (r.count == 0) continue;
    log.warnings.push_back(fmt::format("{}: {}{}; {} arrival{} rejected for this reason", r.first_place, kReasons[kind],
                                       r.first_text, r.count, r.count == 1 ? "" : "s"));
  }
}

/// Everything of a row but tof_s.
bool read_arrival(CsvReader& csv, const TofColumns& columns, const NameLookup& names, OrderWatch& order, Arrival& arrival) {
  if (!csv.number(columns.time, arrival.time_s) || !order.time(csv, arrival.time_s)) return false;
  if (!names.beacon(csv, columns.beacon, arrival.beacon)) return false;
  if (!names.vehicle(csv, columns.vehicle, arrival.vehicle)) return false;
  if (!names.receiver(csv, columns.receiver, arrival.vehicle, arrival.receiver)) return false;
  if (columns.epoch >= 0) {
    if (!csv.integer(columns.epoch, arrival.epoch) || !order.epoch(csv, arrival.vehicle, arrival.epoch)) return false;
  }
  if (!read_amplitude(csv, columns, arrival.amplitude_v)) return false;
  if (columns.temperature >= 0 && !read_temperature(csv, columns.temperature, arrival.temperature_degC)) return false;
  arrival.line = csv.line();
  return true;
}

}  // namespace

Result<void> parse_tof(std::string_view text, const std::string& file, const NameLookup& names, Clock clock,
                       MeasurementLog& log) {
  CsvReader csv(text, file);
  csv.read_header();
  if (csv.error()) return fail(*csv.error());
  const TofColumns columns(csv);
  log.has_epochs = log.has_epochs || columns.epoch >= 0;
  OrderWatch order(names.names().vehicles.size(), columns.time, columns.epoch);
  std::array<RefusalCount, 4> refusals;
  log.arrivals.reserve(csv.rows_left_estimate());
  while (csv.next_row()) {
    ++log.rows;
    Arrival arrival;
    if (!csv.number_or_nan(columns.tof, arrival.tof_s) || !read_arrival(csv, columns, names, order, arrival)) break;
    const Refusal refusal = refusal_of(csv.field(columns.tof), arrival.tof_s, clock);
    if (refusal == Refusal::kNone) {
      log.arrivals.push_back(arrival);
      continue;
    }
    const auto kind = static_cast<std::size_t>(refusal);
    RefusalCount& count = refusals[kind];
    if (count.count++ == 0) {
      count.first_place = csv.place();
      if (refusal != Refusal::kEmpty) count.first_text = fmt::format(" ({})", csv.field(columns.tof).substr(0, 24));
    }
    log.rejected.push_back({arrival.line, kReasons[kind]});
  }
  if (csv.error()) return fail(*csv.error());
  if (const auto warning = csv.unknown_columns()) log.warnings.push_back(*warning);
  warn_of_refusals(refusals, log);
  return {};
}

}  // namespace octant::io
