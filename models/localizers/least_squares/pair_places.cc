// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/pair_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/physics/pose.h"

namespace octant {
namespace {

constexpr double kNoiseSigmas = 4.0;
constexpr double kFlatCutSine = 1e-3;  ///< smallest sine of the angle at which circles intersect
constexpr double kMostReach =
    0.2;  ///< share of the distance of the nearer beacon within which ranges are nearly linear
constexpr Eigen::Index kFewSectors = 3;  ///< with few sectors left, narrower ones are worthwhile
constexpr double kInfinite = std::numeric_limits<double>::infinity();

Eigen::Vector2d from_beacon(const PairPlace& place, const SearchRange& r) {
  return {place.x_m - r.p_beacon_map_m.x(), place.y_m - r.p_beacon_map_m.y()};
}

/// Contribution of the lever arm to a range in horizontal direction u, by cosine and sine of the heading.
Eigen::RowVector2d lever_by_turn(const SearchRange& r, const Eigen::Vector2d& u) {
  return {u.x() * r.p_lever_m.x() + u.y() * r.p_lever_m.y(),
          u.y() * r.p_lever_m.x() - u.x() * r.p_lever_m.y()};
}

}  // namespace

PairPlaces::PairPlaces(const SearchProblem& problem, const Consensus& consensus, const Discord& discord,
                       int headings)
    : problem_(problem), discord_(discord) {
  const Eigen::Index count = std::clamp(headings, 1, kMostHeadings);
  sectors_.cosine.resize(count);
  sectors_.sine.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const double heading = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(count);
    sectors_.cosine[k] = std::cos(heading);
    sectors_.sine[k] = std::sin(heading);
  }
  // If the heading has no effect, only one is tried.
  sectors_.half_width_rad = count > 1 ? std::numbers::pi / static_cast<double>(count) : 0.0;
  finer_.half_width_rad = sectors_.half_width_rad / kFiner;
  for (int k = 0; k < kFiner; ++k)
    finer_turns_[static_cast<std::size_t>(k)] = PlanarTurn((2 * k + 1 - kFiner) * finer_.half_width_rad);
  limits_.reserve(problem.ranges.size());
  group_caps_.reserve(problem.groups());
  earliest_.reserve(problem.groups());
  for (std::size_t group = 0; group < problem.groups(); ++group) {
    const std::size_t first = problem.group_first[group], last = problem.group_first[group + 1];
    group_caps_.push_back(last - first > 1 ? consensus.group_cap(group) + discord.cost[group] : kInfinite);
    earliest_.push_back(first);
    for (std::size_t i = first; i < last; ++i) {
      const SearchRange& r = problem.ranges[i];
      if (r.range_m < problem.ranges[earliest_.back()].range_m) earliest_.back() = i;
      const double dz = r.p_lever_m.z() - r.p_beacon_map_m.z(), variance_m2 = consensus.variance_m2(i, group);
      const double flat_m = std::sqrt(std::max(r.range_m * r.range_m - dz * dz, 0.0));
      // Noise and bias separately can cost less than both together, but at least half of it.
      const double apart = consensus.has_bias(group) ? 2.0 : 1.0;
      limits_.push_back({{r.p_beacon_map_m.x(), r.p_beacon_map_m.y(), flat_m},
                         dz * dz,
                         r.p_lever_m.head<2>().norm(),
                         kNoiseSigmas * std::sqrt(variance_m2) * r.range_m / std::max(flat_m, 1e-6),
                         apart * variance_m2,
                         consensus.least_caps(i, group)});
    }
  }
}

