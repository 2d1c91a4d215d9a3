// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: columns of tof.csv.

#include <array>
#include <string_view>

namespace octant::io {

struct TofColumn {
  std::string_view name, short_name;  ///< short name: target of `octant convert --columns`
  bool is_id = false;                 ///< no unit
};
inline constexpr std::array<TofColumn, 10> kTofColumns = {{{"time_s", "time", false},
                                                           {"beacon", "beacon", true},
                                                           {"tof_s", "tof", false},
                                                           {"distance_m", "distance", false},
                                                           {"epoch", "epoch", true},
                                                           {"vehicle", "vehicle", true},
                                                           {"receiver", "receiver", true},
                                                           {"amplitude_v", "amplitude", false},
                                                           {"temperature_degC", "temperature", false},
                                                           {"received_s", "received", false}}};

}  // namespace octant::io
