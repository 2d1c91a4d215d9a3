// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/least_squares/spatial_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/localizers/least_squares/search_problem.h"
#include "models/trajectory/decompositions.h"

namespace octant {

LinearPositions linear_positions(const SearchProblem& problem) {
  constexpr double kRankShare = 1e-6;  // of eigenvalues: a thousandth of the singular values
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
    // Eigenvectors of what is known span the beacons' plane.
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

}  // namespace octant
