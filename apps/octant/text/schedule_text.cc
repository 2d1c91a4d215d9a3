// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/schedule_text.h"

#include <fmt/format.h>

#include "apps/octant/text/paragraph.h"
#include "apps/octant/text/table.h"

namespace octant::app {

Json schedule_json(const survey::FloorSchedule& s, const survey::SurveyModel& model) {
  Json groups = Json::array();
  for (std::size_t g = 0; g < s.plan.groups.size(); ++g) {
    Json names = Json::array();
    for (const std::size_t b : s.plan.groups[g]) names.push_back(model.beacons[b].name);
    groups.push_back({{"fires_at_s", static_cast<double>(g) * s.plan.slot_s}, {"beacons", names}});
  }
  return {{"slot_s", s.plan.slot_s},
          {"cycle_s", s.plan.cycle_s()},
          {"one_by_one_s", s.plan.one_by_one_s()},
          {"least_groups", s.plan.least_groups},
          {"groups", groups},
          {"reach_m", s.reach_m},
          {"silence",
           {{"single_echo_s", s.silent.single_echo_s},
            {"all_echoes_s", s.silent.all_echoes_s},
            {"kleeman_s", s.silent.kleeman_s},
            {"t60_s", s.silent.t60_s}}},
          {"hall",
           {{"volume_m3", s.reverberance.volume_m3},
            {"surface_m2", s.reverberance.surface_m2},
            {"longest_m", s.reverberance.longest_m},
            {"height_m", s.height_m},
            {"wall_reflection", s.reverberance.wall_reflection},
            {"absorption_np_per_m", s.reverberance.absorption_np_per_m}}}};
}

std::string slots_text(const survey::FloorSchedule& s, const survey::SurveyModel& model) {
  Table table{"rrl", {{"slot", "fires at", "beacons"}}};
  for (std::size_t g = 0; g < s.plan.groups.size(); ++g) {
    const std::string names =
        joined(s.plan.groups[g], " ", [&model](std::size_t b) { return model.beacons[b].name; });
    table.rows.push_back(
        {fmt::format("{}", g + 1), time_text(static_cast<double>(g) * s.plan.slot_s), names});
  }
  return table.text() + fmt::format("\n{:<17}{}; one by one {}{}\n", "cycle", time_text(s.plan.cycle_s()),
                                    time_text(s.plan.one_by_one_s()),
                                    s.plan.groups.size() == s.plan.least_groups
                                        ? std::string("; no fewer slots are possible")
                                        : fmt::format("; at least {} slots are needed", s.plan.least_groups));
}

}  // namespace octant::app
