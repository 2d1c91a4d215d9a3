// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/clocks/clock_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "io/clocks/counter.h"
#include "io/text/atomic_file.h"
#include "io/text/bounds.h"
#include "io/text/open_file.h"
#include "io/tof/run_parts.h"

namespace octant::io {
namespace {

/// Time after which a sequence number may be used again [s].
constexpr double kSameSequence_s = 1.0;

/// Rows that are no measurement.
struct Skipped {
  std::size_t count = 0;
  std::string first;
  void add(const CsvReader& csv) {
    if (count++ == 0) first = csv.place();
  }
  void report(const char* column, std::vector<std::string>& warnings) const {
    if (count > 0)
      warnings.push_back(fmt::format("{}: {} is not a number; {} row{} left out", first, column, count,
                                     count == 1 ? "" : "s"));
  }
};

/// Column `epoch`, or `event`.
int epoch_column(CsvReader& csv) {
  const int epoch = csv.find("epoch"), event = csv.find("event");
  return epoch >= 0 ? epoch : event;
}

Result<void> finish_clock_file(const CsvReader& csv, ClockLog& log) {
  if (csv.error()) return fail(*csv.error());
  if (const auto warning = csv.unknown_columns()) log.warnings.push_back(*warning);
  return {};
}

Result<void> parse_differences(std::string_view text, const std::string& file, const NameLookup& names,
                               ClockLog& log) {
  CsvReader csv(text, file);
  const int time = csv.require("time_s"), a = csv.require("beacon_a"), b = csv.require("beacon_b"),
            tdoa = csv.require("tdoa_s");
  const int vehicle = csv.find("vehicle"), receiver = csv.find("receiver"), epoch = epoch_column(csv);
  Skipped skipped;
  while (csv.next_row()) {
    TimeDifference row;
    row.line = csv.line();
    if (!csv.number(time, row.time_s) || !names.beacon(csv, a, row.a) || !names.beacon(csv, b, row.b) ||
        !csv.number_or_nan(tdoa, row.tdoa_s) || !names.vehicle(csv, vehicle, row.vehicle) ||
        !names.receiver(csv, receiver, row.vehicle, row.receiver) ||
        (epoch >= 0 && !csv.integer(epoch, row.epoch)))
      break;
    if (row.a == row.b) {
      csv.fail_at(b, "a time difference of a beacon with itself", "two beacons");
      break;
    }
    if (std::isfinite(row.tdoa_s))
      log.differences.push_back(row);
    else
      skipped.add(csv);
  }
  skipped.report("tdoa_s", log.warnings);
  return finish_clock_file(csv, log);
}

/// A row of toa.csv.
struct Stamp {
  double time_s = 0.0, toa_s = 0.0;
  DeviceId transmitter, receiver;
  std::int64_t sequence = 0, epoch = kNoEpoch;
};

/// Reads the name of a device: a beacon, "vehicle/receiver", or a vehicle or receiver with a unique name.
bool read_device(CsvReader& csv, int column, const NameLookup& names, DeviceId& id) {
  const std::string_view name = csv.field(column);
  const NameTable& table = names.names();
  if (const BeaconId beacon = names.beacon(name); beacon.valid()) return id = device_of(beacon), true;
  for (std::size_t r = 0; r < table.receivers.size(); ++r) {
    const auto& receiver = table.receivers[r];
    const std::string& vehicle = table.vehicles[receiver.vehicle.index()];
    if (name == receiver.name || name == vehicle || name == vehicle + "/" + receiver.name)
      return id = device_of(ReceiverId(r), table.beacons.size()), true;
  }
  return csv.fail_at(column, fmt::format("unknown device {}", in_quotes(std::string(name))),
                     "a beacon, a vehicle, or vehicle/receiver of the site file",
                     suggestion(name, table.beacons));
}

/// Period of the counters, if they begin again: some time stamp of a receiver decreases while the time of the
/// log does not.
double counter_period_s(const std::vector<Stamp>& stamps) {
  double largest_s = 0.0;
  bool decreases = false;
  std::map<DeviceId, Stamp> last;
  for (const Stamp& s : stamps) {
    largest_s = std::max(largest_s, s.toa_s);
    const auto [it, is_first] = last.try_emplace(s.receiver, s);
    decreases = decreases || (!is_first && s.time_s > it->second.time_s && s.toa_s < it->second.toa_s);
    it->second = s;
  }
  if (!decreases) return 0.0;
  for (const double period_s : kCounterPeriods_s)
    if (largest_s < period_s) return period_s;
  return 0.0;
}

void add_transmissions(std::vector<Stamp> stamps, ClockLog& log, const std::string& file) {
  std::ranges::stable_sort(stamps, {}, &Stamp::time_s);
  const double period_s = counter_period_s(stamps);
  std::map<DeviceId, Counter> counters;
  std::map<std::pair<DeviceId, std::int64_t>, std::size_t> open;
  for (const Stamp& s : stamps) {
    const double toa_s = counters[s.receiver].continued_s(s.toa_s, s.time_s, period_s);
    const auto [it, is_new] = open.try_emplace({s.transmitter, s.sequence}, log.transmissions.size());
    const auto repeats = [&](const Transmission& t) {
      return s.time_s - t.time_s > kSameSequence_s ||
             std::ranges::find(t.receptions, s.receiver, &TimeStamp::device) != t.receptions.end();
    };
    if (is_new || repeats(log.transmissions[it->second])) {
      it->second = log.transmissions.size();
      log.transmissions.push_back({s.time_s, s.epoch, s.transmitter, {}, false});
    }
    Transmission& t = log.transmissions[it->second];
    // Relative to the beginning of the log, because times since 1970 leave no digits for nanoseconds.
    t.receptions.push_back({s.receiver, toa_s - (t.time_s - stamps.front().time_s)});
  }
  std::size_t wraps = 0;
  for (const auto& [device, counter] : counters) wraps += counter.wraps();
  if (wraps > 0)
    log.warnings.push_back(
        fmt::format("{}: the counters begin again every {:.4g} s; {} such ends of a period are continued",
                    file, period_s, wraps));
}

Result<void> parse_stamps(std::string_view text, const std::string& file, const NameLookup& names,
                          ClockLog& log) {
  CsvReader csv(text, file);
  const int time = csv.require("time_s"), transmitter = csv.require("transmitter"),
            receiver = csv.require("receiver"), toa = csv.require("toa_s"),
            sequence = csv.require("sequence");
  const int epoch = epoch_column(csv);
  std::vector<Stamp> stamps;
  Skipped skipped;
  while (csv.next_row()) {
    Stamp row;
    if (!csv.number(time, row.time_s) || !read_device(csv, transmitter, names, row.transmitter) ||
        !read_device(csv, receiver, names, row.receiver) || !csv.number_or_nan(toa, row.toa_s) ||
        !csv.integer(sequence, row.sequence) || (epoch >= 0 && !csv.integer(epoch, row.epoch)))
      break;
    if (std::isfinite(row.toa_s))
      stamps.push_back(row);
    else
      skipped.add(csv);
  }
  skipped.report("toa_s", log.warnings);
  if (!csv.error()) add_transmissions(std::move(stamps), log, file);
  return finish_clock_file(csv, log);
}

Result<void> parse_displacements(std::string_view text, const std::string& file, const NameLookup& /*names*/,
                                 ClockLog& log) {
  CsvReader csv(text, file);
  const int from = csv.require("event_a"), to = csv.require("event_b"), dx = csv.require("dx_m"),
            dy = csv.require("dy_m"), dz = csv.find("dz_m");
  while (csv.next_row()) {
    Displacement row;
    if (!csv.integer(from, row.from) || !csv.integer(to, row.to) || !csv.length(dx, row.step_m.x()) ||
        !csv.length(dy, row.step_m.y()) || (dz >= 0 && !csv.length(dz, row.step_m.z())))
      break;
    log.displacements.push_back(row);
  }
  return finish_clock_file(csv, log);
}

using ParseClockFile = Result<void> (*)(std::string_view, const std::string&, const NameLookup&, ClockLog&);
constexpr std::array<std::pair<const char*, ParseClockFile>, 3> kClockFiles = {
    {{"tdoa.csv", parse_differences}, {"toa.csv", parse_stamps}, {"displacements.csv", parse_displacements}}};

}  // namespace

Result<ClockLog> read_clock_log(const std::string& folder, const NameTable& names,
                                std::vector<InputDigest>* inputs) {
  ClockLog log;
  const NameLookup lookup(names);
  for (const auto& [name, parse] : kClockFiles) {
    const std::string path = (std::filesystem::path(folder) / name).string();
    std::error_code status;
    if (!std::filesystem::exists(path, status)) continue;
    const auto map = MappedFile::open(path);
    if (!map) return fail(map.error());
    if (auto ok = check_lines(map->text(), path); !ok) return fail(ok.error());
    if (auto ok = parse(map->text(), path, lookup, log); !ok) return fail(ok.error());
    if (inputs != nullptr) inputs->push_back({path, sha256_hex(map->text())});
  }
  return log;
}

bool has_clock_log(const std::string& folder) {
  std::error_code status;
  const std::filesystem::path root(folder);
  return !std::filesystem::exists(root / "tof.csv", status) &&
         (std::filesystem::exists(root / "tdoa.csv", status) ||
          std::filesystem::exists(root / "toa.csv", status));
}

std::string differences_to_csv(const std::vector<TimeDifference>& rows, const NameTable& names) {
  const bool has_epochs = std::ranges::any_of(rows, [](const auto& r) { return r.epoch != kNoEpoch; });
  std::string text =
      has_epochs ? "time_s,epoch,beacon_a,beacon_b,tdoa_s\n" : "time_s,beacon_a,beacon_b,tdoa_s\n";
  for (const TimeDifference& r : rows)
    text += fmt::format("{}{},{},{},{}\n", exact(r.time_s), has_epochs ? fmt::format(",{}", r.epoch) : "",
                        csv_field(names.beacons[r.a.index()]), csv_field(names.beacons[r.b.index()]),
                        exact(r.tdoa_s));
  return text;
}

}  // namespace octant::io
