// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "models/fix.h"
#include "tests/support/worlds.h"

namespace octant::test {

inline calib::Problem problem_of(const World& world) {
  return must(calib::make_problem(world.site, {world.run}));
}
inline calib::Solution solution_of(const World& world, const calib::SolveOptions& options = {}) {
  return calib::solve(problem_of(world), options);
}

/// One receiver without an axis in place of all.
inline void keep_one_receiver(Site& site, const Eigen::Vector3d& p_vehicle_m, double sigma_m = 0.0) {
  site.receivers.resize(1);
  site.receivers[0].position_m = p_vehicle_m;
  site.receivers[0].sigma_m.setConstant(sigma_m);
  site.receivers[0].axis.reset();
  site.vehicles[0].receiver_count = 1;
  site.vehicles[0].array.reset();
}

/// Largest distance of a calibrated beacon from the truth [m].
inline double worst_beacon_m(const World& world, const calib::Solution& solution) {
  double worst = 0.0;
  for (std::size_t b = 0; b < world.truth.beacons.size(); ++b)
    worst = std::max(worst, (solution.state.beacon_p_map_m[b] - world.truth.beacons[b].position_m).norm());
  return worst;
}

/// A validation fix minus the truth at its time: x, y [m], heading [rad].
inline Eigen::Vector3d fix_error(const World& world, const Fix& fix) {
  Pose truth;
  EXPECT_TRUE(interpolate_poses(world.heldout.truth, fix.time_s, 10.0, truth));
  Eigen::Vector3d error = fix.T_map_vehicle.translation_m - truth.translation_m;
  error.z() = wrap_angle(fix.T_map_vehicle.heading_rad() - truth.heading_rad());
  return error;
}

/// By name: "beacon/B1/x_m".
inline double sigma_of(const calib::Solution& solution, const Site& site, const std::string& name) {
  const NameTable names = names_of(site);
  const auto id = ParameterLookup(names).find(name);
  const int at = id ? solution.covariance.index_of(*id) : -1;
  if (at >= 0) return std::sqrt(solution.covariance.matrix(at, at));
  ADD_FAILURE() << "no parameter " << name;
  return NAN;
}

/// Free beacon coordinates, estimate less truth, with their joint covariance.
struct BeaconErrors {
  Eigen::VectorXd error;
  Eigen::MatrixXd covariance;
  [[nodiscard]] double nees() const { return error.dot(covariance.ldlt().solve(error)); }
};
inline BeaconErrors beacon_errors(const World& world, const calib::Solution& solution) {
  std::vector<Eigen::Index> at;
  std::vector<double> error;
  for (std::size_t b = 0; b < world.truth.beacons.size(); ++b)
    for (int i = 0; i < 3; ++i) {
      const int found =
          solution.covariance.index_of(parameters::beacon_position(b, static_cast<std::size_t>(i)));
      if (found < 0) continue;
      at.push_back(found);
      error.push_back(solution.state.beacon_p_map_m[b][i] - world.truth.beacons[b].position_m[i]);
    }
  BeaconErrors out;
  const auto n = static_cast<Eigen::Index>(at.size());
  out.error = Eigen::Map<Eigen::VectorXd>(error.data(), n);
  out.covariance.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      out.covariance(i, j) =
          solution.covariance.matrix(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
  return out;
}

}  // namespace octant::test
