// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "survey/placement/placement.h"

namespace octant::survey {

/// Result for one number of beacons, placed by the plan and by other methods.
struct ProofRow {
  std::size_t beacons = 0;
  LayoutFigures plan, greedy, regular, random;
};
[[nodiscard]] inline ProofRow proof_row(const Placement& p) {
  return {p.beacons.size(), p.figures, p.greedy, p.regular, p.random};
}

struct ProofSheetInput {
  std::string name;      ///< name of the site
  std::string settings;  ///< goal, algorithms, seed: how to get the same again
  std::string created, program;
  std::vector<ProofRow> rows;
  Placement placement;  ///< placement that is drawn and listed
  std::vector<Eigen::Vector2d> floor_m;
  std::vector<WallPiece> walls;
  std::optional<double> tolerance_m;
};

/// Objective against the number of beacons, a line each for plan, greedy, regular and random: an SVG element.
/// The axis is logarithmic; layouts that leave cells uncovered have no point.
[[nodiscard]] std::string proof_svg(const ProofSheetInput& input);
/// The floor with its walls, the beacons and where they look: an SVG element.
[[nodiscard]] std::string placement_svg(const ProofSheetInput& input);
/// Both with their numbers, as one HTML page without scripts.
[[nodiscard]] std::string proof_sheet_html(const ProofSheetInput& input);

}  // namespace octant::survey
