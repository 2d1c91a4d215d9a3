// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/run/run_ids.h"

namespace octant::app {

/// Kinds of systems with typical values for a site file.
enum class SiteKind { kUltrasound, kUwb, kUnderwater };

/// A commented site file for the user to fill in, valid as it is. @param name  name of the site
[[nodiscard]] std::string site_template(SiteKind kind, const std::string& name, const io::RunIds& ids);

}  // namespace octant::app
