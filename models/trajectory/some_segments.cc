// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "models/trajectory/stretches.h"

namespace octant {

Segment stretch_of(const Trajectory& t, const Segment& segment, std::size_t first_node,
                   std::size_t last_node) {
  Segment out = segment;
  out.first_node = first_node;
  out.last_node = last_node;
  // The last node has no observations that reach beyond it, so those on it with alpha > 0 are excluded as
  // well.
  for_each_list([&](auto list, auto first, auto last) {
    out.*first = first_of_node(t.*list, first_node, segment.*first, segment.*last);
    out.*last = first_of_node(t.*list, last_node - 1, out.*first, segment.*last);
  });
  return out;
}

Trajectory pick_segments(const Trajectory& t, const std::vector<Segment>& segments) {
  Trajectory few;
  static_cast<StateSpace&>(few) = t;
  few.T_hear_send = t.T_hear_send;
  for (const Segment& from : segments) {
    Segment to;
    const std::size_t shift = few.nodes.size() - from.first_node;  // modulo 2^n, like the sum below
    const auto append = [](const auto& all, std::size_t first, std::size_t last, auto& some) {
      some.insert(some.end(), all.begin() + static_cast<std::ptrdiff_t>(first),
                  all.begin() + static_cast<std::ptrdiff_t>(last));
    };
    to.first_node = few.nodes.size();
    append(t.nodes, from.first_node, from.last_node, few.nodes);
    to.last_node = few.nodes.size();
    for_each_list([&](auto list, auto first, auto last) {
      auto& some = few.*list;
      to.*first = some.size();
      append(t.*list, from.*first, from.*last, some);
      to.*last = some.size();
      for (std::size_t i = to.*first; i < to.*last; ++i)
        some[i].node = static_cast<decltype(some[i].node)>(some[i].node + shift);
    });
    few.segments.push_back(to);
  }
  return few;
}

std::vector<Segment> spread_stretches(const Trajectory& t, const Segment& segment, std::size_t count,
                                      std::size_t nodes) {
  std::vector<Segment> out;
  const std::size_t all = segment.last_node - segment.first_node;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = segment.first_node + i * all / count;
    out.push_back(stretch_of(t, segment, first, std::min(segment.last_node, first + nodes)));
  }
  return out;
}

std::vector<Segment> with_chains_cut(const Trajectory& t) {
  std::vector<Segment> all;
  for (const Segment& s : t.segments) {
    if (!is_long_chain(s)) {
      all.push_back(s);
      continue;
    }
    for (std::size_t first = s.first_node; first < s.last_node; first += kStretchNodes)
      all.push_back(stretch_of(t, s, first, std::min(s.last_node, first + kStretchNodes)));
  }
  return all;
}

Trajectory some_segments(const Trajectory& t, std::size_t stride) {
  if (stride == 1) return t;
  const std::vector<Segment> all = with_chains_cut(t);
  std::vector<Segment> some;
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  return pick_segments(t, some);
}

}  // namespace octant
