// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/rivals.h"

#include <algorithm>
#include <cmath>

namespace octant {
namespace {

constexpr double kAgreeSigmas = 4.0;
constexpr double kWidth2 =
    0.01;  ///< squared ratio of lateral to longitudinal spread below which beacons are collinear
constexpr std::size_t kMostSets = 600;  ///< number of sets of excluded beacons

/// Joint information of the arrivals of some beacons.
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

/// Arrivals of one beacon that agree with the pose and with each other.
Agreement agreement_of(const SearchProblem& problem, Consensus& consensus, const Discord& discord,
                       const PlanarState& state, std::size_t group) {
  Agreement agreed;
  const std::size_t first = problem.group_first[group];
  agreed.paths = consensus.agreement(state, group, kAgreeSigmas, discord.is_odd, agreed.information);
  if (agreed.paths == 0) return agreed;
  const Eigen::Vector2d p =
      (problem.ranges[first].p_beacon_map_m - problem.ranges.front().p_beacon_map_m).head<2>();
  agreed.beacons = 1;
  agreed.x = p.x(), agreed.y = p.y();
  agreed.xx = p.x() * p.x(), agreed.xy = p.x() * p.y(), agreed.yy = p.y() * p.y();
  return agreed;
}

/// Returns true if one pose remains without any `left_out` further beacons, from `next` on.
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

/// Squared excess, in sigmas, of the difference of two ranges of a beacon over the distance of their
/// receivers.
double excess_squared(const SearchRange& a, const SearchRange& b) {
  const double differ_m = std::abs(a.range_m - b.range_m);
  const double apart2 = (a.p_lever_m - b.p_lever_m).squaredNorm();
  if (differ_m * differ_m <= apart2) return 0.0;
  const double excess_m = differ_m - std::sqrt(apart2);
  return excess_m * excess_m / (a.sigma_m * a.sigma_m + b.sigma_m * b.sigma_m);
}

/// Marks ranges that contradict the ones in agreement, if those are at least two and the majority; otherwise
/// marks all.
void flag_odd(std::size_t first, std::size_t last, const std::pmr::vector<std::size_t>& against,
              std::pmr::vector<char>& is_odd) {
  const std::size_t count = last - first;
  std::size_t odd = 0;
  for (std::size_t i = first; i < last; ++i) {
    is_odd[i] = 2 * against[i] >= count ? 1 : 0;
    odd += is_odd[i] != 0 ? 1 : 0;
  }
  bool clear = count >= odd + 2 && count > 2 * odd;
  for (std::size_t i = first; i < last && clear; ++i)
    clear = is_odd[i] != 0 ? against[i] >= count - odd : against[i] == odd;
  for (std::size_t i = first; i < last && !clear; ++i) is_odd[i] = 1;
}

/// Earliest range of a beacon among those in agreement, since echoes are late; without agreement also the
/// second one.
std::array<std::size_t, 2> ends_of_pairs(const SearchProblem& problem, const Discord& discord,
                                         std::size_t group) {
  const std::size_t first = problem.group_first[group], last = problem.group_first[group + 1];
  const auto earliest_but = [&](std::size_t but) {
    std::size_t best = last;
    for (std::size_t i = first; i < last; ++i)
      if (i != but && (best == last || discord.is_odd[i] < discord.is_odd[best] ||
                       (discord.is_odd[i] == discord.is_odd[best] &&
                        problem.ranges[i].range_m < problem.ranges[best].range_m)))
        best = i;
    return best;
  };
  const std::size_t one = earliest_but(last);
  return {one, discord.is_odd[one] != 0 && last - first > 1 ? earliest_but(one) : one};
}

}  // namespace

Discord discord_of(const SearchProblem& problem, const Consensus& consensus) {
  Discord discord;
  discord.cost.assign(problem.groups(), 0.0);
  discord.is_odd.assign(problem.ranges.size(), 0);
  std::pmr::vector<std::size_t> against(problem.ranges.size(), 0, scratch());
  std::pmr::vector<char> paired(problem.ranges.size(), 0, scratch());
  for (std::size_t group = 0; group < problem.groups(); ++group) {
    const std::size_t first = problem.group_first[group], last = problem.group_first[group + 1];
    for (std::size_t i = first; i < last; ++i)
      for (std::size_t j = i + 1; j < last; ++j) {
        const double excess2 = excess_squared(problem.ranges[i], problem.ranges[j]);
        if (excess2 <= kAgreeSigmas * kAgreeSigmas) continue;
        ++against[i];
        ++against[j];
        if (paired[i] != 0 || paired[j] != 0) continue;
        // Either both share the excess or one is an outlier. Each arrival is counted in one pair only.
        paired[i] = paired[j] = 1;
        discord.cost[group] += std::min(0.5 * excess2, consensus.least_caps(i, group).late);
      }
    if (discord.cost[group] == 0.0) continue;
    discord.total += discord.cost[group];
    flag_odd(first, last, against, discord.is_odd);
  }
  return discord;
}

std::size_t most_outliers(const Consensus& consensus, const Discord& discord, double score, double margin) {
  return static_cast<std::size_t>(std::max((score + margin - discord.total) / consensus.least_cap(), 0.0));
}

bool excludes_rivals(const SearchProblem& problem, Consensus& consensus, const Discord& discord,
                     const PlanarState& state, std::size_t outliers) {
  std::pmr::vector<Agreement> each(scratch());
  each.reserve(problem.groups());
  Agreement all;
  for (std::size_t group = 0; group < problem.groups(); ++group) {
    const Agreement agreed = agreement_of(problem, consensus, discord, state, group);
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
                                                            const Discord& discord, std::size_t outliers) {
  const std::size_t n = problem.groups(), sets = n - outliers - 1;
  std::pmr::vector<std::array<std::size_t, 2>> stand_for(scratch());
  stand_for.reserve(n);
  for (std::size_t group = 0; group < n; ++group) stand_for.push_back(ends_of_pairs(problem, discord, group));
  std::pmr::vector<std::array<std::size_t, 2>> out(scratch());
  out.reserve(n * (n - 1));
  for (const bool dealt : {true, false})  // two different partitions: alternating, and contiguous
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = a + 1; b < n; ++b) {
        if (!(dealt ? a % sets == b % sets : sets > 1 && a * sets / n == b * sets / n)) continue;
        for (std::size_t i = 0; i < (stand_for[a][0] == stand_for[a][1] ? 1U : 2U); ++i)
          for (std::size_t j = 0; j < (stand_for[b][0] == stand_for[b][1] ? 1U : 2U); ++j)
            out.push_back({stand_for[a][i], stand_for[b][j]});
      }
  return out;
}

}  // namespace octant
