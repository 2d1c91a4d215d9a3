// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/contradiction.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace octant {
namespace {

struct KindNames {
  ContradictionKind kind;
  const char* name;      ///< name in files
  const char* in_words;  ///< words before the subject at the beginning of a sentence
};
constexpr std::array kKinds = {KindNames{ContradictionKind::kControlPoint, "control_point", "Control point"},
                               KindNames{ContradictionKind::kExchanged, "exchanged", "Beacons"},
                               KindNames{ContradictionKind::kBeacon, "beacon", "Beacon"},
                               KindNames{ContradictionKind::kSpeed, "speed", "Speed of the medium"},
                               KindNames{ContradictionKind::kDelay, "delay", "Delay of"},
                               KindNames{ContradictionKind::kReceiver, "receiver", "Receiver"},
                               KindNames{ContradictionKind::kWiring, "wiring", "Receivers"},
                               KindNames{ContradictionKind::kAttenuation, "attenuation", "Attenuation"},
                               KindNames{ContradictionKind::kDistance, "distance", "Taped distance"},
                               KindNames{ContradictionKind::kPoses, "poses", "Measured poses"},
                               KindNames{ContradictionKind::kUnits, "units", "Units of"},
                               KindNames{ContradictionKind::kEpochs, "epochs", "Epochs of"},
                               KindNames{ContradictionKind::kRanging, "ranging", "Ranging of"},
                               KindNames{ContradictionKind::kRepeated, "repeated", "Rows of"},
                               KindNames{ContradictionKind::kStop, "stop", "Vehicle at"},
                               KindNames{ContradictionKind::kLog, "log", "Recording"}};

const KindNames& names_of(ContradictionKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

}  // namespace

const char* to_string(ContradictionKind kind) { return names_of(kind).name; }

std::optional<ContradictionKind> contradiction_kind(std::string_view name) {
  for (const KindNames& k : kKinds)
    if (name == k.name) return k.kind;
  return std::nullopt;
}

std::string in_words(const Contradiction& c) {
  std::string text = names_of(c.kind).in_words;
  if (!c.subject.empty()) text += " " + c.subject;
  text += ": stated " + c.stated + ", found " + c.found;
  if (c.sigmas > 0 && std::isfinite(c.sigmas)) {
    char size[40];
    std::snprintf(size, sizeof size, " (%.*f sigma)", c.sigmas < 10 ? 1 : 0, c.sigmas);
    text += size;
  }
  return text;
}

}  // namespace octant
