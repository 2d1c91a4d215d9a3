// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: meaning of the names of columns, in English and German.

#include <string>
#include <string_view>

namespace octant::io {

enum class ColumnRole {
  kUnknown,
  kTime,
  kBeacon,
  kReceiver,
  kVehicle,
  kEpoch,
  kTemperature,
  kDistance,  ///< `id` names the beacon of the column, if there is one
  kTof,
  kBeaconName  ///< the name is that of a beacon: "A1", "Anchor 3", "1782"
};

struct NamedColumn {
  ColumnRole role = ColumnRole::kUnknown;
  std::string id = {};    ///< "A1" of "r_A1", "dist A1 [cm]" and "A1_range_mm"
  bool is_vague = false;  ///< "id", which may be the number of a row
  bool is_end = false;    ///< "from" or "to": the beacon or the receiver
};

/// Meaning of a name; kUnknown for columns about another quantity ("rssi_A1", "range_std", "gt_x").
[[nodiscard]] NamedColumn meaning_of(std::string_view name);

}  // namespace octant::io
