// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace octant {

/// Kinds of information in the site file or the log that the data may contradict.
enum class ContradictionKind {
  kControlPoint,  ///< fixed position of a beacon
  kExchanged,     ///< positions of beacons that are swapped
  kBeacon,        ///< a beacon whose arrivals disagree with each other: late at some stops, early, or moved
  kSpeed,         ///< speed of the medium, prior of its offset, or temperature
  kDelay,         ///< prior of a delay, or the assumption that there is no delay
  kReceiver,      ///< position of a receiver
  kWiring,        ///< assignment of receivers: swapped, mirrored or turned
  kAttenuation,   ///< amplitudes or rise time
  kDistance,      ///< a measured distance between two beacons
  kPoses,         ///< measured poses or their frame
  kUnits,         ///< positions, sigmas or times in another unit
  kEpochs,        ///< stops that share an epoch number
  kRanging,       ///< round-trip times that are declared as one-way
  kRepeated,      ///< rows that occur twice
  kStop,          ///< a vehicle that moved during a stop
  kLog            ///< two halves of the recording that disagree
};
/// Name used in files: "control_point", "exchanged", ...
[[nodiscard]] const char* to_string(ContradictionKind kind);
[[nodiscard]] std::optional<ContradictionKind> contradiction_kind(std::string_view name);

/// A value of the site file, or an assumption about the log, that the data contradict beyond its sigma and
/// beyond chance.
struct Contradiction {
  ContradictionKind kind = ContradictionKind::kLog;
  std::string subject;  ///< "B3", "robot/fl", "B1, B4", "medium", "stop 17", "run"
  std::string stated;   ///< assumed value in words, with units: "at (1.00, 2.00, 3.00) m, held fixed"
  std::string found;    ///< estimated value in words: "at (1.52, 2.01, 3.00) m"
  double sigmas = 0.0;  ///< size of the contradiction, in standard deviations of its test
  std::string remedy;   ///< recommended action
};
/// "Control point B3: stated at ..., found ... (12 sigma)."
[[nodiscard]] std::string in_words(const Contradiction& contradiction);

}  // namespace octant
