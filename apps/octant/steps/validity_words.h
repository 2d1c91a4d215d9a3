// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/steps/steps.h"

namespace octant::app {

/// Warns of recordings in air or at places for which the deployment was not calibrated, and notes which state
/// no temperature.
void warn_outside_validity(const Deployment& deployment, const std::vector<MeasurementLog>& runs,
                           const Localization& localization, Session& session);

/// Temperature that was taken for recordings that state none; null where all do, or where the speed does not
/// depend on it or was taken from the arrivals.
[[nodiscard]] Json assumed_temperature_json(const Deployment& deployment, const Localization& localization,
                                            const std::vector<MeasurementLog>& runs);
/// What the arrivals of each run at an unknown temperature say of its speed: {run, determined, taken,
/// offset_mps, sigma_mps, temperature_degC, temperature_sigma_degC, poses, arrivals}.
[[nodiscard]] Json speeds_json(const Localization& localization, const std::vector<MeasurementLog>& runs);

/// Warns where a recalibration is overdue by the validity that the site states.
void warn_if_overdue(const Deployment& deployment, Session& session);
/// "recalibrate by 2027-05-01 ...": a line of a result; empty where no date is told.
[[nodiscard]] std::string due_line(const Deployment& deployment);
/// {created, age_days, due, overdue}; null what is not known.
[[nodiscard]] Json calibration_age_json(const Deployment& deployment);

/// What a result says of itself, so that `octant history` can put it down: kind, site, created, deployment
/// {path, digest}, temperature_degC of the recordings, program.
/// @param kind  "verification" or "monitoring"
[[nodiscard]] Json result_head(const std::string& kind, const std::string& deployment_path,
                               const Deployment& deployment, const std::vector<MeasurementLog>& runs);

}  // namespace octant::app
