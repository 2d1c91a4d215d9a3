// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "apps/octant/session.h"
#include "survey/map/survey.h"
#include "survey/schedule/floor_schedule.h"

namespace octant::app {

/// JSON object of `octant survey`. @param schedule  matching schedule; null if there is none. @param bins
/// number of bins along the longer side of each map; 0: without values
[[nodiscard]] Json survey_json(const survey::Survey& survey,
                               const std::optional<survey::FloorSchedule>& schedule, std::size_t bins);
/// Summary for people in about ten lines: the verdict, its basis, and the next steps.
[[nodiscard]] std::string survey_summary(const survey::Survey& survey,
                                         const std::optional<survey::FloorSchedule>& schedule);
/// All results: maps, effects of failures, routes, firing schedule.
[[nodiscard]] std::string survey_text(const survey::Survey& survey,
                                      const std::optional<survey::FloorSchedule>& schedule);

/// Writes every map into a new folder: NAME.svg, NAME.png (one pixel for each cell), NAME.pgm and NAME.yaml
/// (for ROS' map_server); also cells.csv and routes.csv. Each file is written completely or not at all.
[[nodiscard]] std::vector<std::string> write_maps(const survey::Survey& survey, const std::string& folder);
/// Files that write_maps() may write.
[[nodiscard]] std::vector<std::string> map_files(const survey::Survey& survey, const std::string& folder);

/// Slot, cycle, groups, silence and hall of a firing schedule.
[[nodiscard]] Json schedule_json(const survey::FloorSchedule& schedule, const survey::SurveyModel& model);

/// Table of slots with their beacons, and the cycle.
[[nodiscard]] std::string slots_text(const survey::FloorSchedule& schedule, const survey::SurveyModel& model);

}  // namespace octant::app
