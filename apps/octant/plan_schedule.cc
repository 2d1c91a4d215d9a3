// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/plan.h"
#include "apps/octant/survey_input.h"
#include "apps/octant/table.h"
#include "survey/floor_schedule.h"

namespace octant::app {
namespace {

const char* in_words(survey::Sharing sharing) {
  switch (sharing) {
    case survey::Sharing::kConfused: return "confused";
    case survey::Sharing::kNeverBoth: return "never_both";
    case survey::Sharing::kApartInTime: return "apart_in_time";
  }
  return "confused";
}

Json plan_json(const survey::FloorSchedule& s, const survey::SurveyModel& model, const Session& session) {
  Json groups = Json::array(), pairs = Json::array();
  for (std::size_t g = 0; g < s.plan.groups.size(); ++g) {
    Json names = Json::array();
    for (const std::size_t b : s.plan.groups[g]) names.push_back(model.beacons[b].name);
    groups.push_back({{"fires_at_s", static_cast<double>(g) * s.plan.slot_s}, {"beacons", names}});
  }
  for (std::size_t a = 0; a < s.plan.beacons; ++a)
    for (std::size_t b = a + 1; b < s.plan.beacons; ++b)
      pairs.push_back({{"a", model.beacons[a].name}, {"b", model.beacons[b].name}, {"sharing", in_words(s.plan.between(a, b))}});
  const auto time = [](double t) { return std::isfinite(t) ? Json(t) : Json(nullptr); };
  return {{"plan", "schedule"}, {"slot_s", s.plan.slot_s}, {"cycle_s", s.plan.cycle_s()}, {"one_by_one_s", s.plan.one_by_one_s()}, {"least_groups", s.plan.least_groups},
          {"groups", groups}, {"pairs", pairs}, {"reach_m", s.reach_m},
          {"silence", {{"single_echo_s", time(s.silent.single_echo_s)}, {"all_echoes_s", time(s.silent.all_echoes_s)}, {"kleeman_s", time(s.silent.kleeman_s)}, {"t60_s", time(s.silent.t60_s)}}},
          {"hall", {{"volume_m3", s.reverberance.volume_m3}, {"surface_m2", s.reverberance.surface_m2}, {"longest_m", s.reverberance.longest_m}, {"height_m", s.height_m},
                    {"wall_reflection", s.reverberance.wall_reflection}, {"absorption_np_per_m", s.reverberance.absorption_np_per_m}}},
          {"seconds", session.seconds()}};
}

std::string plan_text(const survey::FloorSchedule& s, const survey::SurveyModel& model, const PlanWords& words) {
  std::string text = fmt::format("{}: {} beacons, heard up to {}\n\n", model.name, s.plan.beacons, length_text(s.reach_m));
  const auto line = [&](const char* name, const std::string& what) { text += fmt::format("{:<17}{}\n", name, what); };
  line("hall", fmt::format("{:.0f} m3, {:.0f} m2 of walls, floor and ceiling, {:.1f} m at its longest; walls give back {:g} of the amplitude", s.reverberance.volume_m3,
                           s.reverberance.surface_m2, s.reverberance.longest_m, s.reverberance.wall_reflection));
  line("single echoes", fmt::format("gone after {} (image sources: distance, air, a wall each {:.1f} m)", time_text(s.silent.single_echo_s), s.reverberance.longest_m));
  line("all echoes", fmt::format("gone after {} (Eyring: 60 dB in {})", time_text(s.silent.all_echoes_s), time_text(s.silent.t60_s)));
  line("Kleeman's eq. 1", fmt::format("{} (without the air's absorption)", time_text(s.silent.kleeman_s)));
  line("slot", fmt::format("{}: the longer of the first two and the pulse", time_text(s.plan.slot_s)));
  text += "\n";
  Table table{"rrl", {{"slot", "fires at", "beacons"}}};
  for (std::size_t g = 0; g < s.plan.groups.size(); ++g) {
    std::string names;
    for (const std::size_t b : s.plan.groups[g]) names += (names.empty() ? "" : " ") + model.beacons[b].name;
    table.rows.push_back({fmt::format("{}", g + 1), time_text(static_cast<double>(g) * s.plan.slot_s), names});
  }
  text += table.text() + "\n";
  line("cycle", fmt::format("{}; one by one {}{}", time_text(s.plan.cycle_s()), time_text(s.plan.one_by_one_s()),
                            s.plan.groups.size() == s.plan.least_groups ? "; no fewer slots are possible" : fmt::format("; at least {} slots are needed", s.plan.least_groups)));
  line("together", words.trust_walls ? "beacons that no place on the floor hears both of; walls and beams are trusted to stop echoes too"
                                     : "beacons that no place on the floor is within reach of both of, walls or not: their echoes neither");
  return text;
}

}  // namespace

int plan_schedule(const PlanWords& words, Session& session) {
  const auto input = read_survey_input(words.input, words.scene, words.vehicle, {}, session);
  if (!input) return session.fail(input.error());
  const auto schedule = survey::floor_schedule(input->model, input->scene, {.height_m = words.height_m, .wall_reflection = words.wall_reflection, .pulse_s = words.pulse_s,
                                                                            .trust_walls = words.trust_walls, .by_time = words.by_time, .threads = session.threads()});
  if (!schedule) {
    Error error = schedule.error();
    if (error.file.empty()) error.file = words.input;
    return session.fail(error);
  }
  session.warn(schedule->warnings);
  session.result(plan_text(*schedule, input->model, words));
  return session.finish(plan_json(*schedule, input->model, session));
}

}  // namespace octant::app
