// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to survey/: greedy choice, exchanges, and NLopt on a scene's mounts.

#include <vector>

#include "survey/placement/layout_score.h"
#include "survey/placement/mounts.h"
#include "survey/placement/placement.h"

namespace octant::survey {

struct SearchResult {
  std::vector<std::vector<MountPoint>> layouts;  ///< greedy, exchanged, and what NLopt made of them
  std::size_t evaluations = 0;
  bool interrupted = false;
};

/// One place after the other from a grid, each where it helps most.
[[nodiscard]] std::vector<MountPoint> greedy_layout(const MountSpace& mounts,
                                                    const std::vector<SurveyBeacon>& kept, std::size_t count,
                                                    LayoutScore& score);

/// @param starts  further layouts from which the local algorithm sets out
[[nodiscard]] SearchResult search_layout(const MountSpace& mounts, const std::vector<SurveyBeacon>& kept,
                                         std::size_t count, LayoutScore& score,
                                         const PlacementOptions& options,
                                         const std::vector<std::vector<MountPoint>>& starts);

/// The local algorithm once more from a layout, over the poses that the score looks at now.
[[nodiscard]] std::vector<MountPoint> refine_layout(const MountSpace& mounts,
                                                    const std::vector<SurveyBeacon>& kept,
                                                    const std::vector<MountPoint>& start, LayoutScore& score,
                                                    const PlacementOptions& options, SearchResult& result);

}  // namespace octant::survey
