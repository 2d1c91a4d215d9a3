// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include "apps/octant/commands/plan.h"
#include "apps/octant/survey_input.h"
#include "apps/octant/text/layout.h"
#include "apps/octant/text/survey_text.h"
#include "survey/schedule/floor_schedule.h"

namespace octant::app {
namespace {

const char* schedule_in_words(survey::Sharing sharing) {
  switch (sharing) {
    case survey::Sharing::kConfused: return "confused";
    case survey::Sharing::kNeverBoth: return "never_both";
    case survey::Sharing::kApartInTime: return "apart_in_time";
  }
  return "confused";
}

Json schedule_plan_json(const survey::FloorSchedule& s, const survey::SurveyModel& model,
                        const Session& session) {
  Json object = {{"plan", "schedule"}}, pairs = Json::array();
  object.update(schedule_json(s, model));
  for (std::size_t a = 0; a < s.plan.beacons; ++a)
    for (std::size_t b = a + 1; b < s.plan.beacons; ++b)
      pairs.push_back({{"a", model.beacons[a].name},
                       {"b", model.beacons[b].name},
                       {"sharing", schedule_in_words(s.plan.between(a, b))}});
  object["pairs"] = pairs;
  object["seconds"] = session.seconds();
  return object;
}

std::string schedule_plan_text(const survey::FloorSchedule& s, const survey::SurveyModel& model,
                               const PlanArgs& args) {
  std::string text =
      fmt::format("{}: {} beacons, heard up to {}\n\n", model.name, s.plan.beacons, length_text(s.reach_m));
  const auto line = [&](const char* name, const std::string& what) {
    text += fmt::format("{:<17}{}\n", name, what);
  };
  line("hall", fmt::format("{:.0f} m3, {:.0f} m2 of walls, floor and ceiling, {:.1f} m at its longest; walls "
                           "give back {:g} of the amplitude",
                           s.reverberance.volume_m3, s.reverberance.surface_m2, s.reverberance.longest_m,
                           s.reverberance.wall_reflection));
  line("single echoes", fmt::format("gone after {} (image sources: distance, air, a wall each {:.1f} m)",
                                    time_text(s.silent.single_echo_s), s.reverberance.longest_m));
  line("all echoes", fmt::format("gone after {} (Eyring: 60 dB in {})", time_text(s.silent.all_echoes_s),
                                 time_text(s.silent.t60_s)));
  line("Kleeman's eq. 1", fmt::format("{} (without the air's absorption)", time_text(s.silent.kleeman_s)));
  line("slot", fmt::format("{}: the longer of the first two and the pulse", time_text(s.plan.slot_s)));
  text += "\n" + slots_text(s, model);
  line(
      "together",
      args.trust_walls
          ? "beacons that no place on the floor hears both of; walls and beams are trusted to stop echoes too"
          : "beacons that no place on the floor is within reach of both of, walls or not: their echoes "
            "neither");
  return text;
}

}  // namespace

int plan_schedule(const PlanArgs& args, Session& session) {
  const SurveyInput input = read_survey_input(args.input, args.scene, args.vehicle, {}, session);
  const survey::FloorSchedule schedule = need(survey::floor_schedule(input.model, input.scene,
                                                                     {.height_m = args.height_m,
                                                                      .wall_reflection = args.wall_reflection,
                                                                      .pulse_s = args.pulse_s,
                                                                      .trust_walls = args.trust_walls,
                                                                      .by_time = args.by_time,
                                                                      .threads = session.threads()}),
                                              args.input);
  session.warn(schedule.warnings);
  session.result(schedule_plan_text(schedule, input.model, args));
  return session.finish(schedule_plan_json(schedule, input.model, session));
}

}  // namespace octant::app
