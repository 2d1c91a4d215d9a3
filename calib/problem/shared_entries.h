// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdlib>

#include "calib/problem/parameters.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {

/// The free parameters that an observation over one path (beacon, receiver) touches, each with what its
/// residual is derived by.
struct PathColumns {
  struct Column {
    int column = 0;
    PathNumber what = kByBeacon;
    double scale = 1.0;  ///< internal unit of the parameter
  };
  /// All there are, with four delays and either of a receiver's place and an array's shape.
  static constexpr std::size_t kCapacity = kPathNumbers - 2 + 3;
  std::size_t count = 0;
  std::array<Column, kCapacity> entry;

  [[nodiscard]] auto begin() const { return entry.begin(); }
  [[nodiscard]] auto end() const { return entry.begin() + static_cast<std::ptrdiff_t>(count); }
};

/// @param receiver  invalid for an observed reflector, which has only a position
/// @param run  run of the trajectory of the observation
[[nodiscard]] inline PathColumns path_columns(const ParameterLayout& layout, BeaconId beacon,
                                              ReceiverId receiver, std::size_t run) {
  PathColumns path;
  const VehicleId vehicle = receiver.valid() ? layout.vehicle_of_receiver[receiver.index()] : VehicleId();
  for_each_path_parameter(beacon, receiver, vehicle, run, [&](const ParameterId& id, PathNumber what) {
    const int column = layout.column_of(id);
    if (column < 0) return;
    if (path.count == PathColumns::kCapacity) std::abort();  // a number that is not in the sum above
    path.entry[path.count++] = {column, what, layout.parameter(column).si_per_unit};
  });
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
[[nodiscard]] inline double derivative_of(const ObservationRow& row, PathNumber what,
                                          const SharedState& state) {
  if (what >= kByDelay) return row.by(what);
  if (what < kByReceiver) return row.by_beacon[what - kByBeacon];
  if (what < kByRadius) return row.by_receiver[what - kByReceiver];
  if (what == kByGain) return row.by_attenuation[0] * state.attenuation->amplitude_1m_v;  // d/d ln = A d/dA
  if (what >= kByAttenuation) return row.by_attenuation[what - kByAttenuation];
  // An octagon as a whole: along the receiver's radius, and across it by its turn.
  const Eigen::Vector2d o = state.receiver_p_vehicle_m[row.receiver.index()].head<2>();
  return what == kByRadius ? row.by_receiver.head<2>().dot(o.normalized())
                           : row.by_receiver[1] * o.x() - row.by_receiver[0] * o.y();
}

/// @param run  of the trajectory the row belongs to
/// @param state  at which the row was made
[[nodiscard]] inline RowEntries row_entries(const ObservationRow& row, std::size_t run,
                                            const ParameterLayout& layout, const SharedState& state) {
  RowEntries e;
  if (!row.has_shared) return e;
  for (const PathColumns::Column& of : path_columns(layout, row.beacon, row.receiver, run)) {
    if (of.what >= kByDelay && row.kind != RowKind::kTof) break;  // what follows moves times alone
    e.column[static_cast<std::size_t>(e.count)] = of.column;
    e.value[static_cast<std::size_t>(e.count++)] = derivative_of(row, of.what, state) * of.scale;
  }
  return e;
}

}  // namespace octant::calib
