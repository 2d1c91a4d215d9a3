// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Compares logs read again for each step with logs in memory.

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "calib/streamed.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/memory_source.h"

namespace octant::test {

inline constexpr std::size_t kFewStates = 8U << 20U;  // some hundreds of states at a time

inline calib::StreamedCalibration streamed_drive(const Site& site, const std::vector<MeasurementLog>& runs,
                                                 const calib::SolveOptions& options = {},
                                                 std::size_t memory = kFewStates, std::size_t block = 300) {
  MemorySource source(runs, block);
  return must(calib::solve_streamed(site, source, options, memory));
}

/// Largest difference of the parameters, in sigmas of the whole's.
inline double largest_in_sigmas(const calib::Problem& problem, const calib::Solution& whole,
                                const calib::Solution& part) {
  const calib::ParameterLayout layout = calib::make_layout(problem, whole.state);
  Eigen::VectorXd si(layout.size());
  for (int i = 0; i < layout.size(); ++i) si[i] = layout.parameters[static_cast<std::size_t>(i)].si_per_unit;
  const Eigen::VectorXd sigma = whole.covariance.matrix.diagonal().cwiseSqrt();
  const Eigen::VectorXd shift =
      si.cwiseProduct(layout.vector_of(part.state) - layout.vector_of(whole.state)).cwiseQuotient(sigma);
  return shift.cwiseAbs().maxCoeff();
}

/// Extent of an area in a direction.
inline double reach_m(const std::vector<Eigen::Vector2d>& area_m, double direction_rad) {
  double reach = -INFINITY;
  for (const Eigen::Vector2d& p : area_m)
    reach = std::max(reach, p.x() * std::cos(direction_rad) + p.y() * std::sin(direction_rad));
  return reach;
}

/// The rejected bearings, with their reasons, in any order.
inline void expect_same_bearings(const calib::Solution& whole, const calib::Solution& part) {
  const auto by_number = [](const calib::Solution& s) {
    std::map<std::pair<std::size_t, std::size_t>, calib::LeftOutBearing> all;
    for (const calib::LeftOutBearing& b : s.left_out_bearings) all.insert({{b.run, b.bearing}, b});
    return all;
  };
  const auto of_whole = by_number(whole), of_part = by_number(part);
  ASSERT_EQ(of_part.size(), of_whole.size());
  for (const auto& [number, b] : of_whole) {
    const auto other = of_part.find(number);
    ASSERT_NE(other, of_part.end()) << number.second;
    EXPECT_EQ(other->second.reason, b.reason);
  }
}

/// Compares all results for drives, and for stops together with them, streamed or not.
inline void expect_same_drive(const Site& site, const std::vector<MeasurementLog>& runs) {
  const calib::Problem problem = must(calib::make_problem(site, runs));
  const calib::Solution whole = calib::solve(problem, {});
  const calib::StreamedCalibration s = streamed_drive(site, runs);
  const calib::Solution& part = s.solution;
  ASSERT_EQ(part.status, whole.status) << part.message;
  ASSERT_EQ(part.covariance.parameters, whole.covariance.parameters);
  EXPECT_LT(largest_in_sigmas(problem, whole, part), 1e-3);
  const double scale = whole.covariance.matrix.cwiseAbs().maxCoeff();
  EXPECT_LT((part.covariance.matrix - whole.covariance.matrix).cwiseAbs().maxCoeff(), 1e-4 * scale);
  EXPECT_EQ(part.statistics.arrivals, whole.statistics.arrivals);
  EXPECT_EQ(part.statistics.rejected, whole.statistics.rejected);
  EXPECT_EQ(part.statistics.unknowns, whole.statistics.unknowns);
  EXPECT_EQ(part.statistics.redundancy, whole.statistics.redundancy);
  EXPECT_NEAR(part.statistics.variance_factor, whole.statistics.variance_factor,
              1e-6 * whole.statistics.variance_factor);
  EXPECT_NEAR(part.statistics.rms_s, whole.statistics.rms_s, 1e-5 * whole.statistics.rms_s);
  EXPECT_NEAR(part.tof_sigma_s, whole.tof_sigma_s, 1e-6 * whole.tof_sigma_s);
  EXPECT_EQ(part.warnings, whole.warnings);
  EXPECT_EQ(part.beacon_status, whole.beacon_status);
  EXPECT_EQ(part.contradictions.size(), whole.contradictions.size());
  EXPECT_NEAR(s.problem.typical_range_m, problem.typical_range_m, 1e-9);
  std::size_t states = 0;
  for (const Trajectory& t : whole.trajectories) states += t.nodes.size();
  ASSERT_TRUE(part.totals);
  EXPECT_EQ(part.totals->epochs, states);
  std::vector<std::size_t> left_out(calib::kRejections, 0), counted(calib::kRejections, 0);
  for (const calib::LeftOut& l : whole.left_out) ++left_out[static_cast<std::size_t>(l.reason)];
  for (const auto& of_beacon : part.totals->of_beacon)
    for (std::size_t r = 1; r < calib::kRejections; ++r) counted[r] += of_beacon[r];
  EXPECT_EQ(counted, left_out);
  expect_same_bearings(whole, part);
  ASSERT_TRUE(part.reliability.ok);
  EXPECT_NEAR(part.reliability.mean_redundancy, whole.reliability.mean_redundancy, 0.02);
  EXPECT_NEAR(part.reliability.redundancy_sum, whole.reliability.redundancy_sum,
              0.03 * whole.reliability.redundancy_sum);
  for (std::size_t b = 0; b < part.reliability.beacons.size(); ++b) {
    EXPECT_EQ(part.reliability.beacons[b].used, whole.reliability.beacons[b].used);
    EXPECT_EQ(part.reliability.beacons[b].late, whole.reliability.beacons[b].late);
  }
  const Deployment a = calib::make_deployment(problem, whole, {}),
                   b = calib::make_deployment(s.problem, part, {});
  for (int i = 0; i < 16; ++i)
    EXPECT_NEAR(reach_m(a.validity_area_m, 0.4 * i), reach_m(b.validity_area_m, 0.4 * i), 1e-4);
  EXPECT_EQ(a.validity_temperature_degC, b.validity_temperature_degC);
}

}  // namespace octant::test
