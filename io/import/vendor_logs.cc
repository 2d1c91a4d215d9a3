// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/vendor_logs.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "io/import/mapping_words.h"
#include "io/run/last_row.h"
#include "io/text/bounds.h"
#include "io/text/csv.h"
#include "io/text/open_file.h"
#include "io/text/text.h"
#include "io/text/time_text.h"

namespace octant::io {
namespace {

constexpr std::size_t kMostFields = 4096;  ///< bytes of a line
constexpr int kAnchors = 8;                ///< anchors of the Crazyflie's two-way ranging

std::vector<std::string_view> fields_at(std::string_view line, char delimiter) {
  std::vector<std::string_view> fields;
  while (fields.size() < kMostFields) {
    const std::size_t end = line.find(delimiter);
    fields.push_back(without_blanks(line.substr(0, end)));
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  return fields;
}

bool logged_number(std::string_view text, double& value) {
  return parse_number(text, value) == NumberText::kNumber && std::isfinite(value);
}

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
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  if (auto fit = check_lines(map->text(), path); !fit) return fit;
  std::string_view text = without_bom(map->text());
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = without_blanks(take_line(text));
    if (line.empty()) continue;
    if (auto taken = row(line, number); !taken) return taken;
  }
  return {};
}

// --- DWM1001

/// A time as terminals write it before a line, with brackets and separators around it.
std::optional<double> written_time_s(std::string_view text) {
  constexpr std::string_view kAround = " \t[]()<>,;|:->";
  const auto first = text.find_first_not_of(kAround);
  if (first == std::string_view::npos) return std::nullopt;
  const auto time_s = time_of_text(text.substr(first, text.find_last_not_of(kAround) - first + 1));
  return time_s ? std::optional(seconds_of_stamp(*time_s)) : std::nullopt;
}

bool is_address(std::string_view text) {
  return text.size() >= 4 && text.size() <= 16 &&
         std::ranges::all_of(text, [](unsigned char c) { return std::isxdigit(c) != 0; });
}

struct Dwm1001Group {
  std::string_view anchor;
  double distance_m = 0.0;
};

/// AN0,1151,5.00,8.00,2.25,6.44,AN1,...
std::size_t groups_of_lec(std::string_view payload, std::vector<Dwm1001Group>& groups) {
  const auto fields = fields_at(payload, ',');
  std::size_t garbled = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!fields[i].starts_with("AN")) continue;
    double number = 0.0;
    bool whole = i + 5 < fields.size() && is_address(fields[i + 1]);
    for (std::size_t k = 2; whole && k <= 5; ++k) whole = logged_number(fields[i + k], number);
    if (!whole) {
      ++garbled;
      continue;
    }
    groups.push_back({fields[i + 1], number});
    i += 5;
  }
  return garbled;
}

/// 1151[5.00,8.00,2.25]=6.48 0CA8[...]=... le_us=2576 est[...]
std::size_t groups_of_les(std::string_view payload, std::vector<Dwm1001Group>& groups) {
  std::size_t garbled = 0;
  for (const std::string_view word : fields_at(payload, ' ')) {
    const std::size_t open = word.find('['), equals = word.find("]=");
    if (open == std::string_view::npos || word.starts_with("est[")) continue;
    double distance_m = 0.0;
    if (equals == std::string_view::npos || !is_address(word.substr(0, open)) ||
        !logged_number(word.substr(equals + 2), distance_m)) {
      ++garbled;
    } else {
      groups.push_back({word.substr(0, open), distance_m});
    }
  }
  return garbled;
}

/// Position in a line at which the output of the module begins; npos: the line is neither of the two kinds.
std::size_t begin_of_payload(std::string_view line) {
  if (const std::size_t lec = line.find("DIST,"); lec != std::string_view::npos) return lec;
  const std::size_t group = line.find("]=");
  if (group == std::string_view::npos) return group;
  const std::size_t open = line.rfind('[', group);
  if (open == std::string_view::npos) return open;
  std::size_t begin = open;
  while (begin > 0 && std::isxdigit(static_cast<unsigned char>(line[begin - 1])) != 0) --begin;
  return begin;
}

class Dwm1001Reader {
 public:
  Dwm1001Reader(VendorRows& rows, const VendorLogOptions& options) : rows_(rows), options_(options) {}

  Result<void> line(std::string_view line, int number) {
    const std::size_t begin = begin_of_payload(line);
    if (begin == std::string_view::npos) return {};
    const auto time_s = time_of(line.substr(0, begin), number);
    if (!time_s) return fail(time_s.error());
    std::vector<Dwm1001Group> groups;
    const std::string_view payload = line.substr(begin);
    garbled_ +=
        payload.starts_with("DIST,") ? groups_of_lec(payload, groups) : groups_of_les(payload, groups);
    for (const Dwm1001Group& g : groups)
      if (!rows_.add(*time_s, g.anchor, g.distance_m)) return fail(rows_.too_many_names(number));
    ++lines_;
    return {};
  }

  [[nodiscard]] std::size_t lines() const { return lines_; }
  [[nodiscard]] std::size_t garbled() const { return garbled_; }

 private:
  Result<double> time_of(std::string_view before, int number) {
    if (options_.period_s) return *options_.period_s * static_cast<double>(lines_);
    const auto written = written_time_s(before);
    if (!written)
      return fail(rows_.error(number,
                              before.empty() ? "a line without a time" : "no time in " + in_quotes(before),
                              "seconds, yyyy-mm-dd hh:mm:ss or hh:mm:ss before what the module said",
                              "log with time stamps, or say how far lines are apart: --period-s 0.1"));
    return *written;
  }

  VendorRows& rows_;
  const VendorLogOptions& options_;
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
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  VendorRows rows(path, options);
  CsvReader csv(without_cut_row(map->text(), path, rows.log.warnings), path);
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

Result<ImportedLog> read_dwm1001_log(const std::string& path, const VendorLogOptions& options) {
  VendorRows rows(path, options);
  Dwm1001Reader reader(rows, options);
  const auto row = [&reader](std::string_view line, int number) { return reader.line(line, number); };
  if (auto read = for_each_line(path, row); !read) return fail(read.error());
  if (reader.lines() == 0)
    return fail(rows.error(0, "no line that a DWM1001 says to les or lec",
                           "DIST,4,AN0,1151,... or 1151[5.00,8.00,2.25]=6.48 ..."));
  if (reader.garbled() > 0)
    rows.log.warnings.push_back(
        fmt::format("{}: {} garbled groups of an anchor are left out", path, reader.garbled()));
  return std::move(rows.log);
}

}  // namespace octant::io
