// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/start/drive_start.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/localizers/common/trajectory_model.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "models/localizers/start/stretch_states.h"
#include "models/trajectory/make_trajectory.h"
#include "models/trajectory/stretches.h"
#include "tests/models/localizers/drive_world.h"

namespace octant::test {
namespace drive_start_test {

constexpr std::uint64_t kStartSeed = 415;

struct StartWorld {
  Deployment d = with_octagon(hall());
  Drive drive;
  EpochFixModel model = epoch_fix_model(d);
  Trajectory t;

  explicit StartWorld(double seconds = 20.0) : drive(test::drive(d, seconds, 1e-5, 1.0, kStartSeed)) {
    build();
  }
  void build() { t = make_trajectory(drive.log, 0, VehicleId(0), trajectory_model(d)); }
  [[nodiscard]] const Segment& segment() const { return t.segments.front(); }
  [[nodiscard]] double off_m(std::size_t node) const {
    for (const TimedPose& pose : drive.truth)
      if (std::abs(pose.time_s - t.nodes[node].time_s) < 1e-9)
        return (t.nodes[node].T_map_vehicle.translation_m - pose.T_map_vehicle.translation_m).norm();
    return INFINITY;
  }
};

TEST(DriveStart, PlacesAStretchWhereTheVehicleWas) {
  StartWorld w;
  const DriveStart start = find_start(w.t, w.segment(), w.model, {}, w.segment().first_node);
  ASSERT_TRUE(start.found);
  EXPECT_EQ(start.first_node, w.segment().first_node);
  ASSERT_GE(start.last_node, start.first_node + 2);
  for (std::size_t k = start.first_node; k < start.last_node; ++k) {
    EXPECT_TRUE(w.t.nodes[k].placed);
    EXPECT_LT(w.off_m(k), 0.02) << k;  // ranges to 3.4 mm, some forty in two seconds
  }
  EXPECT_FALSE(w.t.nodes[start.last_node].placed) << "nothing beyond the stretch is touched";
}

TEST(DriveStart, TheWindowGrowsUntilSomethingIsHeard) {
  StartWorld w;
  std::erase_if(w.drive.log.arrivals, [](const Arrival& a) { return a.time_s < 7.0; });
  w.build();
  const DriveStart start = find_start(w.t, w.segment(), w.model, {}, w.segment().first_node);
  ASSERT_TRUE(start.found);
  EXPECT_GT(w.t.nodes[start.last_node - 1].time_s, 7.0);
  EXPECT_LT(w.off_m(start.last_node - 1), 0.05);
}

// Ranges of one beacon turn with the drive about it.
TEST(DriveStart, OneBeaconDoesNotTell) {
  StartWorld w;
  std::erase_if(w.drive.log.arrivals, [](const Arrival& a) { return a.beacon != BeaconId(1); });
  w.build();
  EXPECT_FALSE(find_start(w.t, w.segment(), w.model, {}, w.segment().first_node).found);
}

// Arrivals of a beacon share its slack until the direction has changed: over half a range driven.
TEST(DriveStart, SlackOfSharedErrorsByHand) {
  StartWorld w(4.0);
  EXPECT_EQ(independent_uncertainty_m(w.t, w.segment(), w.model, 0.0), 0.0);
  for (OdometryObservation& o : w.t.odometry) o.T_before_after = Pose{};  // it stands: all arrivals share it
  std::vector<bool> heard(w.d.beacons.size());
  for (const ArrivalObservation& a : w.t.arrivals) heard[a.beacon.index()] = true;
  const auto beacons = static_cast<double>(std::count(heard.begin(), heard.end(), true));
  const auto arrivals = static_cast<double>(w.t.arrivals.size());
  EXPECT_NEAR(independent_uncertainty_m(w.t, w.segment(), w.model, 0.1), 0.1 * std::sqrt(arrivals / beacons),
              1e-12);
  for (OdometryObservation& o : w.t.odometry)
    o.T_before_after = Pose::planar(1e6, 0, 0);  // it flies: none do
  EXPECT_EQ(independent_uncertainty_m(w.t, w.segment(), w.model, 0.1), 0.1);
}

TEST(DriveStart, WidenedSigmasLastAsLongAsTheyAreAskedFor) {
  StartWorld w(4.0);
  const double before = w.t.arrivals[3].sigma_s;
  {
    const WidenedArrivals widened(w.t, w.segment(), w.model, 0.05);
    const double wide_s = independent_uncertainty_m(w.t, w.segment(), w.model, 0.05) / 343.7;
    EXPECT_NEAR(w.t.arrivals[3].sigma_s, std::hypot(before, wide_s), 1e-3 * wide_s);
  }
  EXPECT_EQ(w.t.arrivals[3].sigma_s, before);
}

// Comparison with the dense inverse of the information of all states of the segment.
TEST(DriveStart, AFilterBeginsWithTheMarginalInflated) {
  StartWorld w;
  const DriveStart start = find_start(w.t, w.segment(), w.model, {}, w.segment().first_node);
  ASSERT_TRUE(start.found);
  const Segment stretch = stretch_of(w.t, w.segment(), start.first_node, start.last_node);
  const std::size_t count = stretch.last_node - stretch.first_node;
  Eigen::MatrixXd H =
      Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(count), 3 * static_cast<Eigen::Index>(count));
  for_each_row(w.t, stretch, w.model.state, [&](const ObservationRow& row) {
    Eigen::RowVectorXd J = Eigen::RowVectorXd::Zero(H.cols());
    const auto at = 3 * static_cast<Eigen::Index>(row.node - stretch.first_node);
    J.segment<3>(at) = row.by_node;
    if (row.has_next) J.segment<3>(at + 3) = row.by_next;
    H += J.transpose() * J;
  });
  const Eigen::MatrixXd P = H.inverse();
  const std::size_t node = start.last_node - 1;
  const Eigen::Matrix3d begun = start_covariance(w.t, stretch, w.model, 0.0, node),
                        marginal = P.bottomRightCorner<3, 3>();
  const double inflation = begun.trace() / marginal.trace();
  EXPECT_GE(inflation, 1.0);
  EXPECT_LT((begun - inflation * marginal).norm(), 1e-6 * begun.norm());
}

}  // namespace drive_start_test
}  // namespace octant::test
