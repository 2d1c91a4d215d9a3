// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant {

/// Number of states above which a drive is divided into parts where a sample of a log suffices.
inline constexpr std::size_t kLongChain = 4096;
/// Number of states in such a part. It is long compared with the distance over which odometry links states.
inline constexpr std::size_t kStretchNodes = 256;

[[nodiscard]] inline bool is_long_chain(const Segment& s) { return s.last_node - s.first_node > kLongChain; }

/// Part of a segment between two of its nodes, with the observations that depend on no other nodes.
[[nodiscard]] Segment stretch_of(const Trajectory& trajectory, const Segment& segment, std::size_t first_node,
                                 std::size_t last_node);

/// All segments of a trajectory, with long chains cut into parts.
[[nodiscard]] std::vector<Segment> with_chains_cut(const Trajectory& trajectory);

/// Trajectory of some of these segments or parts, each independent of the others.
[[nodiscard]] Trajectory pick_segments(const Trajectory& trajectory, const std::vector<Segment>& segments);

/// Parts of a segment, evenly spread over it.
[[nodiscard]] std::vector<Segment> spread_stretches(const Trajectory& trajectory, const Segment& segment,
                                                    std::size_t count, std::size_t nodes);

}  // namespace octant
