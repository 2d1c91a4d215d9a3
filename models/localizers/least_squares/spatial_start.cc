// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/spatial_start.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "models/localizers/least_squares/search_problem.h"
#include "models/support/decompositions.h"

namespace octant {

LinearPositions linear_positions(const SearchProblem& problem) {
  constexpr double kRankShare = 1e-6;  // relative eigenvalue: a thousandth of the singular values
  const double n = static_cast<double>(problem.ranges.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double mean_range2 = 0.0, mean_norm2 = 0.0, mean_range = 0.0;
  for (const SearchRange& r : problem.ranges) centre += r.p_beacon_map_m / n;
  for (const SearchRange& r : problem.ranges) {
    mean_range2 += r.range_m * r.range_m / n;
    mean_range += r.range_m / n;
    mean_norm2 += (r.p_beacon_map_m - centre).squaredNorm() / n;
  }
  Eigen::Matrix4d AtA = Eigen::Matrix4d::Zero();
  Eigen::Vector4d Atb = Eigen::Vector4d::Zero();
  for (const SearchRange& r : problem.ranges) {
    const Eigen::Vector3d q = r.p_beacon_map_m - centre;
    Eigen::Vector4d row;
    row << 2.0 * q, problem.has_offset ? -2.0 * (r.range_m - mean_range) : 0.0;
    AtA += row * row.transpose();
    Atb += row * (q.squaredNorm() - mean_norm2 - r.range_m * r.range_m + mean_range2);
  }
  const SymmetricEigen<Eigen::Matrix4d> eigen(AtA);
  Eigen::Vector4d solution = Eigen::Vector4d::Zero();
  int rank = 0;
  for (int i = 0; i < 4; ++i) {
    if (!(eigen.eigenvalues()[i] > kRankShare * eigen.eigenvalues()[3])) continue;
    solution += eigen.eigenvectors().col(i) * (eigen.eigenvectors().col(i).dot(Atb) / eigen.eigenvalues()[i]);
    ++rank;
  }
  const Eigen::Vector3d p = solution.head<3>();
  LinearPositions out{{centre + p, centre + p}, 1};
  if (!problem.has_offset && rank == 2) {
    // Eigenvectors of the determined directions span the beacons' plane.
    const Eigen::Vector3d across = eigen.eigenvectors().col(3).head<3>(),
                          along = eigen.eigenvectors().col(2).head<3>();
    const Eigen::Vector3d normal = across.cross(along).normalized();
    const double height = std::sqrt(std::max(mean_range2 - mean_norm2 - p.squaredNorm(), 0.0));
    out = {{centre + p + height * normal, centre + p - height * normal}, 2};
  }
  return out;
}

std::array<Eigen::Quaterniond, kCoarseRotations> coarse_rotations() {
  std::array<Eigen::Quaterniond, kCoarseRotations> out;
  using Axis = Eigen::AngleAxisd;
  const double quarter = std::numbers::pi / 2;
  for (std::size_t face = 0; face < 6; ++face) {
    const Eigen::Quaterniond tip(face < 4
                                     ? Axis(static_cast<double>(face) * quarter, Eigen::Vector3d::UnitY())
                                     : Axis((face == 4 ? 1 : -1) * quarter, Eigen::Vector3d::UnitX()));
    for (std::size_t turn = 0; turn < 4; ++turn)
      out[4 * face + turn] =
          tip * Eigen::Quaterniond(Axis(static_cast<double>(turn) * quarter, Eigen::Vector3d::UnitZ()));
  }
  return out;
}

bool differs(const Pose& a, const Pose& b, double distance_m) {
  return (a.translation_m - b.translation_m).norm() > distance_m ||
         a.rotation.angularDistance(b.rotation) > 0.1;
}

bool start_spatial(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                   const EpochFixOptions& options, bool& found) {
  Node& node = t.nodes[segment.first_node];
  const SearchProblem problem = make_search_problem(t, segment, model, options.range_uncertainty_m);
  found = segment.first_pose != segment.last_pose || (problem.groups() >= 3 && problem.ranges.size() >= 6);
  if (!found) return false;
  std::pmr::vector<Pose> starts(scratch());
  starts.reserve(2 * kCoarseRotations);
  if (segment.first_pose != segment.last_pose) {
    starts.push_back(t.poses[segment.first_pose].T_map_vehicle);
  } else {
    const LinearPositions positions = linear_positions(problem);
    for (std::size_t k = 0; k < positions.count; ++k)
      for (const Eigen::Quaterniond& q : coarse_rotations()) starts.push_back({positions.p_map_m[k], q});
  }
  struct SolvedPose {
    Node node;
    double cost;
  };
  std::pmr::vector<SolvedPose> solved(scratch());
  solved.reserve(starts.size());
  for (const Pose& start : starts) {
    node.T_map_vehicle = start;
    node.cycle_offset_s = 0.0;
    solve_states(t, segment, model.state, {.late_scale = 30.0, .early_scale = 60.0}, 15);
    const StateSolveResult result =
        solve_states(t, segment, model.state, {.late_scale = 3.0, .early_scale = 5.0}, 15);
    if (std::isfinite(result.cost)) solved.push_back({node, result.cost});
  }
  if (solved.empty()) {
    found = false;
    return false;
  }
  const auto best = std::ranges::min_element(solved, {}, &SolvedPose::cost);
  node = best->node;
  const double apart = 10 * problem.median_sigma_m + options.range_uncertainty_m;
  return std::ranges::any_of(solved, [&](const SolvedPose& s) {
    return s.cost < best->cost + options.ambiguity_margin &&
           differs(s.node.T_map_vehicle, best->node.T_map_vehicle, apart);
  });
}

namespace {

/// Place under test, and the offset in metres.
using PlaceState = Eigen::Vector4d;

/// Ranges of one point. Errors that a beacon's ranges have in common count as if each had its own: the search
/// need not weigh them rightly, the adjustment that follows does.
class PlaceCost {
 public:
  explicit PlaceCost(const SearchProblem& problem) : problem_(problem) {}

  /// Levenberg and Marquardt's way down. @return the cost at the place that x becomes
  double descend(PlaceState& x) const {
    constexpr int kRounds = 40;
    double damping = 1e-3;
    Eigen::Matrix4d H;
    PlaceState g;
    double cost = evaluate(x, H, g);
    for (int round = 0; round < kRounds && damping < 1e6; ++round) {
      Eigen::Matrix4d D = H;
      D.diagonal() *= 1.0 + damping;
      D.diagonal().array() += 1e-9 * (1.0 + H.diagonal().maxCoeff());
      const PlaceState step = -D.ldlt().solve(g), next = x + step;
      Eigen::Matrix4d H_next;
      PlaceState g_next;
      const double there = evaluate(next, H_next, g_next);
      if (!(there <= cost)) {
        damping *= 10.0;
        continue;
      }
      const bool converged = cost - there <= 1e-7 * (1.0 + cost);
      x = next;
      cost = there;
      H = H_next;
      g = g_next;
      damping = std::max(0.1 * damping, 1e-9);
      if (converged) break;
    }
    return cost;
  }

 private:
  double evaluate(const PlaceState& x, Eigen::Matrix4d& H, PlaceState& g) const {
    constexpr RobustLoss kLoss{.late_scale = 3.0, .early_scale = 5.0};
    H.setZero();
    g.setZero();
    if (!problem_.has_offset) H(3, 3) = 1.0;
    double cost = 0.0;
    for (std::size_t group = 0; group < problem_.groups(); ++group)
      for (std::size_t i = problem_.group_first[group]; i < problem_.group_first[group + 1]; ++i) {
        const SearchRange& r = problem_.ranges[i];
        const Eigen::Vector3d v = x.head<3>() - r.p_beacon_map_m;
        const double length = std::max(v.norm(), 1e-9),
                     sigma_m = std::hypot(r.sigma_m, problem_.group_bias_m[group]);
        PlaceState by;
        by << v / (length * sigma_m), problem_.has_offset ? 1.0 / sigma_m : 0.0;
        const double late = (r.range_m - length - (problem_.has_offset ? x[3] : 0.0)) / sigma_m;
        const double weight = kLoss.weigh(late, cost);
        H += weight * by * by.transpose();
        g -= weight * late * by;
      }
    return cost;
  }

  const SearchProblem& problem_;
};

/// Sets of beacons, a bit each: all of them, and small samples, as an echo among the squares of ranges spoils
/// all of them (random sample consensus, Fischler and Bolles 1981; every sample where there are few).
std::pmr::vector<std::uint64_t> samples_of(std::size_t groups, std::size_t size) {
  constexpr std::size_t kMostEnumerated = 8, kMostGroups = 64, kDrawn = 64;
  groups = std::min(groups, kMostGroups);
  std::pmr::vector<std::uint64_t> samples(scratch());
  samples.reserve(std::max<std::size_t>(kDrawn, std::size_t{1} << kMostEnumerated) + 1);
  samples.push_back(~std::uint64_t{0});
  if (groups <= size) return samples;
  if (groups <= kMostEnumerated) {
    for (std::uint64_t set = 0; set < (std::uint64_t{1} << groups); ++set)
      if (static_cast<std::size_t>(std::popcount(set)) == size) samples.push_back(set);
    return samples;
  }
  std::uint32_t draw = 1;  // the same for the same ranges
  while (samples.size() <= kDrawn) {
    std::uint64_t set = 0;
    while (static_cast<std::size_t>(std::popcount(set)) < size) {
      draw = draw * 1664525U + 1013904223U;
      set |= std::uint64_t{1} << ((draw >> 8U) % groups);
    }
    samples.push_back(set);
  }
  return samples;
}

/// The plane that comes nearest to the beacons: a point of it and its normal.
std::pair<Eigen::Vector3d, Eigen::Vector3d> plane_of_beacons(const SearchProblem& problem) {
  const auto n = static_cast<double>(problem.groups());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  const auto beacon = [&](std::size_t g) -> const Eigen::Vector3d& {
    return problem.ranges[problem.group_first[g]].p_beacon_map_m;
  };
  for (std::size_t g = 0; g < problem.groups(); ++g) centre += beacon(g) / n;
  for (std::size_t g = 0; g < problem.groups(); ++g)
    spread += (beacon(g) - centre) * (beacon(g) - centre).transpose();
  return {centre, SymmetricEigen<Eigen::Matrix3d>(spread).eigenvectors().col(0)};
}

/// Positions from samples of the beacons, and their mirror images: nearly coplanar beacons hardly distinguish
/// the sides.
std::pmr::vector<PlaceState> place_starts(const SearchProblem& problem) {
  const auto [centre, normal] = plane_of_beacons(problem);
  const auto samples = samples_of(problem.groups(), problem.has_offset ? 5 : 4);
  std::pmr::vector<PlaceState> starts(scratch());
  starts.reserve(4 * samples.size());
  SearchProblem sample;
  sample.has_offset = problem.has_offset;
  sample.ranges.reserve(problem.ranges.size());
  for (const std::uint64_t set : samples) {
    sample.ranges.clear();
    for (std::size_t g = 0; g < problem.groups(); ++g)
      for (std::size_t i = problem.group_first[g]; i < problem.group_first[g + 1]; ++i)
        if (g >= 64 || ((set >> g) & 1U) != 0) sample.ranges.push_back(problem.ranges[i]);
    const LinearPositions positions = linear_positions(sample);
    for (std::size_t k = 0; k < positions.count; ++k) {
      const Eigen::Vector3d& p = positions.p_map_m[k];
      if (!p.allFinite()) continue;
      for (const Eigen::Vector3d& q : {p, Eigen::Vector3d(p - 2 * normal.dot(p - centre) * normal)}) {
        double offset_m = 0.0;
        for (const SearchRange& r : sample.ranges)
          offset_m += (r.range_m - (q - r.p_beacon_map_m).norm()) / static_cast<double>(sample.ranges.size());
        PlaceState start;
        start << q, problem.has_offset ? offset_m : 0.0;
        starts.push_back(start);
      }
    }
  }
  return starts;
}

}  // namespace

bool start_place(Trajectory& t, const Segment& segment, const EpochFixModel& model,
                 const EpochFixOptions& options, bool& found) {
  const SearchProblem problem = make_search_problem(t, segment, model, options.range_uncertainty_m);
  found = problem.groups() >= (problem.has_offset ? 4U : 3U);
  if (!found) return false;
  const PlaceCost ranges(problem);
  std::pmr::vector<PlaceState> places = place_starts(problem);
  std::pmr::vector<double> costs(scratch());
  costs.reserve(places.size());
  for (PlaceState& place : places) costs.push_back(ranges.descend(place));
  const auto best = static_cast<std::size_t>(std::ranges::min_element(costs) - costs.begin());
  found = !places.empty() && std::isfinite(costs[best]);
  if (!found) return false;
  Node& node = t.nodes[segment.first_node];
  node.T_map_vehicle = Pose{places[best].head<3>(), Eigen::Quaterniond::Identity()};
  node.cycle_offset_s = places[best][3] / problem.speed_mps;
  const double apart_m = 10 * problem.median_sigma_m + options.range_uncertainty_m;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (costs[i] < costs[best] + options.ambiguity_margin &&
        (places[i] - places[best]).head<3>().norm() > apart_m)
      return true;
  return false;
}

}  // namespace octant
