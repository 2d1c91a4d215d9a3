// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace octant {

/// What of the user's statements the data speak against.
enum class ContradictionKind {
  kControlPoint,  ///< a position that was to be held
  kExchanged,     ///< beacons at each other's places
  kBeacon,        ///< a beacon whose arrivals do not agree among themselves: late at some stops, early, moved
  kSpeed,         ///< the medium's speed, offset prior or temperature
  kDelay,         ///< a delay's prior, or that there is none
  kReceiver,      ///< a receiver's place
  kWiring,        ///< which receiver is which: exchanged, mirrored, turned
  kAttenuation,   ///< amplitudes, rise time
  kDistance,      ///< a taped distance
  kPoses,         ///< measured poses, their frame
  kUnits,         ///< positions, sigmas or times in another unit
  kEpochs,        ///< stops that were not told apart
  kRanging,       ///< times there and back taken for one way
  kRepeated,      ///< rows counted twice
  kStop,          ///< a vehicle that did not stand still
  kLog            ///< halves of the recording that speak against each other
};
/// As it stands in files: "control_point", "exchanged", ...
[[nodiscard]] const char* to_string(ContradictionKind kind);
[[nodiscard]] std::optional<ContradictionKind> contradiction_kind(std::string_view name);

/// One statement of the site file (or the log's form) that the data speak against beyond what its sigma and
/// chance allow.
struct Contradiction {
  ContradictionKind kind = ContradictionKind::kLog;
  std::string subject;  ///< "B3", "robot/fl", "B1, B4", "medium", "stop 17", "run"
  std::string stated;   ///< for people, with units: "at (1.00, 2.00, 3.00) m, held fixed"
  std::string found;    ///< likewise: "at (1.52, 2.01, 3.00) m"
  double sigmas = 0.0;  ///< size of the contradiction in standard deviations of its test
  std::string remedy;   ///< what to do about it
};
/// "Control point B3: stated at ..., found ... (12 sigma)."
[[nodiscard]] std::string in_words(const Contradiction& contradiction);

}  // namespace octant
