// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_ids.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>

#include "io/run/last_row.h"
#include "io/run/run_files.h"
#include "io/text/csv.h"
#include "io/text/open_file.h"

namespace octant::io {
namespace {

constexpr std::size_t kMostNames = 10'000;

/// Compares names; numbers within them are compared by value.
struct NaturalOrder {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const {
    while (!a.empty() && !b.empty()) {
      const std::size_t da = digits(a), db = digits(b);
      if (da > 0 && db > 0) {
        const std::string_view na = without_zeros(a.substr(0, da)), nb = without_zeros(b.substr(0, db));
        if (na.size() != nb.size()) return na.size() < nb.size();
        if (na != nb) return na < nb;
        a.remove_prefix(da), b.remove_prefix(db);
        continue;
      }
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1), b.remove_prefix(1);
    }
    return a.size() < b.size();
  }

 private:
  static std::size_t digits(std::string_view text) {
    return std::min(text.find_first_not_of("0123456789"), text.size());
  }
  static std::string_view without_zeros(std::string_view number) {
    return number.substr(std::min(number.find_first_not_of('0'), number.size() - 1));
  }
};

/// Compares names as NaturalOrder, and by their text if they differ only in leading zeros.
struct NameOrder {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const {
    const NaturalOrder natural;
    return natural(a, b) || (!natural(b, a) && a < b);
  }
};
using NameSet = std::set<std::string, NameOrder>;

class IdReader {
 public:
  explicit IdReader(const std::string& folder) : folder_(folder) {}

  Result<RunIds> read() {
    if (auto there = check_run_folder(folder_); !there) return fail(there.error());
    for (const auto& [name, what] : {std::pair{"tof.csv", "beacon"}, {"bearings.csv", "reflector"}})
      if (auto ok = read_file_of(name, what); !ok) return fail(ok.error());
    if (files_ == 0)
      return fail({.file = folder_,
                   .found = "the folder holds neither tof.csv nor bearings.csv",
                   .expected = "a run folder with at least one of them",
                   .advice = advice_where_no_run_is(folder_)});
    if (beacons_.empty())
      return fail({.file = folder_, .found = "no row names a beacon", .expected = "a recording of some"});
    ids_.beacons.assign(beacons_.begin(), beacons_.end());
    for (const auto& [name, receivers] : vehicles_)
      ids_.vehicles.push_back({name, {receivers.begin(), receivers.end()}});
    return std::move(ids_);
  }

 private:
  Result<void> read_file_of(const std::string& name, std::string_view what) {
    const std::string path = folder_ + "/" + name;
    if (!std::filesystem::exists(path)) return {};
    ++files_;
    const auto map = MappedFile::open(path);
    if (!map) return fail(map.error());
    CsvReader csv(without_cut_row(map->text(), path, ids_.warnings), path);
    const int beacon = csv.require(what), vehicle = csv.find("vehicle"), receiver = csv.find("receiver");
    ids_.has_epochs = csv.find("epoch") >= 0 || ids_.has_epochs;
    ids_.has_amplitudes = csv.find("amplitude_v") >= 0 || csv.find("level_dbm") >= 0 || ids_.has_amplitudes;
    while (csv.next_row()) {
      if (const std::string_view id = csv.field(beacon); !id.empty() && beacons_.find(id) == beacons_.end())
        beacons_.emplace(id);
      const std::string_view who = csv.field(vehicle).empty() ? "robot" : csv.field(vehicle);
      auto found = vehicles_.find(who);
      if (found == vehicles_.end()) found = vehicles_.emplace(who, NameSet()).first;
      if (const std::string_view id = csv.field(receiver);
          !id.empty() && found->second.find(id) == found->second.end())
        found->second.emplace(id);
      if (beacons_.size() + vehicles_.size() + found->second.size() > kMostNames)
        csv.fail_at(-1, fmt::format("more than {} names of beacons, vehicles and receivers", kMostNames),
                    "fewer");
    }
    return csv.error() ? fail(*csv.error()) : Result<void>();
  }

  std::string folder_;
  RunIds ids_;
  int files_ = 0;
  NameSet beacons_;
  std::map<std::string, NameSet, NameOrder> vehicles_;
};

}  // namespace

Result<RunIds> read_run_ids(const std::string& folder) { return IdReader(folder).read(); }

}  // namespace octant::io
