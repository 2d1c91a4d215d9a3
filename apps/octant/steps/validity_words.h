// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/steps/steps.h"

namespace octant::app {

/// Warns about recordings at temperatures or positions outside the calibration, and notes those without a
/// temperature.
void warn_outside_validity(const Deployment& deployment, const std::vector<MeasurementLog>& runs,
                           const Localization& localization, Session& session);

/// Temperature assumed for recordings that state none. Null if all state one, or if the speed does not depend
/// on it or was estimated from the arrivals.
[[nodiscard]] Json assumed_temperature_json(const Deployment& deployment, const Localization& localization,
                                            const std::vector<MeasurementLog>& runs);
/// Speeds estimated for runs at an unknown temperature: {run, determined, taken, offset_mps, sigma_mps,
/// temperature_degC, temperature_sigma_degC, poses, arrivals}.
[[nodiscard]] Json speeds_json(const Localization& localization, const std::vector<MeasurementLog>& runs);

/// Warns if a recalibration is overdue according to the validity period of the site.
void warn_if_overdue(const Deployment& deployment, Session& session);
/// "recalibrate by 2027-05-01 ...": a line of a result; empty without a date.
[[nodiscard]] std::string due_line(const Deployment& deployment);
/// {created, age_days, due, overdue}; unknown values are null.
[[nodiscard]] Json calibration_age_json(const Deployment& deployment);

/// Head of a result for `octant history`: kind, site, created, deployment {path, digest}, temperature_degC of
/// the recordings, program.
/// @param kind  "verification" or "monitoring"
[[nodiscard]] Json result_head(const std::string& kind, const std::string& deployment_path,
                               const Deployment& deployment, const std::vector<MeasurementLog>& runs);

}  // namespace octant::app
