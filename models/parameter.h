// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "models/ids.h"

namespace octant {

struct NameTable;

/// Kinds of parameters that all arrivals share. Each kind has a row in kParameterRows.
enum class ParameterKind : std::uint8_t {
  kBeaconPosition,    ///< owner: beacon; component: axis [m]
  kBeaconDelay,       ///< owner: beacon [s]
  kBeaconGain,        ///< owner: beacon; natural logarithm of its amplitude relative to the attenuation model
  kReceiverPosition,  ///< owner: receiver; component: axis, in the vehicle frame [m]
  kReceiverDelay,     ///< owner: receiver [s]
  kArray,  ///< owner: vehicle; circumradius [m] and turn [rad] of a regular array that is adjusted as a whole
  kSiteDelay,  ///< one delay for all pairs [s]
  kSpeed,  ///< offset from the medium's model [m/s]; owner: 0 for all runs together, else the number of the
           ///< run
  kAttenuation,  ///< component: in the order of AttenuationRow
  kClockDrift,   ///< owner: vehicle
  kPairBias      ///< owner: beacon; component: receiver [s]
};
inline constexpr std::size_t kParameterKinds = 11;

/// Topics that group parameters for people by the measurement that determines them.
enum class ParameterTopic : std::uint8_t {
  kSpeed,
  kHeight,
  kPlace,
  kDelay,
  kReceiver,
  kAttenuation,
  kGain,
  kDrift
};
inline constexpr std::size_t kParameterTopics = 8;

enum class ParameterOwner : std::uint8_t { kNone, kBeacon, kReceiver, kVehicle, kRun, kPair };

/// Conversion of a parameter's internal unit into metres, by which parameters are compared.
enum class ParameterWorth : std::uint8_t {
  kMetre,  ///< one
  kRange,  ///< a typical range, since the parameter scales ranges
  kOpen    ///< undefined: a relative change of amplitudes
};

/// Description of a kind of parameter: prefix of its name, owner, topic, worth in metres, and symbols of its
/// components with units.
struct ParameterRow {
  const char* prefix;
  ParameterOwner owner;
  ParameterTopic topic;
  ParameterWorth worth;
  std::array<const char*, 4> symbols;
};

/// One row for each ParameterKind, in its order.
inline constexpr std::array<ParameterRow, kParameterKinds> kParameterRows = {{
    {"beacon",
     ParameterOwner::kBeacon,
     ParameterTopic::kPlace,
     ParameterWorth::kMetre,
     {"x_m", "y_m", "z_m"}},
    {"beacon", ParameterOwner::kBeacon, ParameterTopic::kDelay, ParameterWorth::kMetre, {"delay_s"}},
    {"beacon", ParameterOwner::kBeacon, ParameterTopic::kGain, ParameterWorth::kOpen, {"log_gain"}},
    {"receiver",
     ParameterOwner::kReceiver,
     ParameterTopic::kReceiver,
     ParameterWorth::kMetre,
     {"x_m", "y_m", "z_m"}},
    {"receiver", ParameterOwner::kReceiver, ParameterTopic::kDelay, ParameterWorth::kMetre, {"delay_s"}},
    {"array",
     ParameterOwner::kVehicle,
     ParameterTopic::kReceiver,
     ParameterWorth::kMetre,
     {"radius_m", "turn_rad"}},
    {"site", ParameterOwner::kNone, ParameterTopic::kDelay, ParameterWorth::kMetre, {"delay_s"}},
    {"medium", ParameterOwner::kRun, ParameterTopic::kSpeed, ParameterWorth::kRange, {"speed_mps"}},
    {"attenuation",
     ParameterOwner::kNone,
     ParameterTopic::kAttenuation,
     ParameterWorth::kOpen,
     {"amplitude_1m_v", "absorption_np_per_m", "rise_time_s", "half_power_angle_rad"}},
    {"vehicle", ParameterOwner::kVehicle, ParameterTopic::kDrift, ParameterWorth::kMetre, {"clock_drift"}},
    {"pair", ParameterOwner::kPair, ParameterTopic::kDelay, ParameterWorth::kMetre, {"bias_s"}},
}};
[[nodiscard]] constexpr const ParameterRow& row_of(ParameterKind kind) {
  return kParameterRows[static_cast<std::size_t>(kind)];
}

/// Identifies one shared parameter of a site or deployment.
struct ParameterId {
  ParameterKind kind = ParameterKind::kSpeed;
  std::uint32_t owner = 0;  ///< index of the beacon, receiver or vehicle in its site or deployment
  std::uint32_t component = 0;
  friend auto operator<=>(const ParameterId&, const ParameterId&) = default;
};

namespace parameters {

using enum ParameterKind;

template <class Index>
[[nodiscard]] constexpr ParameterId of(ParameterKind kind, Index owner, std::size_t component = 0) {
  return {kind, static_cast<std::uint32_t>(owner), static_cast<std::uint32_t>(component)};
}
[[nodiscard]] constexpr ParameterId beacon_position(std::size_t beacon, std::size_t axis) {
  return of(kBeaconPosition, beacon, axis);
}
[[nodiscard]] constexpr ParameterId beacon_delay(std::size_t beacon) { return of(kBeaconDelay, beacon); }
[[nodiscard]] constexpr ParameterId beacon_gain(std::size_t beacon) { return of(kBeaconGain, beacon); }
[[nodiscard]] constexpr ParameterId receiver_position(std::size_t receiver, std::size_t axis) {
  return of(kReceiverPosition, receiver, axis);
}
[[nodiscard]] constexpr ParameterId receiver_delay(std::size_t receiver) {
  return of(kReceiverDelay, receiver);
}
[[nodiscard]] constexpr ParameterId array_radius(std::size_t vehicle) { return of(kArray, vehicle, 0); }
[[nodiscard]] constexpr ParameterId array_turn(std::size_t vehicle) { return of(kArray, vehicle, 1); }
[[nodiscard]] constexpr ParameterId site_delay() { return of(kSiteDelay, 0); }
/// Speed offset of all runs together, or of one run (numbered from 1).
[[nodiscard]] constexpr ParameterId speed(std::size_t run_number = 0) { return of(kSpeed, run_number); }
/// @param unknown  index in the order of AttenuationRow
[[nodiscard]] constexpr ParameterId attenuation(std::size_t unknown) { return of(kAttenuation, 0, unknown); }
[[nodiscard]] constexpr ParameterId clock_drift(std::size_t vehicle) { return of(kClockDrift, vehicle); }
[[nodiscard]] constexpr ParameterId pair_bias(std::size_t beacon, std::size_t receiver) {
  return of(kPairBias, beacon, receiver);
}

}  // namespace parameters

/// Visitor that returns an empty answer for every kind. Derive from it to handle only some of the kinds.
template <class Answer>
struct HasNothing {
  static Answer beacon_position(std::size_t /*beacon*/, std::size_t /*axis*/) { return Answer(); }
  static Answer beacon_delay(std::size_t /*beacon*/) { return Answer(); }
  static Answer beacon_gain(std::size_t /*beacon*/) { return Answer(); }
  static Answer receiver_position(std::size_t /*receiver*/, std::size_t /*axis*/) { return Answer(); }
  static Answer receiver_delay(std::size_t /*receiver*/) { return Answer(); }
  static Answer array(std::size_t /*vehicle*/, std::size_t /*component*/) { return Answer(); }
  static Answer site_delay() { return Answer(); }
  static Answer speed(std::size_t /*run*/) { return Answer(); }
  static Answer attenuation(std::size_t /*unknown*/) { return Answer(); }
  static Answer clock_drift(std::size_t /*vehicle*/) { return Answer(); }
  static Answer pair_bias(std::size_t /*beacon*/, std::size_t /*receiver*/) { return Answer(); }
};

/// Calls the visitor's function for the kind of a parameter. This is the only switch over the kinds.
template <class Visitor>
auto visit_parameter(const ParameterId& id, Visitor&& holder) {
  const std::size_t owner = id.owner, component = id.component;
  switch (id.kind) {
    case ParameterKind::kBeaconPosition: return holder.beacon_position(owner, component);
    case ParameterKind::kBeaconDelay: return holder.beacon_delay(owner);
    case ParameterKind::kBeaconGain: return holder.beacon_gain(owner);
    case ParameterKind::kReceiverPosition: return holder.receiver_position(owner, component);
    case ParameterKind::kReceiverDelay: return holder.receiver_delay(owner);
    case ParameterKind::kArray: return holder.array(owner, component);
    case ParameterKind::kSiteDelay: return holder.site_delay();
    case ParameterKind::kSpeed: return holder.speed(owner);
    case ParameterKind::kAttenuation: return holder.attenuation(component);
    case ParameterKind::kClockDrift: return holder.clock_drift(owner);
    case ParameterKind::kPairBias: break;
  }
  return holder.pair_bias(owner, component);
}

/// Index of a parameter in a list, or -1 if the list does not contain it.
[[nodiscard]] int index_of(std::span<const ParameterId> parameters, const ParameterId& id);

/// Beacon that owns the parameter.
[[nodiscard]] std::optional<std::size_t> beacon_of(const ParameterId& id);
[[nodiscard]] ParameterTopic topic_of(const ParameterId& id);
/// Topic in words, such as "heights of beacons".
[[nodiscard]] const char* words_of(ParameterTopic topic);
/// Measurement that determines the parameter, such as "tape the height of one of these beacons".
[[nodiscard]] const char* remedy_of(ParameterTopic topic);

/// Name in files and messages: "beacon/B1/x_m", "receiver/robot/r0/delay_s", "medium/speed_mps",
/// "medium/run2/speed_mps", "pair/B1/r0/bias_s".
[[nodiscard]] std::string parameter_name(const ParameterId& id, const NameTable& names);
[[nodiscard]] std::vector<std::string> parameter_names(std::span<const ParameterId> ids,
                                                       const NameTable& names);

/// Name of the owner: "beacon/B1", "receiver/robot/r0".
[[nodiscard]] std::string owner_name(const ParameterId& id, const NameTable& names);
/// Name of a receiver with its vehicle: "robot/r0".
[[nodiscard]] std::string receiver_path(std::size_t receiver, const NameTable& names);

/// Index of parameters in a list; -1 for those that the list does not contain.
class ParameterIndex {
 public:
  ParameterIndex() = default;
  explicit ParameterIndex(std::span<const ParameterId> parameters);
  void set(const ParameterId& id, int place);
  [[nodiscard]] int operator[](const ParameterId& id) const {
    const auto& of_kind = at_[static_cast<std::size_t>(id.kind)];
    if (id.owner >= of_kind.size() || id.component >= of_kind[id.owner].size()) return -1;
    return of_kind[id.owner][id.component];
  }
  /// Indices of a beacon's three coordinates and its delay.
  [[nodiscard]] std::array<int, 4> beacon(std::size_t beacon) const {
    return transducer(ParameterKind::kBeaconPosition, ParameterKind::kBeaconDelay, beacon);
  }
  /// Indices of a receiver's three coordinates and its delay.
  [[nodiscard]] std::array<int, 4> receiver(std::size_t receiver) const {
    return transducer(ParameterKind::kReceiverPosition, ParameterKind::kReceiverDelay, receiver);
  }

 private:
  [[nodiscard]] std::array<int, 4> transducer(ParameterKind position, ParameterKind delay,
                                              std::size_t owner) const;
  std::array<std::vector<std::vector<int>>, kParameterKinds> at_;  ///< by kind, owner, component
};

/// Finds parameters by name.
class ParameterLookup {
 public:
  /// @param names  must outlive the lookup
  explicit ParameterLookup(const NameTable& names);
  /// Returns no value if the program has no such parameter or the site no such owner.
  [[nodiscard]] std::optional<ParameterId> find(std::string_view name) const;

 private:
  [[nodiscard]] std::optional<ParameterId> owned(ParameterKind kind, std::string_view owner,
                                                 std::uint32_t component) const;
  [[nodiscard]] std::optional<ParameterId> pair_named(std::string_view owners) const;

  std::unordered_map<std::string, std::uint32_t> beacons_, vehicles_;
  std::unordered_map<std::string, std::uint32_t> receivers_;              ///< "robot/r0"
  std::unordered_map<std::string, std::uint32_t> receivers_by_own_name_;  ///< the first of each name
};

}  // namespace octant
