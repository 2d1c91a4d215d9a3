// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/vendor_logs.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "io/import/decoded_text.h"
#include "io/import/kit_lines.h"
#include "io/import/linktrack.h"
#include "io/import/mapping_words.h"
#include "io/run/last_row.h"
#include "io/text/csv.h"
#include "io/text/text.h"
#include "io/text/time_text.h"

namespace octant::io {
namespace {

constexpr int kAnchors = 8;  ///< anchors of the Crazyflie's two-way ranging

/// Collects the rows of a log; counts ignored beacons and rows without a measurement.
class VendorRows {
 public:
  VendorRows(const std::string& path, const VendorLogOptions& options) : options_(options) {
    log.path = path;
  }

  /// Returns false if there are too many names.
  bool add(double time_s, std::string_view beacon, double distance_m, std::string_view receiver = {}) {
    if (is_ignored(options_.ignore, beacon)) {
      ++log.ignored[std::string(beacon)];
      return true;
    }
    if (!(distance_m > 0.0)) return ++log.not_heard, true;
    ImportedArrival a;
    a.time_s = time_s;
    a.value = distance_m;
    a.is_distance = true;
    a.beacon = log.names.number_of(beacon);
    if (!receiver.empty()) a.receiver = log.names.number_of(receiver);
    log.arrivals.push_back(a);
    return a.beacon >= 0 && (receiver.empty() || a.receiver >= 0);
  }
  [[nodiscard]] Error error(int line, std::string found, std::string expected,
                            std::string advice = "") const {
    return {.file = log.path,
            .line = line,
            .found = std::move(found),
            .expected = std::move(expected),
            .advice = std::move(advice)};
  }
  [[nodiscard]] Error too_many_names(int line) const {
    return error(line, fmt::format("more than {} names", kMostImportedNames),
                 "as many as there may be at a site");
  }

  ImportedLog log;

 private:
  const VendorLogOptions& options_;
};

/// Calls row(line, number) for each line that is not blank, until one gives an error.
template <class Row>
Result<void> for_each_line(const std::string& path, const Row& row) {
  const auto decoded = DecodedText::open(path);
  if (!decoded) return fail(decoded.error());
  std::string_view text = decoded->text();
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = without_blanks(take_line(text));
    if (line.empty()) continue;
    if (auto taken = row(line, number); !taken) return taken;
  }
  return {};
}

/// A time as terminals write it before a line, with brackets and separators around it.
std::optional<double> written_time_s(std::string_view text) {
  constexpr std::string_view kAround = " \t[]()<>,;|:->";
  const auto first = text.find_first_not_of(kAround);
  if (first == std::string_view::npos) return std::nullopt;
  const auto time_s = time_of_text(text.substr(first, text.find_last_not_of(kAround) - first + 1));
  return time_s ? std::optional(seconds_of_stamp(*time_s)) : std::nullopt;
}

/// Lines that a module writes to a terminal, each with a time before it, of its own, or at equal intervals.
class KitLineReader {
 public:
  KitLineReader(VendorRows& rows, const VendorLogOptions& options, KitLineParser parser)
      : rows_(rows), options_(options), parser_(parser) {}

  Result<void> line(std::string_view text, int number) {
    const auto line = parser_(text);
    if (!line) return {};
    const auto time_s = time_of(*line, text.substr(0, line->begin), number);
    if (!time_s) return fail(time_s.error());
    garbled_ += line->garbled;
    for (const KitRange& range : line->ranges)
      if (!rows_.add(*time_s, range.beacon, range.distance_m, range.receiver))
        return fail(rows_.too_many_names(number));
    ++lines_;
    return {};
  }

  [[nodiscard]] std::size_t lines() const { return lines_; }
  [[nodiscard]] std::size_t garbled() const { return garbled_; }

 private:
  Result<double> time_of(const KitLine& line, std::string_view before, int number) {
    if (options_.period_s) return *options_.period_s * static_cast<double>(lines_);
    const auto written = written_time_s(before);
    if (written) return *written;
    if (line.time_s) return *line.time_s;
    return fail(rows_.error(number,
                            before.empty() ? "a line without a time" : "no time in " + in_quotes(before),
                            "seconds, yyyy-mm-dd hh:mm:ss or hh:mm:ss before what the module said",
                            "log with time stamps, or say how far lines are apart: --period-s 0.1"));
  }

