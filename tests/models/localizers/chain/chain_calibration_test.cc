// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain/chain_calibration.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/tracker.h"
#include "models/trajectory/make_trajectory.h"
#include "tests/models/localizers/drive_world.h"

namespace octant::test {
namespace chain_calibration_test {

constexpr std::uint64_t kCalibrationSeed = 416;
constexpr double kPairSigma_s = 4e-6;

/// A drive with its states at the truth, and its full information: H of all states, G of their coupling to
/// the calibrated parameters, g of their coupling to a bias of each pair.
struct DenseDrive {
  Deployment d = with_octagon(hall());
  Drive drive = test::drive(d, 6.0, 1e-5, 1.0, kCalibrationSeed);
  Trajectory t;
  SharedState state;
  Eigen::MatrixXd H, G, g;

  DenseDrive() {
    d.covariance.parameters = {parameters::speed(), parameters::beacon_delay(2)};
    for (std::size_t b = 0; b < 4; ++b)
      for (std::size_t i = 0; i < 2; ++i)
        d.covariance.parameters.push_back(parameters::beacon_position(b, i));
    const auto n = static_cast<Eigen::Index>(d.covariance.parameters.size());
    Eigen::MatrixXd root = Eigen::MatrixXd::Random(n, n);
    root.row(0) *= 0.2;
    root.row(1) *= 1e-5;
    root.bottomRows(n - 2) *= 5e-3;
    d.covariance.matrix = root * root.transpose();
    t = make_trajectory(drive.log, 0, VehicleId(0), trajectory_model(d));
    state = epoch_fix_model(d).state;
    for (Node& node : t.nodes)
      for (const TimedPose& pose : drive.truth)
        if (std::abs(pose.time_s - node.time_s) < 1e-9) node.T_map_vehicle = pose.T_map_vehicle;
    fill();
  }
  [[nodiscard]] const Segment& segment() const { return t.segments.front(); }

 private:
  void fill() {
    const ParameterIndex column(d.covariance.parameters);
    const auto states = 3 * static_cast<Eigen::Index>(t.nodes.size());
    const std::size_t receivers = d.receivers.size();
    H = Eigen::MatrixXd::Zero(states, states);
    G = Eigen::MatrixXd::Zero(states, d.covariance.matrix.rows());
    g = Eigen::MatrixXd::Zero(states, static_cast<Eigen::Index>(d.beacons.size() * receivers));
    for_each_row(t, segment(), state, [&](const ObservationRow& row) {
      Eigen::VectorXd J = Eigen::VectorXd::Zero(states);
      const auto at = 3 * static_cast<Eigen::Index>(row.node);
      J.segment<3>(at) = row.by_node.transpose();
      if (row.has_next) J.segment<3>(at + 3) = row.by_next.transpose();
      H += J * J.transpose();
      if (row.kind != RowKind::kTof) return;
      const std::size_t b = row.beacon.index();
      const auto couple = [&](const ParameterId& id, double derivative) {
        if (const int k = column[id]; k >= 0) G.col(k) += derivative * J;
      };
      couple(parameters::speed(), row.by(kBySpeed));
      couple(parameters::beacon_delay(b), row.by(kByDelay));
      for (std::size_t i = 0; i < 2; ++i)
        couple(parameters::beacon_position(b, i), row.by_beacon[static_cast<Eigen::Index>(i)]);
      g.col(static_cast<Eigen::Index>(b * receivers + row.receiver.index())) += row.by(kByDelay) * J;
    });
  }
};

TEST(ChainCalibration, IsThatOfTheDenseInverse) {
  const DenseDrive w;
  ASSERT_EQ(w.t.segments.size(), 1u);
  const Eigen::MatrixXd inverse = w.H.inverse();
  const Eigen::MatrixXd P =
      inverse *
      (w.G * w.d.covariance.matrix * w.G.transpose() + kPairSigma_s * kPairSigma_s * w.g * w.g.transpose()) *
      inverse;
  const std::vector<DriveInstant> instants = {{0, 0.0}, {7, 0.0}, {40, 0.3}, {w.t.nodes.size() - 1, 0.0}};
  std::vector<PoseCovariance> added(instants.size(), PoseCovariance::Zero(3, 3));
  const CalibrationPart calibration(w.d);
  const CalibrationErrors errors(w.t, w.segment(), w.d.receivers.size(), calibration, kPairSigma_s);
  const ChainVariant all{BeaconId(), errors.columns(),
                         [&](const ObservationRow& row, Eigen::RowVectorXd& e) { return errors.of(row, e); },
                         [&](const ChainWindow& window) {
                           for_each_instant(window, instants, [&](std::size_t i) {
                             const ChainWindow::Matrix x = window.solution_at(instants[i], 3);
                             added[i] += x * x.transpose();
                           });
                         }};
  ASSERT_TRUE(solve_by_windows(w.t, w.segment(), w.state, std::span(&all, 1)).front());
  for (std::size_t i = 0; i < instants.size(); ++i) {
    Eigen::MatrixXd pick = Eigen::MatrixXd::Zero(3, P.cols());
    const auto at = 3 * static_cast<Eigen::Index>(instants[i].node);
    pick.middleCols<3>(at) = (1 - instants[i].alpha) * Eigen::Matrix3d::Identity();
    if (instants[i].alpha > 0) pick.middleCols<3>(at + 3) = instants[i].alpha * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d expected = pick * P * pick.transpose();
    EXPECT_LT((Eigen::Matrix3d(added[i]) - expected).norm(), 1e-6 * expected.norm()) << i;
  }
}

TEST(ChainCalibration, ANodeFollowsAnErrorAsTheDenseSolutionDoes) {
  const DenseDrive w;
  const ChainFactor factor = factor_chain(w.t, w.segment(), w.state);
  NodeCalibration out;
  out.by_parameter.resize(3, w.G.cols());
  out.by_pair.resize(3, w.g.cols());
  const std::size_t node = 25;
  node_calibration(w.t, w.segment(), w.state, factor, CalibrationPart(w.d), node, out);
  const Eigen::MatrixXd rows = w.H.inverse().middleRows<3>(3 * static_cast<Eigen::Index>(node));
  EXPECT_LT((out.by_parameter + rows * w.G).norm(), 1e-6 * out.by_parameter.norm());
  EXPECT_LT((out.by_pair + rows * w.g).norm(), 1e-6 * out.by_pair.norm());
}

}  // namespace chain_calibration_test
}  // namespace octant::test