double PairPlaces::least_score(const PairPlace& place, double bound) const {
  const double first_m = limits_[place.pair[0]].reach_m() + place.bend_m,
               second_m = limits_[place.pair[1]].reach_m() + place.bend_m;
  // Cost common to all regions, plus the additional cost of this one.
  double total = discord_.total;
  for (std::size_t group = 0; group < problem_.groups() && total <= bound; ++group) {
    // If a beacon's arrivals agree, one represents all; otherwise all are needed to exceed their common cost.
    const bool agree = discord_.cost[group] == 0.0;
    const std::size_t first = agree ? earliest_[group] : problem_.group_first[group],
                      last = agree ? first + 1 : problem_.group_first[group + 1];
    double of_group = 0.0;
    for (std::size_t i = first; i < last; ++i) {
      const Limit& limit = limits_[i];
      const double dx = place.x_m - limit.circle.x_m, dy = place.y_m - limit.circle.y_m;
      const double distance_m = std::max(std::sqrt(dx * dx + dy * dy + limit.dz2_m2), 1e-6);
      const double moved_m =
          place.is_flat ? place.reach_m
                        : (std::abs(dx * place.by_ranges(0, 0) + dy * place.by_ranges(1, 0)) * first_m +
                           std::abs(dx * place.by_ranges(0, 1) + dy * place.by_ranges(1, 1)) * second_m) /
                                  distance_m +
                              place.bend_m;
      of_group += limit.least_cost(problem_.ranges[i].range_m - distance_m, moved_m + limit.lever_m);
    }
    total += std::max(std::min(of_group, group_caps_[group]) - discord_.cost[group], 0.0);
  }
  return total;
}

PairPlace PairPlaces::place_on(const std::array<std::size_t, 2>& pair, int side,
                               const PlanarState& at) const {
  PairPlace place{.pair = pair, .side = side, .is_flat = true, .is_long = true, .x_m = at.x_m, .y_m = at.y_m};
  const Limit &a = limits_[pair[0]], &b = limits_[pair[1]];
  const Eigen::Vector2d u = from_beacon(place, problem_.ranges[pair[0]]) / a.circle.radius_m,
                        v = from_beacon(place, problem_.ranges[pair[1]]) / b.circle.radius_m;
  const double sine = u.x() * v.y() - u.y() * v.x(), across2 = 1.0 - std::abs(u.dot(v)),
               nearest_m = std::min(a.circle.radius_m, b.circle.radius_m);
  if (!(std::abs(sine) > kFlatCutSine && across2 > 0)) return place;
  // The pose lies in the intersection of two strips: |u.d| <= reach, with u the directions to both beacons.
  const double reach_m = std::max(a.reach_m(), b.reach_m()) * std::sqrt(2.0 / across2);
  if (!(reach_m < kMostReach * nearest_m)) return place;
  place.is_flat = place.is_long = false;
  // Circles bend, so distant regions are larger.
  place.reach_m = reach_m * (1.0 + 1.5 * reach_m / nearest_m);
  place.bend_m = 0.5 * place.reach_m * place.reach_m / nearest_m;
  place.by_ranges << v.y() / sine, -u.y() / sine, -v.x() / sine, u.x() / sine;
  return place;
}

/// Region where circles nearly touch: half their chord is at most that of circles displaced by their reach.
/// @return false if they do not meet even then
bool PairPlaces::flat_place(const std::array<std::size_t, 2>& pair, PairPlace& place) const {
  const Limit &a = limits_[pair[0]], &b = limits_[pair[1]];
  const double dx = b.circle.x_m - a.circle.x_m, dy = b.circle.y_m - a.circle.y_m, d2 = dx * dx + dy * dy;
  const double r = a.circle.radius_m, s = b.circle.radius_m, e = a.reach_m(), f = b.reach_m();
  // half chord^2 = r^2 - along^2, along = (d^2 + r^2 - s^2) / (2 d)
  const double share = 0.5 * (d2 + r * r - s * s) / d2, along_by_r = r / d2, along_by_s = s / d2;
  const double chord2 = r * r - share * share * d2;
  const double more =
      (r + e) * (r + e) - r * r + 2.0 * std::abs(share) * d2 * (along_by_r * e + along_by_s * f);
  if (chord2 + more < 0.0) return false;
  const double shift_m = std::sqrt(d2) * (along_by_r * e + along_by_s * f);
  place = {.pair = pair,
           .is_flat = true,
           .is_long = true,
           .x_m = a.circle.x_m + share * dx,
           .y_m = a.circle.y_m + share * dy};
  place.reach_m = std::sqrt(chord2 + more + shift_m * shift_m);
  return true;
}