  VendorRows& rows_;
  const VendorLogOptions& options_;
  KitLineParser parser_;
  std::size_t lines_ = 0, garbled_ = 0;
};

}  // namespace

Result<ImportedLog> read_marvelmind_log(const std::string& path, const VendorLogOptions& options) {
  VendorRows rows(path, options);
  const auto row = [&rows](std::string_view line, int number) -> Result<void> {
    while (line.ends_with(',')) line = without_blanks(line.substr(0, line.size() - 1));
    const auto fields = fields_at(line, ',');
    // With the UNIX time there are seven fields before the pairs, without it six.
    const std::size_t head = fields.size() % 2 == 1 ? 7 : 6;
    if (fields.size() < head)
      return fail(rows.error(number, fmt::format("{} fields", fields.size()),
                             "times, hedgehog, x, y, z, then address and distance of each beacon",
                             "is this a Marvelmind dashboard's log of raw distances?"));
    double time_ms = 0.0;
    if (const std::string_view time = fields[head == 7 ? 0 : 1]; !logged_number(time, time_ms))
      return fail(rows.error(number, in_quotes(time), "a time in milliseconds"));
    for (std::size_t i = head; i + 1 < fields.size(); i += 2) {
      double distance_m = 0.0;
      if (!fields[i + 1].empty() && !logged_number(fields[i + 1], distance_m))
        return fail(rows.error(number, in_quotes(fields[i + 1]), "a distance in metres"));
      if (fields[i].empty()) continue;
      if (!rows.add(time_ms * 1e-3, fields[i], distance_m, fields[head - 4]))
        return fail(rows.too_many_names(number));
    }
    return {};
  };
  if (auto read = for_each_line(path, row); !read) return fail(read.error());
  remove_only_receiver(rows.log);
  return std::move(rows.log);
}

Result<ImportedLog> read_crazyflie_log(const std::string& path, const VendorLogOptions& options) {
  const auto text = DecodedText::open(path);
  if (!text) return fail(text.error());
  VendorRows rows(path, options);
  CsvReader csv(without_cut_row(text->text(), path, rows.log.warnings), path);
  const int upper = csv.find("Timestamp"), time = upper >= 0 ? upper : csv.require("timestamp");
  const int state = csv.find("ranging.state");
  int distance[kAnchors];
  bool any = false;
  for (int i = 0; i < kAnchors; ++i) {
    distance[i] = csv.find(fmt::format("ranging.distance{}", i));
    any = any || distance[i] >= 0;
  }
  if (!any && !csv.error()) {
    const bool differences =
        std::ranges::any_of(csv.header(), [](const std::string& name) { return name.starts_with("tdoa"); });
    return fail(rows.error(1, "no column ranging.distance0 to ranging.distance7",
                           "the distances of two-way ranging",
                           differences ? "time differences (tdoa) are no distances: set the anchors to TWR"
                                       : "log the variables of the group 'ranging'"));
  }
  double last[kAnchors] = {};
  std::size_t repeated = 0;
  while (csv.next_row()) {
    double time_ms = 0.0;
    std::int64_t heard = -1;
    if (!csv.number(time, time_ms) || (state >= 0 && !csv.integer(state, heard))) break;
    for (int i = 0; i < kAnchors; ++i) {
      double d = 0.0;
      if (distance[i] < 0) continue;
      if (!csv.number_or_nan(distance[i], d)) break;
      const bool fresh = d != last[i];
      last[i] = d;
      if (!fresh && d > 0) {
        ++repeated;
      } else {
        (void)rows.add(time_ms * 1e-3, fmt::format("{}", i),
                       (heard >> i & 1) != 0 && std::isfinite(d) ? d : 0.0);
      }
    }
    if (csv.error()) break;
  }
  if (csv.error()) return fail(*csv.error());
  if (repeated > 0)
    rows.log.warnings.push_back(fmt::format(
        "{}: {} distances that are exactly the ones before are left out as repeated", path, repeated));
  return std::move(rows.log);
}

