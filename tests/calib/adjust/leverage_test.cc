// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Leverages against the diagonal of a dense hat matrix of numeric derivatives, states and shared parameters
// together.
#include "calib/adjust/leverage.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/trajectory/make_trajectory.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace leverage_test {

/// Some stops of a hall at poses of their own, every shared parameter with a prior of its own.
struct Stops {
  calib::Problem problem;
  calib::ParameterLayout layout;
  SharedState state;
  Trajectory t;
  Eigen::VectorXd prior;  ///< information
  Eigen::MatrixXd J;      ///< rows: arrivals, then priors; columns: shared, then states
  Eigen::MatrixXd normal_inverse;

  Stops() {
    Scenario s = hall_scenario();
    s.path.epochs = 6;
    const World world = must(simulate(s, 1));
    problem = problem_of(world);
    layout = calib::make_layout(problem, prior_state(world.site));
    state = layout.state_of(layout.vector_of(prior_state(world.site)));
    t = make_trajectory(world.run, 0, VehicleId(std::size_t{0}), calib::trajectory_model(world.site));
    for (std::size_t k = 0; k < t.nodes.size(); ++k) {
      const auto i = static_cast<double>(k);
      t.nodes[k].T_map_vehicle = Pose::planar(4 + 2 * i, 5 + 0.7 * i, 0.4 + 0.9 * i);
      t.nodes[k].placed = true;
    }
    prior.resize(layout.size());
    for (int c = 0; c < layout.size(); ++c) prior[c] = 10.0 + c;
    differentiate();
  }

  [[nodiscard]] Eigen::VectorXd residuals(const SharedState& at, const Trajectory& moved) const {
    Eigen::VectorXd r(static_cast<Eigen::Index>(t.arrivals.size()));
    for (std::size_t i = 0; i < t.arrivals.size(); ++i)
      r[static_cast<Eigen::Index>(i)] = arrival_residual(moved, moved.arrivals[i], at);
    return r;
  }
  void differentiate() {
    constexpr double kStep = 1e-5;
    const Eigen::Index rows = static_cast<Eigen::Index>(t.arrivals.size()), n = layout.size();
    const auto states = static_cast<Eigen::Index>(3 * t.nodes.size());
    J = Eigen::MatrixXd::Zero(rows + n, n + states);
    const Eigen::VectorXd x = layout.vector_of(state);
    for (Eigen::Index c = 0; c < n; ++c) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(n, c);
      J.col(c).head(rows) =
          (residuals(layout.state_of(x + step), t) - residuals(layout.state_of(x - step), t)) / (2 * kStep);
      J(rows + c, c) = std::sqrt(prior[c]);
    }
    for (Eigen::Index c = 0; c < states; ++c) {
      Trajectory ends[2] = {t, t};
      for (const int side : {0, 1}) {
        Pose& T = ends[side].nodes[static_cast<std::size_t>(c / 3)].T_map_vehicle;
        Eigen::Vector3d p(T.translation_m.x(), T.translation_m.y(), T.heading_rad());
        p[c % 3] += side == 0 ? -kStep : kStep;
        T = Pose::planar(p.x(), p.y(), p.z());
      }
      J.col(n + c).head(rows) = (residuals(state, ends[1]) - residuals(state, ends[0])) / (2 * kStep);
    }
    normal_inverse = (J.transpose() * J).inverse();
  }
  [[nodiscard]] double leverage(Eigen::Index row) const {
    return J.row(row).dot(normal_inverse * J.row(row).transpose());
  }
  /// Largest shift of a free beacon coordinate by an error of one sigma of a row.
  [[nodiscard]] double shift_m(Eigen::Index row) const {
    const Eigen::VectorXd by = normal_inverse * J.row(row).transpose();
    double largest = 0.0;
    for (const auto& columns : layout.beacon)
      for (const int c : columns)
        if (c >= 0) largest = std::max(largest, std::abs(by[c]));
    return largest;
  }
  [[nodiscard]] calib::Covariance covariance() const {
    const Eigen::Index n = layout.size();
    const Eigen::MatrixXd C = normal_inverse.topLeftCorner(n, n);
    return {Eigen::MatrixXd(C.inverse()), Eigen::MatrixXd(n, 0)};
  }
};

TEST(Leverage, IsTheHatMatrixsDiagonal) {
  const Stops stops;
  const calib::Covariance C = stops.covariance();
  calib::LeverageSweep sweep(stops.layout, C);
  std::size_t rows = 0;
  double sum = 0.0;
  sweep.sweep(stops.t, stops.state, 0, stops.t.segments.size(), 1, [&](const calib::RowLeverage& l) {
    ASSERT_EQ(l.row.kind, RowKind::kTof);
    const auto row = static_cast<Eigen::Index>(l.row.index);
    ++rows;
    sum += l.leverage;
    EXPECT_NEAR(l.leverage, stops.leverage(row), 1e-6) << row;
    EXPECT_NEAR(l.shift_m, stops.shift_m(row), 1e-4 * stops.shift_m(row)) << row;
  });
  EXPECT_EQ(rows, stops.t.arrivals.size());
  // Leverages of the priors too; the sum of all leverages is the number of unknowns.
  for (int c = 0; c < stops.layout.size(); ++c) {
    const double prior = sweep.leverage_of({{c, std::sqrt(stops.prior[c])}});
    EXPECT_NEAR(prior, stops.prior[c] * stops.normal_inverse(c, c), 1e-6);
    sum += prior;
  }
  EXPECT_NEAR(sum, static_cast<double>(stops.layout.size()) + 3.0 * static_cast<double>(stops.t.nodes.size()),
              1e-5);
}

/// A lateness c of all arrivals of a beacon: c'c and c'(I - H)c.
TEST(Leverage, LatenessIsThatOfTheDenseProjector) {
  const Stops stops;
  const calib::Covariance C = stops.covariance();
  calib::LeverageSweep sweep(stops.layout, C);
  sweep.sweep(stops.t, stops.state, 0, stops.t.segments.size(), 1, [](const calib::RowLeverage&) {});
  const std::vector<calib::LatenessInformation> lateness = sweep.lateness();
  ASSERT_EQ(lateness.size(), stops.problem.site.beacons.size());
  for (std::size_t b = 0; b < lateness.size(); ++b) {
    Eigen::VectorXd c = Eigen::VectorXd::Zero(stops.J.rows());
    for (std::size_t i = 0; i < stops.t.arrivals.size(); ++i)
      if (stops.t.arrivals[i].beacon.index() == b)
        c[static_cast<Eigen::Index>(i)] = 1 / stops.t.arrivals[i].sigma_s;
    const Eigen::VectorXd answer = stops.normal_inverse * (stops.J.transpose() * c);
    const double remaining = c.squaredNorm() - c.dot(stops.J * answer);
    EXPECT_NEAR(lateness[b].total, c.squaredNorm(), 1e-9 * c.squaredNorm()) << b;
    EXPECT_NEAR(lateness[b].remaining, remaining, 1e-6 * c.squaredNorm()) << b;
  }
}

}  // namespace leverage_test
}  // namespace octant::test
