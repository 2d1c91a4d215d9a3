// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: greedy choice, exchanges, and NLopt on a scene's mounts.

#include <vector>

#include "survey/placement/layout_score.h"
#include "survey/placement/mounts.h"
#include "survey/placement/placement_options.h"

namespace octant::survey {

/// Positions that a search may use: the mounts of a scene, in addition to existing beacons.
struct SearchSpace {
  MountSpace mounts;
  std::vector<SurveyBeacon> kept;
  /// Kept ones first.
  [[nodiscard]] std::vector<SurveyBeacon> beacons_at(const MountLayout& layout) const;
};

struct SearchResult {
  std::vector<MountLayout> layouts;  ///< greedy, exchanged, and what NLopt made of them
  std::size_t evaluations = 0;
  bool interrupted = false;
};

/// One place after the other from a grid, each where it helps most.
[[nodiscard]] MountLayout greedy_layout(const SearchSpace& space, std::size_t count, LayoutScore& score);

/// @param starts  further layouts from which the local algorithm sets out
[[nodiscard]] SearchResult search_layout(const SearchSpace& space, std::size_t count, LayoutScore& score,
                                         const PlacementOptions& options,
                                         const std::vector<MountLayout>& starts);

/// The local algorithm once more from a layout, over the poses that the score looks at now.
[[nodiscard]] MountLayout refine_layout(const SearchSpace& space, const MountLayout& start,
                                        LayoutScore& score, const PlacementOptions& options,
                                        SearchResult& result);

}  // namespace octant::survey
