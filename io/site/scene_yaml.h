// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "models/scene.h"
#include "models/support/result.h"

namespace octant::io {

/// The `scene:` block of a site file; nothing where it has none. Plans that the block imports (DXF, ROS maps)
/// are read from beside the site file. Errors name file, line, column and element; whether its geometry makes
/// sense is survey's to say.
[[nodiscard]] Result<std::optional<Scene>> read_site_scene(const std::string& site_path);

/// A file with a scene alone: `octant_scene: 1` and the keys of the block.
[[nodiscard]] Result<Scene> read_scene(const std::string& path);

}  // namespace octant::io
