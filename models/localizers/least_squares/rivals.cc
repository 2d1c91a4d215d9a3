// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/rivals.h"

#include <algorithm>
#include <cmath>

namespace octant {
namespace {

constexpr double kAgreeSigmas = 4.0;
constexpr double kWidth2 = 0.01;        ///< beacons' scatter across to along, squared, that is a line
constexpr std::size_t kMostSets = 600;  ///< of beacons left out

/// What the arrivals of some beacons tell together.
struct Agreement {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< x, y, heading
  double beacons = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  std::size_t paths = 0;

  void add(const Agreement& o) {
    information += o.information;
    beacons += o.beacons, x += o.x, y += o.y, xx += o.xx, xy += o.xy, yy += o.yy;
    paths += o.paths;
  }
  void take(const Agreement& o) {
    information -= o.information;
    beacons -= o.beacons, x -= o.x, y -= o.y, xx -= o.xx, xy -= o.xy, yy -= o.yy;
    paths -= o.paths;
  }
  [[nodiscard]] bool is_one_pose() const {
    if (paths < kFewestPaths || beacons < 3) return false;
    const double a = xx - x * x / beacons, b = xy - x * y / beacons, c = yy - y * y / beacons;
    const double half = 0.5 * (a + c), root = std::sqrt(std::max(half * half - (a * c - b * b), 0.0));
    return half - root > kWidth2 * (half + root) &&
           heading_information(information) > 1.0 / (kHeadingSigmaRad * kHeadingSigmaRad);
  }
};

/// Of one beacon's arrivals, those that agree with the pose.
Agreement agreement_of(const SearchProblem& problem, Consensus& consensus, const PlanarState& state,
                       std::size_t group) {
  Agreement agreed;
  const std::size_t first = problem.group_first[group];
  agreed.paths = consensus.agreement(state, group, kAgreeSigmas, agreed.information);
  if (agreed.paths == 0) return agreed;
  const Eigen::Vector2d p =
      (problem.ranges[first].p_beacon_map_m - problem.ranges.front().p_beacon_map_m).head<2>();
  agreed.beacons = 1;
  agreed.x = p.x(), agreed.y = p.y();
  agreed.xx = p.x() * p.x(), agreed.xy = p.x() * p.y(), agreed.yy = p.y() * p.y();
  return agreed;
}

/// Whether all but any `left_out` more of the beacons from `next` on tell one pose.
bool is_one_pose_without_any(const std::pmr::vector<Agreement>& each, Agreement& rest, std::size_t next,
                             std::size_t left_out) {
  if (left_out == 0) return rest.is_one_pose();
  for (std::size_t i = next; i < each.size(); ++i) {
    rest.take(each[i]);
    const bool one = is_one_pose_without_any(each, rest, i + 1, left_out - 1);
    rest.add(each[i]);
    if (!one) return false;
  }
  return true;
}

}  // namespace

std::size_t most_outliers(const Consensus& consensus, double score, double margin) {
  return static_cast<std::size_t>(std::max((score + margin) / consensus.least_cap(), 0.0));
}

bool excludes_rivals(const SearchProblem& problem, Consensus& consensus, const PlanarState& state,
                     std::size_t outliers) {
  std::pmr::vector<Agreement> each(scratch());
  each.reserve(problem.groups());
  Agreement all;
  for (std::size_t group = 0; group < problem.groups(); ++group) {
    const Agreement agreed = agreement_of(problem, consensus, state, group);
    if (agreed.paths == 0) continue;
    each.push_back(agreed);
    all.add(agreed);
  }
  if (each.size() < outliers + 3) return false;
  double sets = 1;
  for (std::size_t k = 0; k < outliers; ++k)
    sets *= static_cast<double>(each.size() - k) / static_cast<double>(k + 1);
  return sets <= kMostSets && is_one_pose_without_any(each, all, 0, outliers);
}

std::pmr::vector<std::array<std::size_t, 2>> covering_pairs(const SearchProblem& problem,
                                                            std::size_t outliers) {
  const std::size_t n = problem.groups(), sets = n - outliers - 1;
  // The earliest of each beacon stands for it, since echoes are late.
  std::pmr::vector<std::size_t> earliest(scratch());
  earliest.reserve(n);
  for (std::size_t group = 0; group < n; ++group) {
    std::size_t best = problem.group_first[group];
    for (std::size_t i = best; i < problem.group_first[group + 1]; ++i)
      if (problem.ranges[i].range_m < problem.ranges[best].range_m) best = i;
    earliest.push_back(best);
  }
  std::pmr::vector<std::array<std::size_t, 2>> out(scratch());
  out.reserve(n * (n - 1));
  for (const bool dealt : {true, false})  // like cards, and cut like a pack of them
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = a + 1; b < n; ++b)
        if (dealt ? a % sets == b % sets : sets > 1 && a * sets / n == b * sets / n)
          out.push_back({earliest[a], earliest[b]});
  return out;
}

}  // namespace octant
