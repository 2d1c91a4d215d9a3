// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdlib>

#include "calib/problem/parameters.h"
#include "models/trajectory/linearise.h"

namespace octant::calib {

/// Derivatives of one whitened row by the free shared parameters that it touches (internal units), as
/// (column, value) pairs.
struct RowEntries {
  /// Beacon and receiver (or the two of an array), attenuation, gain, three delays, pair, drift and speed.
  static constexpr int kCapacity = 3 + 3 + static_cast<int>(kAttenuationUnknowns) + 1 + 3 + 1 + 1 + 1;
  int count = 0;
  std::array<int, kCapacity> column;
  std::array<double, kCapacity> value;
  void add(int c, double v) {
    if (c < 0) return;
    if (count == kCapacity) std::abort();  // a new unknown that is not in the sum above
    column[static_cast<std::size_t>(count)] = c;
    value[static_cast<std::size_t>(count++)] = v;
  }
};

/// @param run  of the trajectory the row belongs to
/// @param state  at which the row was made
[[nodiscard]] inline RowEntries row_entries(const ObservationRow& row, std::size_t run,
                                            const ParameterLayout& layout, const SharedState& state) {
  RowEntries e;
  if (!row.has_shared) return e;
  const auto scale = [&](int column) {
    return column < 0 ? 0.0 : layout.parameters[static_cast<std::size_t>(column)].si_per_unit;
  };
  for (std::size_t i = 0; i < 3; ++i)
    e.add(layout.beacon[row.beacon.index()][i], row.by_beacon[static_cast<int>(i)]);
  if (!row.receiver.valid()) return e;
  const VehicleId vehicle = layout.vehicle_of_receiver[row.receiver.index()];
  if (layout.has_array(vehicle)) {
    // An octagon as a whole: along the receiver's radius, and across it by its turn.
    const Eigen::Vector2d o = state.receiver_p_vehicle_m[row.receiver.index()].head<2>(),
                          outward = o.normalized();
    const auto& columns = layout.array[vehicle.index()];
    e.add(columns[0], row.by_receiver.head<2>() * outward);
    e.add(columns[1], (row.by_receiver[1] * o.x() - row.by_receiver[0] * o.y()) * scale(columns[1]));
  } else {
    for (std::size_t i = 0; i < 3; ++i)
      e.add(layout.receiver[row.receiver.index()][i], row.by_receiver[static_cast<int>(i)]);
  }
  for (std::size_t i = 0; i < layout.attenuation.size(); ++i)
    e.add(layout.attenuation[i], row.by_attenuation[static_cast<int>(i)] * scale(layout.attenuation[i]));
  // The gain multiplies the amplitude: d/d ln g = A_1m d/d A_1m.
  if (state.attenuation && !layout.beacon_gain.empty())
    e.add(layout.beacon_gain[row.beacon.index()], row.by_attenuation[0] * state.attenuation->amplitude_1m_v);
  if (row.kind != RowKind::kTof) return e;
  for (const int column : {layout.beacon_delay[row.beacon.index()],
                           layout.receiver_delay[row.receiver.index()], layout.site_delay})
    e.add(column, row.by_delay * scale(column));
  if (!layout.pair_bias.empty()) {
    const int column = layout.pair_bias[row.beacon.index() * layout.receiver.size() + row.receiver.index()];
    e.add(column, row.by_delay * scale(column));
  }
  const int drift = layout.clock_drift[vehicle.index()];
  e.add(drift, row.by_drift * scale(drift));
  const int column = layout.speed_column(run);
  e.add(column, row.by_speed * scale(column));
  return e;
}

}  // namespace octant::calib
