// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the noise of odometry, as run.yaml and scenarios state it.

#include "io/yaml/yaml_reader.h"
#include "models/run.h"

namespace octant::io {

/// The block `odometry` of a run.yaml and of a scenario.
void read_odometry_keys(YamlMap& odometry, OdometryAccuracy& accuracy);

}  // namespace octant::io
