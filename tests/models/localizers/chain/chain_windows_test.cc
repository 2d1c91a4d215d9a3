// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// A chain solved window by window against a dense inverse of all its states at once, and against the
// recursion that is written independently for a single node.
#include "models/localizers/chain/chain_windows.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/chain/chain_factor.h"
#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/drive/tracker.h"
#include "models/trajectory/make_trajectory.h"
#include "tests/models/localizers/drive_world.h"

namespace octant::test {
namespace chain_windows_test {

// A condition of 1e8 (short odometry steps) leaves eight digits.
constexpr double kDigits = 1e-6;

/// A placed drive in the plane and its information in full.
struct WholeDrive {
  Deployment d = with_octagon(hall());
  Drive drive = test::drive(d, 10.0, 1e-5, 1.0, 37);
  EpochFixModel model = epoch_fix_model(d);
  Trajectory t = make_trajectory(drive.log, 0, VehicleId(0), trajectory_model(d));

  WholeDrive() { EXPECT_TRUE(place_drive(t, model)); }
  [[nodiscard]] const Segment& segment() const { return t.segments.front(); }

  /// Information, and J' e for the columns of errors e, without a beacon's arrivals.
  void fill(BeaconId without, Eigen::Index columns, Eigen::MatrixXd& H, Eigen::MatrixXd& b) const {
    const auto n = static_cast<Eigen::Index>(3 * t.nodes.size());
    H.setZero(n, n);
    b.setZero(n, columns);
    Eigen::RowVectorXd e(columns);
    for_each_row(t, segment(), model.state, [&](const ObservationRow& row) {
      if (row.kind == RowKind::kTof && row.beacon == without) return;
      Eigen::VectorXd J = Eigen::VectorXd::Zero(n);
      J.segment<3>(3 * static_cast<Eigen::Index>(row.node)) = row.by_node.transpose();
      if (row.has_next) J.segment<3>(3 * static_cast<Eigen::Index>(row.node) + 3) = row.by_next.transpose();
      H += J * J.transpose();
      if (errors_of(row, e)) b += J * e;
    });
  }
  static bool errors_of(const ObservationRow& row, Eigen::RowVectorXd& e) {
    if (!row.has_shared) return false;
    for (Eigen::Index k = 0; k < e.size(); ++k)
      e[k] = std::sin(0.1 * static_cast<double>(row.index) + 1.7 * k);
    return true;
  }
};

void expect_near(const Eigen::MatrixXd& got, const Eigen::MatrixXd& expected, const char* what,
                 std::size_t k) {
  EXPECT_LT((got - expected).norm(), kDigits * expected.norm()) << what << " of node " << k;
}

TEST(ChainWindows, AgreeWithTheDenseInverseWhereverTheyEnd) {
  const WholeDrive w;
  const std::size_t nodes = w.t.nodes.size();
  ASSERT_EQ(w.t.segments.size(), 1u);
  for (const BeaconId without : {BeaconId(), BeaconId(1)}) {
    constexpr Eigen::Index kColumns = 2;
    Eigen::MatrixXd H, b;
    w.fill(without, kColumns, H, b);
    const Eigen::MatrixXd P = H.inverse(), x = P * b;
    for (const std::size_t window_nodes :
         {std::size_t{1}, std::size_t{7}, nodes - 1, nodes, std::size_t{512}}) {
      std::vector<int> visited(nodes, 0);
      const ChainVariant variant{
          without, kColumns, WholeDrive::errors_of, [&](const ChainWindow& window) {
            for (std::size_t k = window.first_node; k < window.last_node; ++k) {
              ++visited[k];
              const auto i = static_cast<Eigen::Index>(3 * k);
              expect_near(window.covariance_at({k, 0.0}, 3), P.block<3, 3>(i, i), "covariance", k);
              expect_near(window.solution_at({k, 0.0}, 3), x.middleRows<3>(i), "solution", k);
              if (k + 1 == nodes) continue;
              expect_near(window.cross[k - window.first_node], P.block<3, 3>(i, i + 3), "cross", k);
              Eigen::MatrixXd between = Eigen::MatrixXd::Zero(3, P.cols());
              between.middleCols<3>(i) = 0.7 * Eigen::Matrix3d::Identity();
              between.middleCols<3>(i + 3) = 0.3 * Eigen::Matrix3d::Identity();
              expect_near(window.covariance_at({k, 0.3}, 3), between * P * between.transpose(), "between", k);
              expect_near(window.solution_at({k, 0.3}, 3), between * x, "solution between", k);
            }
          }};
      ASSERT_TRUE(
          solve_by_windows(w.t, w.segment(), w.model.state, std::span(&variant, 1), 2, window_nodes).front());
      EXPECT_EQ(visited, std::vector<int>(nodes, 1)) << window_nodes;
    }
  }
}

TEST(ChainWindows, AgreeWithTheRecursionOfASingleNode) {
  const WholeDrive w;
  const ChainVariant variant{BeaconId(), 0, {}, [&](const ChainWindow& window) {
                               for (std::size_t k = window.first_node; k < window.last_node; k += 9)
                                 expect_near(window.covariance_at({k, 0.0}, 3),
                                             node_covariance(w.t, w.segment(), k, w.model.state),
                                             "covariance", k);
                             }};
  ASSERT_TRUE(solve_by_windows(w.t, w.segment(), w.model.state, std::span(&variant, 1), 1, 20).front());
}

/// A drive can rotate about a single beacon, so its windows are not visited; windows that two beacons
/// determine are.
TEST(ChainWindows, WhatIsNotDeterminedIsNotVisited) {
  WholeDrive w;
  for (ArrivalObservation& a : w.t.arrivals)
    if (a.beacon != BeaconId(1) && a.beacon != BeaconId(2)) a.rejection = Rejection::kLate;
  int whole = 0, without = 0;
  const ChainVariant variants[] = {{BeaconId(), 0, {}, [&](const ChainWindow&) { ++whole; }},
                                   {BeaconId(1), 0, {}, [&](const ChainWindow&) { ++without; }}};
  const std::vector<bool> determined = solve_by_windows(w.t, w.segment(), w.model.state, variants, 1, 16);
  EXPECT_EQ(determined, (std::vector<bool>{true, false}));
  EXPECT_EQ(whole, static_cast<int>((w.t.nodes.size() + 15) / 16));
  EXPECT_EQ(without, 0);
}

TEST(ChainWindows, InstantsBelongToOneWindow) {
  const std::vector<DriveInstant> instants = {{3, 0.0}, {3, 0.5}, {4, 0.0}, {9, 0.9}, {10, 0.0}};
  ChainWindow window;
  window.first_node = 4;
  window.last_node = 10;
  std::vector<std::size_t> seen;
  for_each_instant(window, instants, [&](std::size_t i) { seen.push_back(i); });
  EXPECT_EQ(seen, (std::vector<std::size_t>{2, 3}));
}

}  // namespace chain_windows_test
}  // namespace octant::test
