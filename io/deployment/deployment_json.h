// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/deployment.h"
#include "models/support/result.h"

namespace octant::io {

/// Text of a deployment file (contract: deployment.json), with a digest of its own content so that alteration
/// is noticed.
[[nodiscard]] std::string deployment_to_json(const Deployment& deployment);
/// Serialises the document for a file and reads it back. Errors: numbers that are not finite, and whatever
/// else readers refuse.
[[nodiscard]] Result<std::string> checked_deployment_json(const std::string& path,
                                                          const Deployment& deployment);
/// Refuses a site file that is given instead of a deployment, with a message that says so.
[[nodiscard]] Result<void> check_no_site_file(const std::string& text, const std::string& file);
/// Reads a deployment: read(write(x)) == x. Refuses an unknown version, a truncated or altered file, non-
/// finite numbers.
[[nodiscard]] Result<Deployment> deployment_from_json(const std::string& text, const std::string& file);
/// SHA-256 of the content of a deployment file (layout does not matter): the value of its `digest`, if it has
/// one.
[[nodiscard]] Result<std::string> deployment_digest(const std::string& path);
[[nodiscard]] Result<Deployment> read_deployment(const std::string& path);
[[nodiscard]] Result<void> write_deployment(const std::string& path, const Deployment& deployment);

}  // namespace octant::io
