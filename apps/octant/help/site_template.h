// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/run/run_ids.h"

namespace octant::app {

/// What the typical values of a site file are for.
enum class SiteKind { kUltrasound, kUwb, kUnderwater };

/// A site file to fill in: each key with what it is, in words; valid as it is. @param name  of the site
[[nodiscard]] std::string site_template(SiteKind kind, const std::string& name, const io::RunIds& ids);

}  // namespace octant::app
