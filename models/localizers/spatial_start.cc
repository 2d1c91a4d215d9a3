// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/spatial_start.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/SVD>

#include "models/localizers/search_problem.h"

namespace octant {
namespace {

/// |p - b|^2 = (range - o)^2, one equation subtracted from the others: linear in p (and o). Beacons in a plane leave the
/// distance from it open, which the minimum norm about their centre sets to zero; both sides are tried.
std::vector<Eigen::Vector3d> linear_positions(const SearchProblem& problem) {
  const auto n = static_cast<Eigen::Index>(problem.ranges.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double mean_range2 = 0.0, mean_norm2 = 0.0, mean_range = 0.0;
  for (const SearchRange& r : problem.ranges) centre += r.p_beacon_map_m / static_cast<double>(n);
  for (const SearchRange& r : problem.ranges) {
    mean_range2 += r.range_m * r.range_m / static_cast<double>(n);
    mean_range += r.range_m / static_cast<double>(n);
    mean_norm2 += (r.p_beacon_map_m - centre).squaredNorm() / static_cast<double>(n);
  }
  const int columns = problem.has_offset ? 4 : 3;
  Eigen::MatrixXd A(n, columns);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const SearchRange& r = problem.ranges[static_cast<std::size_t>(i)];
    const Eigen::Vector3d q = r.p_beacon_map_m - centre;
    A.row(i).head<3>() = 2.0 * q.transpose();
    if (problem.has_offset) A(i, 3) = -2.0 * (r.range_m - mean_range);
    b[i] = q.squaredNorm() - mean_norm2 - r.range_m * r.range_m + mean_range2;
  }
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(1e-3);
  const Eigen::Vector3d p = svd.solve(b).head<3>();
  std::vector<Eigen::Vector3d> out = {centre + p};
  if (!problem.has_offset && svd.rank() == 2) {
    const double height2 = mean_range2 - mean_norm2 - p.squaredNorm();
    const Eigen::Vector3d normal = svd.matrixV().col(2);
    const double height = std::sqrt(std::max(height2, 0.0));
    out = {centre + p + height * normal, centre + p - height * normal};
  }
  return out;
}

/// 24 rotations of the cube: none is further than 63 degrees away, most are within 45.
std::vector<Eigen::Quaterniond> coarse_rotations() {
  std::vector<Eigen::Quaterniond> out;
  using Axis = Eigen::AngleAxisd;
  const double quarter = std::numbers::pi / 2;
  for (int face = 0; face < 6; ++face) {
    const Eigen::Quaterniond tip(face < 4 ? Axis(face * quarter, Eigen::Vector3d::UnitY())
                                          : Axis((face == 4 ? 1 : -1) * quarter, Eigen::Vector3d::UnitX()));
    for (int turn = 0; turn < 4; ++turn)
      out.emplace_back(tip * Eigen::Quaterniond(Axis(turn * quarter, Eigen::Vector3d::UnitZ())));
  }
  return out;
}

bool differs(const Pose& a, const Pose& b, double distance_m) {
  return (a.translation_m - b.translation_m).norm() > distance_m || a.rotation.angularDistance(b.rotation) > 0.1;
}

}  // namespace

bool start_spatial(Trajectory& t, const Segment& segment, const EpochFixModel& model, const EpochFixOptions& options,
                   bool& found) {
  Node& node = t.nodes[segment.first_node];
  const SearchProblem problem = make_search_problem(t, segment, model, options.range_slack_m);
  found = segment.first_pose != segment.last_pose || (problem.groups() >= 3 && problem.ranges.size() >= 6);
  if (!found) return false;
  std::vector<Pose> starts;
  if (segment.first_pose != segment.last_pose) {
    starts.push_back(t.poses[segment.first_pose].T_map_vehicle);
  } else {
    for (const Eigen::Vector3d& p : linear_positions(problem))
      for (const Eigen::Quaterniond& q : coarse_rotations()) starts.push_back({p, q});
  }
  struct Settled {
    Node node;
    double cost;
  };
  std::vector<Settled> settled;
  for (const Pose& start : starts) {
    node.T_map_vehicle = start;
    node.cycle_offset_s = 0.0;
    settle(t, segment, model.state, {.late_scale = 30.0, .early_scale = 60.0}, 15);
    const SettleResult result = settle(t, segment, model.state, {.late_scale = 3.0, .early_scale = 5.0}, 15);
    if (std::isfinite(result.cost)) settled.push_back({node, result.cost});
  }
  if (settled.empty()) {
    found = false;
    return false;
  }
  const auto best =
      std::min_element(settled.begin(), settled.end(), [](const Settled& a, const Settled& b) { return a.cost < b.cost; });
  node = best->node;
  const double apart = 10 * problem.median_sigma_m + options.range_slack_m;
  return std::any_of(settled.begin(), settled.end(), [&](const Settled& s) {
    return s.cost < best->cost + options.ambiguity_margin && differs(s.node.T_map_vehicle, best->node.T_map_vehicle, apart);
  });
}

}  // namespace octant
