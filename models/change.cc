// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/change.h"

#include <cmath>

#include "models/support/enum_names.h"

namespace octant {
namespace {

constexpr auto kChangeNames =
    enum_names<ChangeKind>("beacon_moved", "delay", "receiver", "speed", "exchanged", "datum", "amplitude");
constexpr auto kChangeUnits = enum_names<ChangeKind>("m", "s", "m", "m/s", "m", "m", "1");

}  // namespace

const char* to_string(ChangeKind kind) { return kChangeNames[kind]; }
const char* unit_of(ChangeKind kind) { return kChangeUnits[kind]; }
std::optional<ChangeKind> change_kind(std::string_view name) { return kChangeNames.find(name); }

Drift Drift::of_months(double months) {
  const Drift at_once, a_month{1.0e-4, 3.0e-7, 5.0e-5, 0.03, 0.005, 0.005};
  const double m = months > 0 ? months : 0.0;
  const auto total = [m](double once, double monthly) { return std::hypot(once, m * monthly); };
  return {total(at_once.beacon_m, a_month.beacon_m),     total(at_once.delay_s, a_month.delay_s),
          total(at_once.receiver_m, a_month.receiver_m), total(at_once.speed_mps, a_month.speed_mps),
          total(at_once.log_gain, a_month.log_gain),     total(at_once.attenuation, a_month.attenuation)};
}

}  // namespace octant
