// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Priors and taped distances: cost by hand from the site, derivatives and information by differences.
#include "calib/adjust/priors.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/simulator/random.h"
#include "tests/support/numeric.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace priors_test {

/// The hall with three taped distances, one of them to a control point.
calib::Problem taped_hall() {
  calib::Problem problem;
  problem.site = hall_scenario().site;
  problem.runs.resize(1);
  const auto tape = [&](int from, int to, double sigma_m) {
    problem.site.distances.push_back({BeaconId(from), BeaconId(to), 0.0, sigma_m});
  };
  tape(1, 2, 0.005);
  tape(0, 4, 0.01);
  tape(5, 7, 0.002);
  const SharedState state = prior_state(problem.site);
  for (ControlDistance& d : problem.site.distances)
    d.distance_m = (state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()]).norm();
  return problem;
}

calib::ParameterLayout layout_of(const calib::Problem& problem) {
  return calib::make_layout(problem, prior_state(problem.site));
}

/// The layout's vector, every column off its prior.
Eigen::VectorXd off_prior(const calib::ParameterLayout& layout, std::uint64_t seed, double off = 0.05) {
  Random draws(seed);
  Eigen::VectorXd x = layout.vector_of(layout.fixed);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += off * draws.normal();
  return x;
}

TEST(Priors, CostIsHalfTheSquaresOfWhatTheSiteStates) {
  const calib::Problem problem = taped_hall();
  const Site& site = problem.site;
  const calib::ParameterLayout layout = layout_of(problem);
  const Eigen::VectorXd x = off_prior(layout, 1);
  const SharedState state = layout.state_of(x);
  double squares = 0.0;
  const auto add = [&](double value, double mean, double sigma) {
    if (sigma > 0) squares += std::pow((value - mean) / sigma, 2);
  };
  for (std::size_t b = 0; b < 8; ++b) {
    for (std::size_t i = 0; i < 3; ++i)
      add(state.beacon_p_map_m[b][static_cast<Eigen::Index>(i)], *site.beacons[b].position_m[i],
          *site.beacons[b].sigma_m[i]);
    add(state.beacon_delay_s[b], site.timing.delay_s, site.timing.delay_sigma_s);
  }
  add(state.speed_offset_mps[0], 0.0, site.speed_sigma_mps);
  for (std::size_t r = 0; r < 8; ++r)
    for (int i = 0; i < 3; ++i)
      add(state.receiver_p_vehicle_m[r][i], site.receivers[r].position_m[i], site.receivers[r].sigma_m[i]);
  for (const ControlDistance& d : site.distances)
    add((state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()]).norm(), d.distance_m,
        d.sigma_m);
  EXPECT_NEAR(calib::prior_cost(problem, layout, x), 0.5 * squares, 1e-11 * squares);  // some 60 roundings
}

TEST(Priors, CostNothingWhereAllIsAsStated) {
  const calib::Problem problem = taped_hall();
  const calib::ParameterLayout layout = layout_of(problem);
  // Tapes of metres at millimetres: a rounding of the length, squared.
  EXPECT_LT(calib::prior_cost(problem, layout, layout.vector_of(layout.fixed)), 1e-20);
}

