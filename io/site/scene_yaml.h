// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "models/scene.h"
#include "models/support/result.h"

namespace octant::io {

/// Reads the `scene:` block of a site file; no value if it is missing. Plans that the block imports (DXF, ROS
/// maps) are found relative to the site file. Errors name file, line, column and element. The module survey
/// checks whether the geometry is plausible.
[[nodiscard]] Result<std::optional<Scene>> read_site_scene(const std::string& site_path);

/// A file with a scene alone: `octant_scene: 1` and the keys of the block.
[[nodiscard]] Result<Scene> read_scene(const std::string& path);

}  // namespace octant::io
