// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <fmt/format.h>

#include "io/tof/run_parts.h"

namespace octant::io {

NameLookup::NameLookup(const NameTable& names) : names_(names), receivers_(names.vehicles.size()) {
  beacons_ = NameIndex({names.beacons.begin(), names.beacons.end()});
  vehicles_ = NameIndex({names.vehicles.begin(), names.vehicles.end()});
  std::vector<std::vector<std::string_view>> of_vehicle(names.vehicles.size());
  for (std::size_t i = 0; i < names.receivers.size(); ++i) {
    const std::size_t of = names.receivers[i].vehicle.index();
    of_vehicle[of].push_back(names.receivers[i].name);
    receivers_[of].ids.emplace_back(i);
  }
  for (std::size_t v = 0; v < receivers_.size(); ++v) {
    receivers_[v].names = NameIndex(of_vehicle[v]);
    if (receivers_[v].ids.size() == 1) receivers_[v].only = receivers_[v].ids.front();
  }
  default_vehicle = names.vehicles.size() == 1 ? VehicleId(0) : VehicleId(vehicles_.find("robot"));
}

bool NameLookup::beacon(CsvReader& csv, int column, BeaconId& id) const {
  const std::string_view name = csv.field(column);
  id = beacon(name);
  if (id.valid()) return true;
  if (name.empty())
    return csv.fail_at(column, csv.header()[static_cast<std::size_t>(column)] + " is empty", "a beacon's id");
  const std::string others = other_unknown_beacons(csv, column);
  const std::string hint = suggestion(name, names_.beacons);
  return csv.fail_at(
      column, fmt::format("beacon {} is not in the site{}", in_quotes(name), others), "a beacon's id",
      hint +
          (hint.empty()          ? ""
           : hint.ends_with('?') ? " Or "
                                 : "; or ") +
          (csv.file().ends_with("beacon_tof.csv")
               ? "add it to the site's beacons, or delete its rows"
               : fmt::format("add it to the site's beacons; octant convert {} --ignore {} -o RUN leaves a "
                             "neighbour's out",
                             csv.file(), in_quotes(name))));
}

/// Other names in the column that are missing in the site, so that all can be corrected at once.
std::string NameLookup::other_unknown_beacons(const CsvReader& csv, int column) const {
  constexpr std::size_t kMost = 12;
  CsvReader rest = csv;
  const std::string first(csv.field(column));
  std::vector<std::string> unknown;
  while (unknown.size() <= kMost && rest.next_row()) {
    const std::string name(rest.field(column));
    if (name.empty() || name == first || beacon(name).valid() ||
        std::ranges::find(unknown, name) != unknown.end())
      continue;
    unknown.push_back(name);
  }
  return unknown.empty()
             ? ""
             : fmt::format(", nor {} {}", unknown.size() == 1 ? "is" : "are", listed(unknown, kMost));
}

bool NameLookup::vehicle(CsvReader& csv, int column, VehicleId& id) const {
  const std::string_view name = csv.field(column);
  id = vehicle(name);
  if (id.valid()) return true;
  if (name.empty()) {
    return csv.fail_at(column,
                       fmt::format("the row names no vehicle, and the site has {}", names_.vehicles.size()),
                       "a vehicle's id", "add a column 'vehicle', or 'vehicle: ...' in run.yaml");
  }
  return csv.fail_at(column, fmt::format("vehicle {} is not in the site", in_quotes(name)), "a vehicle's id",
                     suggestion(name, names_.vehicles));
}

bool NameLookup::receiver(CsvReader& csv, int column, VehicleId vehicle, ReceiverId& id) const {
  const std::string_view name = csv.field(column);
  id = receiver(vehicle, name);
  if (id.valid()) return true;
  const std::string on = in_quotes(names_.vehicles[vehicle.index()]);
  if (name.empty()) {
    const bool none = receivers_[vehicle.index()].ids.empty();
    return csv.fail_at(column,
                       fmt::format("the row names no receiver, and vehicle {} has {}", on,
                                   receivers_[vehicle.index()].ids.size()),
                       "a receiver's id",
                       none ? "list its receivers in the site file" : "add a column 'receiver'");
  }
  std::vector<std::string> candidates;
  for (const auto& r : names_.receivers) {
    if (r.vehicle == vehicle) candidates.push_back(r.name);
  }
  return csv.fail_at(column, fmt::format("receiver {} is not on vehicle {}", in_quotes(name), on),
                     "a receiver's id", suggestion(name, candidates));
}

}  // namespace octant::io