namespace {

/// A kit whose modules write lines.
struct LineKit {
  std::string_view name;
  std::vector<KitLineParser> parsers;  ///< the first one that fits a line is used for all lines
  const char *missing, *example;
};

const std::vector<LineKit>& line_kits() {
  static const std::vector<LineKit> all = {
      {"dwm1001",
       {dwm1001_line},
       "no line that a DWM1001 says to les or lec",
       "DIST,4,AN0,1151,... or 1151[5.00,8.00,2.25]=6.48 ..."},
      {"trek1000",
       {trek1000_line, trek1000_raw_line},
       "no line with ranges of a TREK1000",
       "mc 0f 00000663 000005a3 00000512 000004cb 095f c1 00024c24 a0:0"},
      {"makerfabs",
       {makerfabs_line},
       "no line with ranges of a Makerfabs module",
       "{\"links\":[{\"A\":\"1782\",\"R\":\"1.03\"}]} or AT+RANGE=tid:0,..."},
      {"pozyx", {pozyx_line}, "no line with a range of a Pozyx", "1523 ms, 2345 mm, -80 dBm"}};
  return all;
}

Result<ImportedLog> read_lines(const LineKit& kit, const std::string& path, const VendorLogOptions& options) {
  for (const KitLineParser parser : kit.parsers) {
    VendorRows rows(path, options);
    KitLineReader reader(rows, options, parser);
    const auto row = [&reader](std::string_view line, int number) { return reader.line(line, number); };
    if (auto read = for_each_line(path, row); !read) return fail(read.error());
    if (reader.lines() == 0) continue;
    if (reader.garbled() > 0)
      rows.log.warnings.push_back(
          fmt::format("{}: {} garbled groups of an anchor are left out", path, reader.garbled()));
    remove_only_receiver(rows.log);
    return std::move(rows.log);
  }
  return fail({.file = path, .found = kit.missing, .expected = kit.example});
}

const LineKit* line_kit(std::string_view name) {
  const auto kit = std::ranges::find(line_kits(), name, &LineKit::name);
  return kit == line_kits().end() ? nullptr : &*kit;
}

/// True for the columns of a Marvelmind dashboard's log: whole times, then the hedgehog, its position, and
/// pairs of the address of a beacon and a distance.
bool is_marvelmind_line(std::string_view line) {
  constexpr double kLargestAddress = 255.0;
  while (line.ends_with(',')) line = without_blanks(line.substr(0, line.size() - 1));
  const auto fields = fields_at(line, ',');
  const std::size_t head = fields.size() % 2 == 1 ? 7 : 6;
  if (fields.size() < head + 4) return false;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    double value = 0.0;
    const bool is_address = i == head - 4 || (i >= head && (i - head) % 2 == 0);
    if (!logged_number(fields[i], value)) return false;
    if ((is_address || i < head - 4) && value != std::floor(value)) return false;
    if (is_address && (value < 1.0 || value > kLargestAddress)) return false;
  }
  return true;
}

}  // namespace

Result<ImportedLog> read_dwm1001_log(const std::string& path, const VendorLogOptions& options) {
  return read_kit_log("dwm1001", path, options);
}

Result<ImportedLog> read_kit_log(std::string_view kit, const std::string& path,
                                 const VendorLogOptions& options) {
  if (const LineKit* lines = line_kit(kit)) return read_lines(*lines, path, options);
  if (kit == "marvelmind") return read_marvelmind_log(path, options);
  if (kit == "linktrack") return read_linktrack_log(path, options);
  return read_crazyflie_log(path, options);
}

std::string kit_of(const std::string& path) {
  constexpr std::size_t kLines = 200, kLeastMarvelmind = 2;
  if (is_linktrack_log(path)) return "linktrack";
  const auto decoded = DecodedText::open(path);
  if (!decoded) return "";
  std::string_view text = decoded->text();
  std::size_t marvelmind = 0, others = 0;
  for (std::size_t i = 0; i < kLines && !text.empty(); ++i) {
    const std::string_view line = without_blanks(take_line(text));
    if (line.empty()) continue;
    if (line.find("ranging.distance") != std::string_view::npos ||
        line.find("ranging.state") != std::string_view::npos)
      return "crazyflie";
    for (const LineKit& kit : line_kits())
      for (const KitLineParser parser : kit.parsers)
        if (const auto read = parser(line); read && !read->ranges.empty()) return std::string(kit.name);
    ++(is_marvelmind_line(line) ? marvelmind : others);
  }
  return others == 0 && marvelmind >= kLeastMarvelmind ? "marvelmind" : "";
}

}  // namespace octant::io
