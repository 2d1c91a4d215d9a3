// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/octant/session.h"
#include "models/change.h"
#include "models/changes/reception.h"
#include "survey/report/report.h"

namespace octant::app {

/// The list `changes`, {kind, subject, size, sigma, unit, p} each: what is held to be changed, not all that
/// was compared. p is that of chance after multiple testing.
/// "A7 stands 46.5 mm (sigma 6.8 mm) from where it was: x +44.0, y +15.0, z -2.0 mm".
[[nodiscard]] std::string in_words(const Change& change);
/// "B3 is silent: 412 arrivals were expected, and 0 received".
[[nodiscard]] std::string in_words(const Silence& silence);
/// What to do about it.
[[nodiscard]] std::string remedy_of(const Change& change);

/// "changed" and each of them with its p: lines of a result.
[[nodiscard]] std::string found_lines(const std::vector<Change>& found);

/// Table of both deployments' beacons and what changed, for people.
[[nodiscard]] std::string changes_text(const survey::Changes& changes);
/// The same of a report; empty where no earlier deployment was given.
[[nodiscard]] std::string changes_text(const survey::ReportInput& input);
/// The list `changes` of a report; absent (false) where no earlier deployment was given.
bool add_changes_json(const survey::ReportInput& input, Json& object);

}  // namespace octant::app
