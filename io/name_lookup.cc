// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include <fmt/format.h>

#include "io/run_parts.h"

namespace octant::io {

NameLookup::NameLookup(const NameTable& names)
    : names_(names), receivers_(names.vehicles.size()), only_receiver_(names.vehicles.size()) {
  for (std::size_t i = 0; i < names.beacons.size(); ++i) beacons_.emplace(names.beacons[i], BeaconId(i));
  for (std::size_t i = 0; i < names.vehicles.size(); ++i) vehicles_.emplace(names.vehicles[i], VehicleId(i));
  for (std::size_t i = 0; i < names.receivers.size(); ++i) {
    const std::size_t of = names.receivers[i].vehicle.index();
    receivers_[of].emplace(names.receivers[i].name, ReceiverId(i));
    only_receiver_[of] = receivers_[of].size() == 1 ? ReceiverId(i) : ReceiverId();
  }
  default_vehicle = names.vehicles.size() == 1 ? VehicleId(0) : vehicle("robot");
}

VehicleId NameLookup::vehicle(std::string_view name) const {
  const auto found = vehicles_.find(name);
  return found == vehicles_.end() ? VehicleId() : found->second;
}

bool NameLookup::beacon(CsvReader& csv, int column, BeaconId& id) const {
  const std::string_view name = csv.field(column);
  if (const auto found = beacons_.find(name); found != beacons_.end()) {
    id = found->second;
    return true;
  }
  if (name.empty()) return csv.fail_at(column, csv.header()[static_cast<std::size_t>(column)] + " is empty", "a beacon's id");
  return csv.fail_at(column, fmt::format("beacon {} is not in the site", in_quotes(name)), "a beacon's id",
                     suggestion(name, names_.beacons));
}

bool NameLookup::vehicle(CsvReader& csv, int column, VehicleId& id) const {
  const std::string_view name = csv.field(column);
  if (name.empty()) {
    id = default_vehicle;
    if (id.valid()) return true;
    return csv.fail_at(column, fmt::format("the row names no vehicle, and the site has {}", names_.vehicles.size()),
                       "a vehicle's id", "add a column 'vehicle', or 'vehicle: ...' in run.yaml");
  }
  id = vehicle(name);
  if (id.valid()) return true;
  return csv.fail_at(column, fmt::format("vehicle {} is not in the site", in_quotes(name)), "a vehicle's id",
                     suggestion(name, names_.vehicles));
}

bool NameLookup::receiver(CsvReader& csv, int column, VehicleId vehicle, ReceiverId& id) const {
  const std::string_view name = csv.field(column);
  const auto& known = receivers_[vehicle.index()];
  if (name.empty()) {
    id = only_receiver_[vehicle.index()];
    if (id.valid()) return true;
    return csv.fail_at(column,
                       fmt::format("the row names no receiver, and vehicle {} has {}",
                                   in_quotes(names_.vehicles[vehicle.index()]), known.size()),
                       "a receiver's id", known.empty() ? "list its receivers in the site file" : "add a column 'receiver'");
  }
  if (const auto found = known.find(name); found != known.end()) {
    id = found->second;
    return true;
  }
  std::vector<std::string> candidates;
  for (const auto& r : names_.receivers) {
    if (r.vehicle == vehicle) candidates.push_back(r.name);
  }
  return csv.fail_at(
      column, fmt::format("receiver {} is not on vehicle {}", in_quotes(name), in_quotes(names_.vehicles[vehicle.index()])),
      "a receiver's id", suggestion(name, candidates));
}

OrderWatch::OrderWatch(std::size_t vehicles, int time_column, int epoch_column)
    : time_column_(time_column),
      epoch_column_(epoch_column),
      last_time_s_(-std::numeric_limits<double>::infinity()),
      current_(vehicles, kNoEpoch),
      finished_(vehicles) {}

bool OrderWatch::time(CsvReader& csv, double time_s) {
  if (time_s < last_time_s_) {
    return csv.fail_at(time_column_, fmt::format("time_s goes back from {} to {}", exact(last_time_s_), exact(time_s)),
                       "times that do not decrease", "sort the rows by time_s");
  }
  last_time_s_ = time_s;
  return true;
}

bool OrderWatch::epoch(CsvReader& csv, VehicleId vehicle, std::int64_t epoch) {
  std::int64_t& current = current_[vehicle.index()];
  if (epoch == current) return true;
  if (finished_[vehicle.index()].contains(epoch)) {
    return csv.fail_at(epoch_column_, fmt::format("epoch {} comes back after epoch {}", epoch, current),
                       "the rows of an epoch in one block", "give each stop of the vehicle a number of its own");
  }
  if (current != kNoEpoch) finished_[vehicle.index()].insert(current);
  current = epoch;
  return true;
}

}  // namespace octant::io
