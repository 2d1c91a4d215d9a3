// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "apps/octant/session.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/survey_input.h"
#include "models/contradiction.h"

namespace octant::app {

/// The next stop that improves the beacons most, and an estimate of the stops that are needed to meet the
/// tolerance (schema `cockpit`, key `next_stop`); null if none can be planned.
/// @param calibration  null: knowledge of the site file alone
[[nodiscard]] Json next_stop_json(const SurveyInput& input, const Calibration* calibration, Session& session);

/// Both names if a contradiction says that two beacons are exchanged, which one tap can accept; else null.
[[nodiscard]] Json exchange_of(const Contradiction& contradiction, const Site& site);

}  // namespace octant::app
