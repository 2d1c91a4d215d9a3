// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

/// One site of a batch: what `octant calibrate` would be given.
struct BatchSite {
  std::string name;  ///< as messages call it; its site file as the list spells it where it has no name
  std::string site;  ///< path
  std::vector<std::string> runs;
  std::string output;  ///< deployment file to write
  std::string report;  ///< empty: none
};

struct Batch {
  std::vector<BatchSite> sites;
  std::vector<std::string> warnings;
};

/// Reads a list of sites:
///   octant_batch: 1
///   sites:
///     - {site: a/site.yaml, runs: [a/monday, a/tuesday], output: a.json, report: a.html}
/// Paths that are not absolute begin at the folder of the list.
/// @param output_folder  where outputs and reports begin instead; may be empty
/// Errors name line and column; two sites that would write the same file are one.
[[nodiscard]] Result<Batch> read_batch(const std::string& path, const std::string& output_folder = "");

}  // namespace octant::io
