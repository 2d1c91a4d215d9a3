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

/// A significant change in words: "A7 stands 46.5 mm (sigma 6.8 mm) from where it was: x +44.0, y +15.0, z
/// -2.0 mm". JSON lists changes as {kind, subject, size, sigma, unit, p}, without the insignificant ones; p
/// is corrected for multiple testing.
[[nodiscard]] std::string in_words(const Change& change);
/// "B3 is silent: 412 arrivals were expected, and 0 received".
[[nodiscard]] std::string in_words(const Silence& silence);
/// Advice for a change.
[[nodiscard]] std::string remedy_of(const Change& change);

/// Lines of a result: "changed", and each change with its p value.
[[nodiscard]] std::string found_lines(const std::vector<Change>& found);

/// Table of the beacons of both deployments and the changes, for people.
[[nodiscard]] std::string changes_text(const survey::Changes& changes);
/// The table for a report; empty without an earlier deployment.
[[nodiscard]] std::string changes_text(const survey::ReportInput& input);
/// Adds the list `changes` of a report; returns false without an earlier deployment.
bool add_changes_json(const survey::ReportInput& input, Json& object);

}  // namespace octant::app
