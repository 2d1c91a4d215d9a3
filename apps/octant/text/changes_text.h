// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "apps/octant/session.h"
#include "survey/report/report.h"

namespace octant::app {

/// What changed since an earlier deployment, for people; empty where none was given.
[[nodiscard]] std::string changes_text(const survey::ReportInput& input);
/// The list `changes`, {kind, subject, size, sigma, unit, p} each: what is held to be changed, not all that
/// was compared. p is that of chance after multiple testing. Absent (false) where no earlier deployment was
/// given.
bool add_changes_json(const survey::ReportInput& input, Json& object);

}  // namespace octant::app
