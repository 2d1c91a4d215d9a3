// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "apps/octant/session.h"
#include "survey/schedule/floor_schedule.h"

namespace octant::app {

/// Slot, cycle, groups, silence and hall of a firing schedule.
[[nodiscard]] Json schedule_json(const survey::FloorSchedule& schedule, const survey::SurveyModel& model);

/// Slots with their beacons as a table, and the cycle.
[[nodiscard]] std::string slots_text(const survey::FloorSchedule& schedule, const survey::SurveyModel& model);

}  // namespace octant::app
