// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "models/physics/pose.h"

namespace octant {
namespace {

/// Circle of possible positions for a heading. A range below the height difference puts the vehicle right
/// below the beacon.
Circle circle_of(const SearchRange& r, double cosine, double sine) {
  const double dz = r.p_lever_m.z() - r.p_beacon_map_m.z();
  return {r.p_beacon_map_m.x() - cosine * r.p_lever_m.x() + sine * r.p_lever_m.y(),
          r.p_beacon_map_m.y() - sine * r.p_lever_m.x() - cosine * r.p_lever_m.y(),
          std::sqrt(std::max(r.range_m * r.range_m - dz * dz, 0.0))};
}

/// Two representative arrivals of each beacon: the earliest, since echoes are late, and the middle one, since
/// some are early.
std::pmr::vector<std::array<std::size_t, 2>> representatives(const SearchProblem& problem) {
  std::pmr::vector<std::array<std::size_t, 2>> out(scratch());
  std::pmr::vector<std::size_t> order(scratch());
  for (std::size_t group = 0; group < problem.groups(); ++group) {
    order.clear();
    for (std::size_t i = problem.group_first[group]; i < problem.group_first[group + 1]; ++i)
      order.push_back(i);
    std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
      return problem.ranges[a].range_m < problem.ranges[b].range_m;
    });
    out.push_back({order.front(), order[order.size() / 2]});
  }
  return out;
}

/// Offers a position with the given heading.
void offer(Consensus& consensus, const PlanarState& state, TopList& top) {
  top.offer({state, consensus.score(state, top.worst())});
}

constexpr std::size_t kFirstHeadings = 4;
using FirstHeadings =
    std::array<double, 2 * kFirstHeadings>;  ///< fewer than twice as many, because the stride is rounded down

/// Initial headings at a position: those that some of the bearings imply, or evenly spaced ones.
std::span<const double> first_headings(const SearchProblem& problem, double x_m, double y_m,
                                       FirstHeadings& memory) {
  memory[0] = 0.0;
  if (problem.bearings.empty()) return std::span(memory).first(1);
  std::size_t count = 0;
  const std::size_t stride = std::max<std::size_t>(problem.bearings.size() / kFirstHeadings, 1);
  for (std::size_t i = 0; i < problem.bearings.size(); i += stride) {
    const SearchBearing& b = problem.bearings[i];
    memory[count++] =
        wrap_angle(std::atan2(b.p_reflector_map_m.y() - y_m, b.p_reflector_map_m.x() - x_m) - b.bearing_rad);
  }
  return std::span(memory).first(count);
}

struct Box {
  double x0 = std::numeric_limits<double>::infinity(), y0 = std::numeric_limits<double>::infinity();
  double x1 = -std::numeric_limits<double>::infinity(), y1 = -std::numeric_limits<double>::infinity();
  void add(double x, double y, double margin) {
    x0 = std::min(x0, x - margin);
    y0 = std::min(y0, y - margin);
    x1 = std::max(x1, x + margin);
    y1 = std::max(y1, y + margin);
  }
};

constexpr double kCellsPerStart = 0.125;  ///< starts of a descent for each cell

/// Bounding box of the received beacons, enlarged by a quarter, but not beyond the ranges if they are
/// absolute.
Box search_box(const SearchProblem& problem) {
  Box box;
  for (const SearchRange& r : problem.ranges)
    box.add(r.p_beacon_map_m.x(), r.p_beacon_map_m.y(), problem.lever_m);
  for (const SearchBearing& b : problem.bearings)
    box.add(b.p_reflector_map_m.x(), b.p_reflector_map_m.y(), 0.0);
  const double margin =
      0.25 * std::max({box.x1 - box.x0, box.y1 - box.y0, problem.has_offset ? 0.0 : 2 * problem.span_m});
  return {box.x0 - margin, box.y0 - margin, box.x1 + margin, box.y1 + margin};
}

}  // namespace

int intersect(const Circle& a, const Circle& b, std::array<PlanarState, 2>& out) {
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m, d = std::hypot(dx, dy);
  if (d < 1e-6) return 0;
  double along = (d * d + a.radius_m * a.radius_m - b.radius_m * b.radius_m) / (2 * d);
  const double across2 = a.radius_m * a.radius_m - along * along;
  if (across2 < 0)
    along = d > a.radius_m + b.radius_m ? 0.5 * (a.radius_m + d - b.radius_m)
                                        : 0.5 * (along + std::copysign(a.radius_m, along));
  const double across = std::sqrt(std::max(across2, 0.0));
  for (int side = 0; side < 2; ++side) {
    const double h = side == 0 ? across : -across;
    out[static_cast<std::size_t>(side)].x_m = a.x_m + (along * dx - h * dy) / d;
    out[static_cast<std::size_t>(side)].y_m = a.y_m + (along * dy + h * dx) / d;
  }
  return across2 > 0 ? 2 : 1;
}

