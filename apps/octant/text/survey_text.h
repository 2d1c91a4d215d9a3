// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "apps/octant/session.h"
#include "survey/map/survey.h"
#include "survey/schedule/floor_schedule.h"

namespace octant::app {

/// The object of `octant survey --json`. @param schedule  that goes with it; none: null. @param bins  along
/// the longer side of each map's values; 0: no values
[[nodiscard]] Json survey_json(const survey::Survey& survey,
                               const std::optional<survey::FloorSchedule>& schedule, std::size_t bins);
/// For people: the verdict, what it rests on, and what to do, in some ten lines.
[[nodiscard]] std::string survey_summary(const survey::Survey& survey,
                                         const std::optional<survey::FloorSchedule>& schedule);
/// All figures: maps, what failures cost, routes, who fires when.
[[nodiscard]] std::string survey_text(const survey::Survey& survey,
                                      const std::optional<survey::FloorSchedule>& schedule);

/// Every map into a folder, which is made: NAME.svg, NAME.png (a pixel a cell), NAME.pgm and NAME.yaml (for
/// ROS' map_server); cells.csv, routes.csv. Each file whole or not at all.
[[nodiscard]] std::vector<std::string> write_maps(const survey::Survey& survey, const std::string& folder);
/// What it may write.
[[nodiscard]] std::vector<std::string> map_files(const survey::Survey& survey, const std::string& folder);

/// Slot, cycle, groups, silence and hall of a firing schedule.
[[nodiscard]] Json schedule_json(const survey::FloorSchedule& schedule, const survey::SurveyModel& model);

/// Slots with their beacons as a table, and the cycle.
[[nodiscard]] std::string slots_text(const survey::FloorSchedule& schedule, const survey::SurveyModel& model);

}  // namespace octant::app
