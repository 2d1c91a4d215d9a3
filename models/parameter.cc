// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/parameter.h"

#include <algorithm>

#include "models/site.h"

namespace octant {
namespace {

struct TopicRow {
  const char* words;
  const char* remedy;
};

/// One row for each ParameterTopic, in its order: the topic with the cheapest measurement first.
constexpr std::array<TopicRow, kParameterTopics> kTopicRows = {{
    {"speed of sound and overall scale",
     "tape the distance between two beacons that are far apart, or measure the temperature"},
    {"heights of beacons", "tape the height of one of these beacons"},
    {"horizontal places of beacons", "survey one of these beacons, or record it from another side"},
    {"delays", "record these beacons from near and from far"},
    {"places of receivers", "measure the receivers on the vehicle, or turn it on the spot among the beacons"},
    {"attenuation and time-walk",
     "log amplitudes, or record the beacons at two metres and at the end of their range"},
    {"loudness of beacons", "log amplitudes of these beacons from near and from far"},
    {"drift of the vehicle's clock", "fire each beacon again at the end of the cycle"},
}};
static_assert(std::ranges::none_of(kTopicRows, [](const TopicRow& row) { return row.words == nullptr; }));

/// Returns an empty string for a parameter without an owner.
std::string owner_path(const ParameterId& id, const NameTable& names) {
  switch (row_of(id.kind).owner) {
    case ParameterOwner::kNone: return {};
    case ParameterOwner::kBeacon: return names.beacons[id.owner];
    case ParameterOwner::kReceiver: return receiver_path(id.owner, names);
    case ParameterOwner::kVehicle: return names.vehicles[id.owner];
    case ParameterOwner::kRun: return id.owner == 0 ? std::string() : "run" + std::to_string(id.owner);
    case ParameterOwner::kPair: {
      std::string path = names.beacons[id.owner];
      path += '/';
      // Receivers of different vehicles may share a name.
      path +=
          names.vehicles.size() > 1 ? receiver_path(id.component, names) : names.receivers[id.component].name;
      return path;
    }
  }
  return {};
}

std::optional<std::uint32_t> owner_named(const std::unordered_map<std::string, std::uint32_t>& owners,
                                         std::string_view name) {
  const auto at = owners.find(std::string(name));
  return at == owners.end() ? std::nullopt : std::optional(at->second);
}

/// "run12" gives 12, an empty text 0.
std::optional<std::uint32_t> run_number(std::string_view owner) {
  if (owner.empty()) return 0;
  if (!owner.starts_with("run") || owner.size() > 9) return std::nullopt;
  std::uint32_t number = 0;
  for (const char digit : owner.substr(3)) {
    if (digit < '0' || digit > '9') return std::nullopt;
    number = 10 * number + static_cast<std::uint32_t>(digit - '0');
  }
  return number > 0 ? std::optional(number) : std::nullopt;
}

}  // namespace

int index_of(std::span<const ParameterId> parameters, const ParameterId& id) {
  const auto at = std::ranges::find(parameters, id);
  return at == parameters.end() ? -1 : static_cast<int>(at - parameters.begin());
}

std::optional<std::size_t> beacon_of(const ParameterId& id) {
  const ParameterOwner owner = row_of(id.kind).owner;
  return owner == ParameterOwner::kBeacon ? std::optional<std::size_t>(id.owner) : std::nullopt;
}

ParameterTopic topic_of(const ParameterId& id) {
  if (id.kind == ParameterKind::kBeaconPosition && id.component == 2) return ParameterTopic::kHeight;
  return row_of(id.kind).topic;
}

const char* words_of(ParameterTopic topic) { return kTopicRows[static_cast<std::size_t>(topic)].words; }
const char* remedy_of(ParameterTopic topic) { return kTopicRows[static_cast<std::size_t>(topic)].remedy; }

std::string receiver_path(std::size_t receiver, const NameTable& names) {
  std::string path = names.vehicles[names.receivers[receiver].vehicle.index()];
  path += '/';
  path += names.receivers[receiver].name;
  return path;
}

std::string owner_name(const ParameterId& id, const NameTable& names) {
  std::string path = row_of(id.kind).prefix;
  const std::string owner = owner_path(id, names);
  if (!owner.empty()) path += '/';
  path += owner;
  return path;
}

std::string parameter_name(const ParameterId& id, const NameTable& names) {
  const std::size_t symbol = row_of(id.kind).owner == ParameterOwner::kPair ? 0 : id.component;
  std::string path = owner_name(id, names);
  path += '/';
  path += row_of(id.kind).symbols[symbol];
  return path;
}

std::vector<std::string> parameter_names(std::span<const ParameterId> ids, const NameTable& names) {
  std::vector<std::string> all;
  all.reserve(ids.size());
  for (const ParameterId& id : ids) all.push_back(parameter_name(id, names));
  return all;
}

ParameterIndex::ParameterIndex(std::span<const ParameterId> parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) set(parameters[i], static_cast<int>(i));
}

