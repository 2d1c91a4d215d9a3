// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: lines of text that the modules of kits write to a terminal.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace octant::io {

struct KitRange {
  std::string beacon, receiver;  ///< an empty receiver is not named
  double distance_m = 0.0;       ///< 0: not measured
};

struct KitLine {
  std::size_t begin = 0;         ///< where the output of the module begins; a time may precede it
  std::optional<double> time_s;  ///< of the module
  std::vector<KitRange> ranges;
  std::size_t garbled = 0;  ///< groups that are damaged
};

/// Returns no value for a line of another kind.
using KitLineParser = std::optional<KitLine> (*)(std::string_view line);

/// Qorvo DWM1001 after `lec` (DIST,4,AN0,1151,5.00,8.00,2.25,6.44,...) or `les` (1151[5.00,8.00,2.25]=6.44).
[[nodiscard]] std::optional<KitLine> dwm1001_line(std::string_view line);
/// Decawave TREK1000: `mc 0f 00000663 000005a3 00000512 000004cb 095f c1 00024c24 a0:0`, which is the
/// corrected ranges: valid ranges (bits), four ranges [mm], number of ranges, sequence, time [ms], tag and
/// anchor; all but the last in hexadecimal.
[[nodiscard]] std::optional<KitLine> trek1000_line(std::string_view line);
/// As trek1000_line, but the raw ranges (`mr`), which have no time.
[[nodiscard]] std::optional<KitLine> trek1000_raw_line(std::string_view line);
/// Makerfabs: `from: 1782  Range: 1.03 m  RX power: -72.30 dBm`, `{"links":[{"A":"1782","R":"1.03"}]}` [m],
/// `{"id":0,"range":[232,401]}` [cm] or
/// `AT+RANGE=tid:0,mask:03,seq:12,range:(232,401,0,0,0,0,0,0),ancid:(0,1,-1,-1,-1,-1,-1,-1)` [cm].
[[nodiscard]] std::optional<KitLine> makerfabs_line(std::string_view line);
/// Pozyx: `1523 ms, 2345 mm, -80 dBm`, also with the address of the anchor (0x6069) before or behind it.
[[nodiscard]] std::optional<KitLine> pozyx_line(std::string_view line);

/// Text between delimiters, without blanks around it.
[[nodiscard]] std::vector<std::string_view> fields_at(std::string_view line, char delimiter);
/// A finite number.
[[nodiscard]] bool logged_number(std::string_view text, double& value);

}  // namespace octant::io