std::pmr::vector<std::array<std::size_t, 2>> choose_pairs(const SearchProblem& problem,
                                                          std::size_t max_pairs) {
  std::pmr::vector<std::array<std::size_t, 2>> pairs(scratch());
  pairs.reserve(max_pairs);
  if (!problem.common_bias) {
    // Along a drive each arrival has its own position, so pairs cover all beacons and all time differences.
    const std::size_t n = problem.ranges.size();
    for (std::size_t stride = std::max<std::size_t>(n / 2, 1); pairs.size() < max_pairs && stride > 0;
         stride = stride * 2 / 3)
      for (std::size_t i = 0; i + stride < n && pairs.size() < max_pairs;
           i += std::max<std::size_t>(n / 8, 1))
        pairs.push_back({i, i + stride});
    return pairs;
  }
  const auto stand_for = representatives(problem);
  constexpr std::array<std::array<std::size_t, 2>, 4> kMix = {{{0, 0}, {1, 1}, {0, 1}, {1, 0}}};
  const std::size_t n = stand_for.size();
  for (const auto& mix : kMix)
    for (std::size_t step = 1; step < n;
         ++step)  // neighbours in the list first, so that all beacons are used equally
      for (std::size_t a = 0; a + step < n; ++a) {
        const std::array<std::size_t, 2> pair = {stand_for[a][mix[0]], stand_for[a + step][mix[1]]};
        if (std::ranges::find(pairs, pair) == pairs.end()) pairs.push_back(pair);
        if (pairs.size() >= max_pairs) return pairs;
      }
  return pairs;
}

double TopList::worst() const {
  return list_.size() < size_ ? std::numeric_limits<double>::infinity() : list_.back().score;
}

void TopList::offer(const Candidate& candidate) {
  const PlanarState& state = candidate.state;
  const double score = candidate.score;
  if (!(score < worst())) return;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const PlanarState& s = list_[i].state;
    if (std::abs(s.x_m - state.x_m) > apart_m_ || std::abs(s.y_m - state.y_m) > apart_m_ ||
        std::abs(wrap_angle(s.heading_rad - state.heading_rad)) > apart_rad_)
      continue;
    if (list_[i].score <= score) return;
    list_.erase(list_.begin() + static_cast<std::ptrdiff_t>(i));
    break;
  }
  const auto at = std::ranges::upper_bound(list_, score, {}, &Candidate::score);
  list_.insert(at, candidate);
  if (list_.size() > size_) list_.pop_back();
}

int pair_states(const SearchProblem& problem, const std::array<std::size_t, 2>& pair, double cosine,
                double sine, std::array<PlanarState, 2>& meet) {
  return intersect(circle_of(problem.ranges[pair[0]], cosine, sine),
                   circle_of(problem.ranges[pair[1]], cosine, sine), meet);
}

void propose_from_pairs(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                        TopList& top) {
  const auto pairs = choose_pairs(problem, static_cast<std::size_t>(options.max_pairs));
  const int headings = problem.lever_m > 1e-6 ? options.headings : 1;
  std::array<PlanarState, 2> meet;
  for (int k = 0; k < headings; ++k) {
    const double heading = wrap_angle(2 * std::numbers::pi * k / headings);
    const double cosine = std::cos(heading), sine = std::sin(heading);
    for (const auto& pair : pairs) {
      const int count = pair_states(problem, pair, cosine, sine, meet);
      for (int side = 0; side < count; ++side) {
        meet[static_cast<std::size_t>(side)].heading_rad = heading;
        offer(consensus, meet[static_cast<std::size_t>(side)], top);
      }
    }
  }
}

void propose_from_grid(const SearchProblem& problem, const SearchOptions& options, Consensus& consensus,
                       TopList& top) {
  const Box box = search_box(problem);
  // Each cell is a start of a descent, not a sample: hyperbolas form long valleys that would require a very
  // fine grid.
  const double spacing =
      std::sqrt((box.x1 - box.x0) * (box.y1 - box.y0) / (kCellsPerStart * options.max_cells));
  if (!(spacing > 0)) return;
  const double size = std::max(box.x1 - box.x0, box.y1 - box.y0);
  const double widths[] = {0.3 * size, 0.08 * size, std::max(0.02 * size, problem.lever_m)};
  // With short lever arms the heading hardly affects the ranges at this width: positions first, then headings
  // for the best of them.
  TopList places(2 * options.keep, widths[2], 0.3);
  consensus.judge_shadows(false);
  FirstHeadings headings_here;
  const auto steps = [spacing](double from, double to) {
    return static_cast<int>(std::ceil((to - from) / spacing - 0.5));
  };
  for (int row = 0; row < steps(box.y0, box.y1); ++row)
    for (int column = 0; column < steps(box.x0, box.x1); ++column) {
      const double x = box.x0 + (column + 0.5) * spacing, y = box.y0 + (row + 0.5) * spacing;
      for (const double heading : first_headings(problem, x, y, headings_here)) {
        PlanarState state{x, y, heading, 0.0};
        if (problem.has_offset) state.offset_m = consensus.best_offset(state);
        for (const double width_m : widths) {
          consensus.set_extra_sigma(width_m);
          consensus.refine(state, 4);
        }
        offer(consensus, state, places);
      }
    }
  consensus.judge_shadows(true);
  consensus.set_extra_sigma(widths[2]);
  const int headings = problem.lever_m > 1e-6 ? options.headings : 1;
  for (const Candidate& place : places.list())
    for (int k = 0; k < headings; ++k) {
      PlanarState state = place.state;
      state.heading_rad = wrap_angle(state.heading_rad + 2 * std::numbers::pi * k / headings);
      consensus.refine(state, 3);
      offer(consensus, state, top);
    }
}

}  // namespace octant