std::optional<PairPlace> PairPlaces::narrowed(const PairPlace& flat, double bound) const {
  constexpr int kParts = 12;
  const Limit &a = limits_[flat.pair[0]], &b = limits_[flat.pair[1]];
  const double r = a.circle.radius_m, e = a.reach_m();
  const Eigen::Vector2d to_middle(flat.x_m - a.circle.x_m, flat.y_m - a.circle.y_m);
  const double along_m = to_middle.norm();
  // Otherwise the region surrounds the beacon.
  if (!(flat.reach_m < along_m && flat.reach_m < r - e)) return flat;
  // The region has the width of the reach and lies on the ring of the first range; discs cover that part of
  // the ring.
  const double half_rad = std::asin(flat.reach_m / (r - e)) / kParts;
  const double disc_m = std::sqrt(e * e + 2.0 * r * (r + e) * (1.0 - std::cos(half_rad)));
  const PlanarTurn step(2.0 * half_rad);
  PlanarTurn at(to_middle.x() / along_m, to_middle.y() / along_m);
  at = at * PlanarTurn(-(kParts - 1) * half_rad);
  PairPlace part = flat, first, last;
  double least = kInfinite;
  for (int k = 0; k < kParts; ++k, at = at * step) {
    part.x_m = a.circle.x_m + r * at.cosine;
    part.y_m = a.circle.y_m + r * at.sine;
    part.reach_m = disc_m;
    const double from_second_m = std::hypot(part.x_m - b.circle.x_m, part.y_m - b.circle.y_m);
    if (std::abs(from_second_m - b.circle.radius_m) > b.reach_m() + disc_m) continue;
    const double score = least_score(part, bound);
    if (score > bound) continue;
    if (least == kInfinite) first = part;
    last = part;
    least = std::min(least, score);
  }
  if (least == kInfinite) return std::nullopt;
  part.x_m = 0.5 * (first.x_m + last.x_m);
  part.y_m = 0.5 * (first.y_m + last.y_m);
  // The arc is not farther from the middle of the chord than the chord's ends are.
  part.reach_m = 0.5 * std::hypot(last.x_m - first.x_m, last.y_m - first.y_m) + disc_m;
  part.is_long = !(part.reach_m < kMostReach * std::min(r, b.circle.radius_m));
  part.least_score = least;
  return part;
}

std::pmr::vector<PairPlace> PairPlaces::within(std::span<const std::array<std::size_t, 2>> pairs,
                                               double bound) const {
  std::pmr::vector<PairPlace> out(scratch());
  out.reserve(2 * pairs.size());
  const auto add_within_bound = [&](PairPlace& place) {
    place.least_score = least_score(place, bound);
    if (place.least_score <= bound) out.push_back(place);
  };
  std::array<PlanarState, 2> meet;
  for (const auto& pair : pairs) {
    const int count = intersect(limits_[pair[0]].circle, limits_[pair[1]].circle, meet);
    if (count == 0) continue;
    std::array<PairPlace, 2> places = {place_on(pair, 0, meet[0]), place_on(pair, 1, meet[1])};
    if (count < 2 || places[0].is_flat || places[1].is_flat) {
      if (flat_place(pair, places[0])) add_within_bound(places[0]);
      continue;
    }
    for (PairPlace& place : places) {
      place.half_gap_m = 0.5 * std::hypot(meet[1].x_m - meet[0].x_m, meet[1].y_m - meet[0].y_m);
      add_within_bound(place);
    }
  }
  // Uncertain regions come last, when the bound is low.
  std::ranges::sort(out, [](const PairPlace& a, const PairPlace& b) {
    if (a.is_flat != b.is_flat) return b.is_flat;
    return a.least_score != b.least_score ? a.least_score < b.least_score : a.reach_m < b.reach_m;
  });
  return out;
}

/// Both circles are satisfied: u (move + lever) = 0 for both, with u the directions from their beacons.
Eigen::Matrix2d PairPlaces::place_by_turn(const PairPlace& place) const {
  Eigen::Matrix2d levers;
  for (int k = 0; k < 2; ++k) {
    const SearchRange& r = problem_.ranges[place.pair[static_cast<std::size_t>(k)]];
    levers.row(k) = lever_by_turn(r, from_beacon(place, r).normalized());
  }
  return -place.by_ranges * levers;
}

