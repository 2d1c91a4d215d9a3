// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/change.h"

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

}  // namespace octant
