// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>

#include "calib/problem/parameters.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {

/// The shared parameters that an observation over one path (beacon, receiver) touches, each with what its
/// residual is derived by: the one list of them.
struct PathColumns {
  enum What : std::uint8_t {
    kBeacon,        ///< and the two axes that follow
    kReceiver = 3,  ///< likewise
    kRadius = 6,    ///< of an array as a whole
    kTurn,          ///< likewise
    kAttenuation,   ///< in the order of AttenuationRow
    kGain = kAttenuation + kAttenuationUnknowns,
    kDelay,  ///< of beacon, receiver, site and pair
    kDrift,
    kSpeed,
    kWhats
  };
  struct Entry {
    int column = 0;
    What what = kBeacon;
    double scale = 1.0;  ///< internal unit of the parameter
  };
  /// All there are, with four delays and either of a receiver's place and an array's shape.
  static constexpr std::size_t kCapacity = kWhats - 2 + 3;
  std::size_t count = 0;
  std::array<Entry, kCapacity> entry;

  void add(int column, int what, double scale) {
    if (column < 0) return;
    if (count == kCapacity) std::abort();  // a new unknown that is not in the sum above
    entry[count++] = {column, static_cast<What>(what), scale};
  }
  [[nodiscard]] auto begin() const { return entry.begin(); }
  [[nodiscard]] auto end() const { return entry.begin() + static_cast<std::ptrdiff_t>(count); }
};

/// @param receiver  invalid: a reflector that is seen, which has its place alone
/// @param run  of the trajectory that the observation belongs to
[[nodiscard]] inline PathColumns path_columns(const ParameterLayout& layout, BeaconId beacon,
                                              ReceiverId receiver, std::size_t run) {
  PathColumns path;
  const auto scaled = [&](int column, int what) {
    if (column >= 0) path.add(column, what, layout.parameters[static_cast<std::size_t>(column)].si_per_unit);
  };
  const std::size_t b = beacon.index();
  for (std::size_t i = 0; i < 3; ++i)
    path.add(layout.beacon[b][i], PathColumns::kBeacon + static_cast<int>(i), 1.0);
  if (!receiver.valid()) return path;
  const std::size_t r = receiver.index();
  const VehicleId vehicle = layout.vehicle_of_receiver[r];
  if (layout.has_array(vehicle)) {
    path.add(layout.array[vehicle.index()][0], PathColumns::kRadius, 1.0);
    scaled(layout.array[vehicle.index()][1], PathColumns::kTurn);
  } else {
    for (std::size_t i = 0; i < 3; ++i)
      path.add(layout.receiver[r][i], PathColumns::kReceiver + static_cast<int>(i), 1.0);
  }
  for (std::size_t i = 0; i < layout.attenuation.size(); ++i)
    scaled(layout.attenuation[i], PathColumns::kAttenuation + static_cast<int>(i));
  if (!layout.beacon_gain.empty()) path.add(layout.beacon_gain[b], PathColumns::kGain, 1.0);
  scaled(layout.beacon_delay[b], PathColumns::kDelay);
  scaled(layout.receiver_delay[r], PathColumns::kDelay);
  scaled(layout.site_delay, PathColumns::kDelay);
  if (!layout.pair_bias.empty())
    scaled(layout.pair_bias[b * layout.receiver.size() + r], PathColumns::kDelay);
  scaled(layout.clock_drift[vehicle.index()], PathColumns::kDrift);
  scaled(layout.speed_column(run), PathColumns::kSpeed);
  return path;
}

/// Derivatives of one whitened row by the free shared parameters that it touches (internal units), as
/// (column, value) pairs.
struct RowEntries {
  int count = 0;
  std::array<int, PathColumns::kCapacity> column;
  std::array<double, PathColumns::kCapacity> value;
};

/// A row's derivative by a shared parameter (SI units).
/// @param state  at which the row was made
[[nodiscard]] inline double derivative_of(const ObservationRow& row, PathColumns::What what,
                                          const SharedState& state) {
  if (what < PathColumns::kReceiver) return row.by_beacon[what - PathColumns::kBeacon];
  if (what < PathColumns::kRadius) return row.by_receiver[what - PathColumns::kReceiver];
  if (what >= PathColumns::kAttenuation && what < PathColumns::kGain)
    return row.by_attenuation[what - PathColumns::kAttenuation];
  switch (what) {
    case PathColumns::kGain:  // it multiplies the amplitude: d/d ln g = A_1m d/d A_1m
      return row.by_attenuation[0] * state.attenuation->amplitude_1m_v;
    case PathColumns::kDelay: return row.by_delay;
    case PathColumns::kDrift: return row.by_drift;
    case PathColumns::kSpeed: return row.by_speed;
    default: break;
  }
  // An octagon as a whole: along the receiver's radius, and across it by its turn.
  const Eigen::Vector2d o = state.receiver_p_vehicle_m[row.receiver.index()].head<2>();
  return what == PathColumns::kRadius ? row.by_receiver.head<2>().dot(o.normalized())
                                      : row.by_receiver[1] * o.x() - row.by_receiver[0] * o.y();
}

/// @param run  of the trajectory the row belongs to
/// @param state  at which the row was made
[[nodiscard]] inline RowEntries row_entries(const ObservationRow& row, std::size_t run,
                                            const ParameterLayout& layout, const SharedState& state) {
  RowEntries e;
  if (!row.has_shared) return e;
  for (const PathColumns::Entry& of : path_columns(layout, row.beacon, row.receiver, run)) {
    if (of.what >= PathColumns::kDelay && row.kind != RowKind::kTof) break;  // what follows moves times alone
    e.column[static_cast<std::size_t>(e.count)] = of.column;
    e.value[static_cast<std::size_t>(e.count++)] = derivative_of(row, of.what, state) * of.scale;
  }
  return e;
}

}  // namespace octant::calib
