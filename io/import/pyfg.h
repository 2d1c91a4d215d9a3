// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "io/import/imported_log.h"
#include "models/support/result.h"

// Factor graphs in the text format of PyFactorGraph (.pyfg), in the plane and in space.
namespace octant::io {

/// True if the first line is a vertex or an edge of such a graph.
[[nodiscard]] bool is_pyfg(const std::string& path);

/// Reads the graph of one robot: edges between its successive poses as odometry, ranges to landmarks as
/// arrivals, and its vertices, which are the true poses, as the reference. Loop closures, priors, relative
/// positions of landmarks, ranges between robots and the other robots are left out, counted in warnings.
/// @param robot  its letter; empty: the robot of the first vertex
/// Errors: kBadInput with the line: numbers that are missing, poses that no vertex describes.
[[nodiscard]] Result<ImportedLog> read_pyfg(const std::string& path, std::string_view robot = {});

}  // namespace octant::io