void ParameterIndex::set(const ParameterId& id, int place) {
  auto& of_kind = at_[static_cast<std::size_t>(id.kind)];
  if (id.owner >= of_kind.size()) of_kind.resize(id.owner + 1);
  auto& of_owner = of_kind[id.owner];
  if (id.component >= of_owner.size()) of_owner.resize(id.component + 1, -1);
  of_owner[id.component] = place;
}

std::array<int, 4> ParameterIndex::transducer(ParameterKind position, ParameterKind delay,
                                              std::size_t owner) const {
  const ParameterIndex& at = *this;
  return {at[parameters::of(position, owner, 0)], at[parameters::of(position, owner, 1)],
          at[parameters::of(position, owner, 2)], at[parameters::of(delay, owner)]};
}

ParameterLookup::ParameterLookup(const NameTable& names) {
  for (std::size_t b = 0; b < names.beacons.size(); ++b) beacons_.emplace(names.beacons[b], b);
  for (std::size_t v = 0; v < names.vehicles.size(); ++v) vehicles_.emplace(names.vehicles[v], v);
  for (std::size_t r = 0; r < names.receivers.size(); ++r) {
    receivers_.emplace(receiver_path(r, names), r);
    receivers_by_own_name_.emplace(names.receivers[r].name, r);
  }
}

std::optional<ParameterId> ParameterLookup::find(std::string_view name) const {
  const std::size_t first = name.find('/'), last = name.rfind('/');
  if (first == std::string_view::npos) return std::nullopt;
  const std::string_view prefix = name.substr(0, first), symbol = name.substr(last + 1);
  const std::string_view owner = last > first ? name.substr(first + 1, last - first - 1) : std::string_view();
  for (std::size_t k = 0; k < kParameterKinds; ++k) {
    const ParameterRow& row = kParameterRows[k];
    if (prefix != row.prefix) continue;
    for (std::size_t c = 0; c < row.symbols.size() && row.symbols[c] != nullptr; ++c)
      if (symbol == row.symbols[c])
        return owned(static_cast<ParameterKind>(k), owner, static_cast<std::uint32_t>(c));
  }
  return std::nullopt;
}

std::optional<ParameterId> ParameterLookup::owned(ParameterKind kind, std::string_view owner,
                                                  std::uint32_t component) const {
  std::optional<std::uint32_t> index;
  switch (row_of(kind).owner) {
    case ParameterOwner::kNone: index = owner.empty() ? std::optional(0U) : std::nullopt; break;
    case ParameterOwner::kBeacon: index = owner_named(beacons_, owner); break;
    case ParameterOwner::kReceiver: index = owner_named(receivers_, owner); break;
    case ParameterOwner::kVehicle: index = owner_named(vehicles_, owner); break;
    case ParameterOwner::kRun: index = run_number(owner); break;
    case ParameterOwner::kPair: return pair_named(owner);
  }
  return index ? std::optional(ParameterId{kind, *index, component}) : std::nullopt;
}

/// Names of beacons may contain slashes, so any slash may be the separator.
std::optional<ParameterId> ParameterLookup::pair_named(std::string_view owners) const {
  for (std::size_t at = owners.find('/'); at != std::string_view::npos; at = owners.find('/', at + 1)) {
    const auto beacon = owner_named(beacons_, owners.substr(0, at));
    auto receiver = owner_named(receivers_, owners.substr(at + 1));
    if (!receiver) receiver = owner_named(receivers_by_own_name_, owners.substr(at + 1));
    if (beacon && receiver) return ParameterId{ParameterKind::kPairBias, *beacon, *receiver};
  }
  return std::nullopt;
}

}  // namespace octant
