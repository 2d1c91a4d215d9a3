// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "models/trajectory/trajectory.h"

namespace octant {

/// A drive of more states than this counts as many stretches where a part of a log is enough.
inline constexpr std::size_t kLongChain = 4096;
/// States of such a stretch: long against the way over which odometry ties states together.
inline constexpr std::size_t kStretchNodes = 256;

[[nodiscard]] inline bool is_long_chain(const Segment& s) { return s.last_node - s.first_node > kLongChain; }

/// The part of a segment between two of its nodes, with the observations that touch no other.
[[nodiscard]] Segment stretch_of(const Trajectory& trajectory, const Segment& segment, std::size_t first_node,
                                 std::size_t last_node);

/// All segments of a trajectory, of long chains the stretches.
[[nodiscard]] std::vector<Segment> with_chains_cut(const Trajectory& trajectory);

/// A trajectory of some of these segments, or of stretches of them, each on its own.
[[nodiscard]] Trajectory pick_segments(const Trajectory& trajectory, const std::vector<Segment>& segments);

/// Evenly spread stretches of a segment.
[[nodiscard]] std::vector<Segment> spread_stretches(const Trajectory& trajectory, const Segment& segment,
                                                    std::size_t count, std::size_t nodes);

}  // namespace octant
