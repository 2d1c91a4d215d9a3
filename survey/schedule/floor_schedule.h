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
  std::optional<double> height_m;  ///< height of the hall; no value: half a metre above the highest beacon
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

/// Computes a firing schedule. The hall is the outline of the floor with the stated height. Without a
/// threshold, a pulse is assumed to be received exactly up to the range; one of the two is required. Errors:
/// neither a threshold nor a range; errors of make_floor_grid.
[[nodiscard]] Result<FloorSchedule> floor_schedule(const SurveyModel& model, const Scene& scene,
                                                   const FloorScheduleOptions& options);

/// Above this number of beacons, a survey computes no schedule unless requested: each beacon is compared with
/// each other.
inline constexpr std::size_t kMostScheduledUnasked = 300;
/// Faster than this a pulse is radio or light, which leaves no echoes to wait for.
inline constexpr double kFastestSoundMps = 1e5;

/// The schedule of a survey; no value without sound, without a known range, or with more than
/// kMostScheduledUnasked beacons.
[[nodiscard]] std::optional<FloorSchedule> schedule_of_survey(const SurveyModel& model, const Scene& scene,
                                                              int threads);

}  // namespace octant::survey
