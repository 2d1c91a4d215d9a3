// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/scene.h"
#include "models/support/result.h"
#include "survey/geometry/survey_model.h"
#include "survey/schedule/schedule.h"

namespace octant::survey {

struct FloorScheduleOptions {
  std::optional<double> height_m;  ///< of the hall; none: half a metre above the highest beacon
  double wall_reflection = 0.96, pulse_s = 2.5e-3;
  bool trust_walls = false, by_time = false;
  int threads = 1;
};

/// The firing schedule of a site: its hall, its silence, its groups.
struct FloorSchedule {
  Reverberance reverberance;
  FallSilent silent;
  FiringPlan plan;
  double reach_m = 0.0, height_m = 0.0;
  std::vector<std::string> warnings;
};

/// The hall is the floor's outline as high as stated. Without a threshold a pulse is taken to be heard
/// exactly as far as the range says; without a range either there is nothing to go by. Errors: neither a
/// threshold nor a range; what make_floor_grid finds.
[[nodiscard]] Result<FloorSchedule> floor_schedule(const SurveyModel& model, const Scene& scene,
                                                   const FloorScheduleOptions& options);

/// Of more beacons than this a survey tells no schedule by itself: each is held against every other.
inline constexpr std::size_t kMostScheduledUnasked = 300;
/// Faster than this a pulse is radio or light, which leaves no echoes to wait for.
inline constexpr double kFastestSoundMps = 1e5;

/// The schedule that goes with a survey; none where there is no sound to wait for, nothing says how far it is
/// heard, or beacons are more than kMostScheduledUnasked.
[[nodiscard]] std::optional<FloorSchedule> schedule_of_survey(const SurveyModel& model, const Scene& scene,
                                                              int threads);

}  // namespace octant::survey
