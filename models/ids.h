// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

namespace octant {

/// Typed index of a beacon, receiver or vehicle in the lists of its site or deployment. The types keep the
/// index of a beacon from being used for a receiver.
template <class Tag>
struct Id {
  std::int32_t value = -1;

  constexpr Id() = default;
  constexpr explicit Id(std::int32_t v) : value(v) {}
  constexpr explicit Id(std::size_t v) : value(static_cast<std::int32_t>(v)) {}

  [[nodiscard]] constexpr bool valid() const { return value >= 0; }
  [[nodiscard]] constexpr std::size_t index() const { return static_cast<std::size_t>(value); }
  constexpr auto operator<=>(const Id&) const =
      default;  // NOLINT(modernize-use-nullptr): the zero is the compiler's
};

using BeaconId = Id<struct BeaconTag>;      ///< index into Site::beacons and Deployment::beacons
using ReceiverId = Id<struct ReceiverTag>;  ///< index into the flat list of all receivers of all vehicles
using VehicleId = Id<struct VehicleTag>;    ///< index into Site::vehicles and Deployment::vehicles

}  // namespace octant