TEST(Priors, ATapesDerivativeIsTheNumericOne) {
  const calib::Problem problem = taped_hall();
  const calib::ParameterLayout layout = layout_of(problem);
  const Eigen::VectorXd x = off_prior(layout, 2);
  for (const ControlDistance& d : problem.site.distances) {
    const auto residual = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
      return Eigen::VectorXd::Constant(1, calib::distance_row(d, layout, layout.state_of(at)).residual);
    };
    Eigen::RowVectorXd here = Eigen::RowVectorXd::Zero(x.size());
    for (const auto& [column, value] : calib::distance_row(d, layout, layout.state_of(x)).entries)
      here[column] += value;
    // Truncation: step^2 / length^2 of a derivative of 1 / sigma = 500; rounding 1e-15 * 500 * 10 / step.
    EXPECT_LT((here - numeric_jacobian(residual, x, 1e-5)).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(Priors, ATapeToAControlPointMovesItsOtherEndAlone) {
  const calib::Problem problem = taped_hall();
  const calib::ParameterLayout layout = layout_of(problem);
  const calib::PriorRow row =
      calib::distance_row(problem.site.distances[1], layout, prior_state(problem.site));
  ASSERT_EQ(row.entries.size(), 3U);
  for (const auto& [column, value] : row.entries)
    EXPECT_EQ(beacon_of(layout.parameters[static_cast<std::size_t>(column)].id),
              std::optional<std::size_t>(4));
}

TEST(Priors, ATapeBetweenBeaconsAtOnePlaceIsANumber) {
  const calib::Problem problem = taped_hall();
  const calib::ParameterLayout layout = layout_of(problem);
  SharedState state = prior_state(problem.site);
  state.beacon_p_map_m[1] = state.beacon_p_map_m[2];
  const ControlDistance& d = problem.site.distances[0];
  const calib::PriorRow row = calib::distance_row(d, layout, state);
  EXPECT_NEAR(row.residual, -d.distance_m / d.sigma_m, 1e-3);  // the length counts as a nanometre
  for (const auto& [column, value] : row.entries) EXPECT_TRUE(std::isfinite(value));
}

/// Where all tapes fit, half their squares have the Gauss-Newton matrix for their second derivative.
TEST(Priors, InformationIsTheSecondDerivativeOfTheCost) {
  calib::Problem problem = taped_hall();
  calib::ParameterLayout layout = layout_of(problem);
  // A joint prior of two beacons, without separate ones.
  std::vector<int> columns;
  for (const std::size_t b : {1U, 2U})
    for (const int c : layout.beacon[b]) columns.push_back(c);
  Random draws(3);
  Eigen::MatrixXd A(6, 6);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = draws.normal();
  Eigen::VectorXd mean(6);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    calib::Parameter& p = layout.parameters[static_cast<std::size_t>(columns[i])];
    p.prior_sigma = INFINITY;
    mean[static_cast<Eigen::Index>(i)] = p.prior_mean;
  }
  layout.joint_prior =
      calib::joint_prior(columns, mean, 0.01 * A * A.transpose() + 0.01 * Eigen::MatrixXd::Identity(6, 6));
  const Eigen::VectorXd x = layout.vector_of(layout.fixed);
  const Eigen::MatrixXd N = calib::prior_information(problem, layout, x);
  EXPECT_EQ(N, N.transpose());
  const auto gradient = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    return numeric_jacobian(
               [&](const Eigen::VectorXd& y) -> Eigen::VectorXd {
                 return Eigen::VectorXd::Constant(1, calib::prior_cost(problem, layout, y));
               },
               at, 1e-4)
        .transpose();
  };
  const Eigen::MatrixXd numeric = numeric_jacobian(gradient, x, 1e-4);
  // The tapes' ranges bend: truncation of (step / length)^2 of the largest element, twice; rounding of a
  // cost of up to 1e-2 by step^2.
  EXPECT_LT((N - numeric).cwiseAbs().maxCoeff(), 1e-6 * N.cwiseAbs().maxCoeff());
}

TEST(Priors, ElementsAddUpToTheInformation) {
  const calib::Problem problem = taped_hall();
  const calib::ParameterLayout layout = layout_of(problem);
  const Eigen::VectorXd x = off_prior(layout, 4);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  calib::for_each_of_prior(problem, layout, x, [&](int i, int j, double value) { sum(i, j) += value; });
  EXPECT_EQ(sum, calib::prior_information(problem, layout, x));
  // Compared with rows: one for each prior and each tape.
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  for (int c = 0; c < layout.size(); ++c)
    rows(c, c) = std::pow(layout.parameters[static_cast<std::size_t>(c)].prior_sigma, -2);
  for (const ControlDistance& d : problem.site.distances) {
    Eigen::VectorXd a = Eigen::VectorXd::Zero(layout.size());
    const SharedState state = layout.state_of(x);
    const Eigen::Vector3d u =
        (state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()]).normalized();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (const int c = layout.beacon[d.from.index()][i]; c >= 0) a[c] += u[k] / d.sigma_m;
      if (const int c = layout.beacon[d.to.index()][i]; c >= 0) a[c] -= u[k] / d.sigma_m;
    }
    rows += a * a.transpose();
  }
  EXPECT_LT((sum - rows).cwiseAbs().maxCoeff(), 1e-14 * rows.cwiseAbs().maxCoeff());
}

}  // namespace priors_test
}  // namespace octant::test
