// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/chain/chain_factor.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/tracker.h"
#include "models/trajectory/make_trajectory.h"
#include "tests/models/localizers/drive_world.h"

namespace octant::test {
namespace chain_factor_test {

TEST(ChainFactor, SolvesAsTheDenseMatrixDoes) {
  const Deployment d = with_octagon(hall());
  const Drive w = drive(d, 4.0, 1e-5, 1.0, 38);
  Trajectory t = make_trajectory(w.log, 0, VehicleId(0), trajectory_model(d));
  const EpochFixModel model = epoch_fix_model(d);
  ASSERT_TRUE(place_drive(t, model));
  ChainSystem system;
  build_chain_system(t, t.segments[0], model.state, {}, system);
  const auto n = static_cast<Eigen::Index>(3 * system.D.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b(n);
  std::pmr::vector<NodeVector> x;
  for (std::size_t k = 0; k < system.D.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(3 * k);
    A.block<3, 3>(i, i) = system.D[k];
    b.segment<3>(i) =
        Eigen::Vector3d(1.0, -2.0, 0.5) + Eigen::Vector3d::Constant(0.1 * static_cast<double>(k));
    x.emplace_back(b.segment<3>(i));
    if (k + 1 == system.D.size()) break;
    A.block<3, 3>(i, i + 3) = system.U[k];
    A.block<3, 3>(i + 3, i) = system.U[k].transpose();
  }
  const ChainFactor factor = factor_chain(t, t.segments[0], model.state);
  ASSERT_TRUE(factor.ok);
  factor.solve(x);
  const Eigen::VectorXd expected = A.inverse() * b;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const Eigen::Vector3d node = expected.segment<3>(3 * static_cast<Eigen::Index>(k));
    EXPECT_LT((x[k] - node).norm(), 1e-6 * node.norm()) << k;  // a condition of 1e8
  }
  for (ArrivalObservation& a : t.arrivals)  // about one beacon a drive may be turned
    if (a.beacon != BeaconId(1)) a.rejection = Rejection::kLate;
  EXPECT_FALSE(factor_chain(t, t.segments[0], model.state).ok);
}

}  // namespace chain_factor_test
}  // namespace octant::test