void PairPlaces::add_least_costs(const PairPlace& place, const Eigen::Matrix2d& place_by_turn,
                                 std::size_t group, Sectors& sectors) {
  of_group_.setZero(sectors.cosine.size());
  const Eigen::Vector2d pair_margin_m(limits_[place.pair[0]].noise_m + place.bend_m,
                                      limits_[place.pair[1]].noise_m + place.bend_m);
  for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i) {
    const SearchRange& r = problem_.ranges[i];
    const Limit& limit = limits_[i];
    const Eigen::Vector2d v = from_beacon(place, r);
    const double distance_m = std::max(std::sqrt(v.squaredNorm() + limit.dz2_m2), 1e-6);
    const Eigen::Vector2d u = v / distance_m;
    const Eigen::RowVector2d by_turn = u.transpose() * place_by_turn + lever_by_turn(r, u);
    const double margin_m = sectors.half_width_rad * by_turn.norm() +
                            (u.transpose() * place.by_ranges).cwiseAbs() * pair_margin_m + place.bend_m;
    const double information = 0.5 / limit.variance_m2;
    late_m_ = r.range_m - distance_m - by_turn.x() * sectors.cosine - by_turn.y() * sectors.sine;
    of_group_ += ((late_m_ - margin_m).max(0.0).square() * information).min(limit.caps.late) +
                 ((late_m_ + margin_m).min(0.0).square() * information).min(limit.caps.early);
  }
  sectors.least += (of_group_.min(group_caps_[group]) - discord_.cost[group]).max(0.0);
}

bool PairPlaces::bound_scores(const PairPlace& place, double bound, Sectors& sectors) {
  sectors.least.setConstant(sectors.cosine.size(), discord_.total);
  const Eigen::Matrix2d by_turn = place_by_turn(place);
  for (std::size_t group = 0; group < problem_.groups(); ++group) {
    add_least_costs(place, by_turn, group, sectors);
    if (sectors.least.minCoeff() > bound) return false;
  }
  return true;
}

/// Splits the sectors within the bound and uses the lowest bound of the parts, since ranges are less
/// uncertain in narrow sectors.
bool PairPlaces::bound_finer_scores(const PairPlace& place, double bound) {
  const Eigen::Index within = (sectors_.least <= bound).count();
  if (sectors_.half_width_rad == 0.0 || within > kFewSectors) return true;
  finer_.cosine.resize(within * kFiner);
  finer_.sine.resize(within * kFiner);
  Eigen::Index at = 0;
  for (Eigen::Index k = 0; k < sectors_.least.size(); ++k) {
    if (sectors_.least[k] > bound) continue;
    for (const PlanarTurn& off : finer_turns_) {
      const PlanarTurn turn = PlanarTurn(sectors_.cosine[k], sectors_.sine[k]) * off;
      finer_.cosine[at] = turn.cosine;
      finer_.sine[at++] = turn.sine;
    }
  }
  if (!bound_scores(place, bound, finer_)) return false;
  at = 0;
  for (Eigen::Index k = 0; k < sectors_.least.size(); ++k) {
    if (sectors_.least[k] > bound) continue;
    sectors_.least[k] = std::max(sectors_.least[k], finer_.least.segment<kFiner>(at).minCoeff());
    at += kFiner;
  }
  return true;
}

void PairPlaces::propose(const PairPlace& place, Consensus& widened, double bound, TopList& top) {
  if (place.is_flat)
    sectors_.least.setConstant(sectors_.cosine.size(), place.least_score);
  else if (!bound_scores(place, bound, sectors_) || !bound_finer_scores(place, bound))
    return;
  std::array<PlanarState, 2> meet;
  for (Eigen::Index k = 0; k < sectors_.least.size(); ++k) {
    if (sectors_.least[k] > bound) continue;
    const PlanarTurn turn(sectors_.cosine[k], sectors_.sine[k]);
    const int count = pair_states(problem_, place.pair, turn.cosine, turn.sine, meet);
    const double heading =
        2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(sectors_.least.size());
    for (int side = place.is_flat ? 0 : place.side; side < (place.is_flat ? count : place.side + 1); ++side) {
      PlanarState& state = meet[static_cast<std::size_t>(side)];
      state.heading_rad = wrap_angle(heading);
      if (count > 0) top.offer({state, widened.score(state, turn, top.worst()), sectors_.least[k]});
    }
  }
}

}  // namespace octant
