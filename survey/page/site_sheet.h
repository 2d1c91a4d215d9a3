// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/deployment.h"

namespace octant::survey {

/// Content of a beacon's tag for a camera: JSON with the site, the beacon, its position and the deployment's
/// digest.
[[nodiscard]] std::string beacon_tag(const Deployment& deployment, const DeploymentBeacon& beacon,
                                     const std::string& digest);

/// A QR code (ISO/IEC 18004, level M) with its quiet zone, black on white. Empty where the text is too long
/// for one.
[[nodiscard]] std::string qr_svg(const std::string& text);

/// Sheets to print and cut out: each beacon with its coordinates, its delay and its tag. One page without a
/// script.
/// @param digest  of the deployment file; it distinguishes the sheet from an older one
[[nodiscard]] std::string site_sheet_html(const Deployment& deployment, const std::string& digest);

}  // namespace octant::survey
