// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Information of a stop, compared with numeric derivatives of the times of flight and a dense Schur
// complement.
#include "calib/plan/station_information.h"

#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "tests/support/worlds.h"

namespace octant::test {
namespace station_information_test {

/// Four beacons known to 0.2 m, three receivers without axes, a delay of each beacon, one speed.
Site small_site() {
  Site site = hall_scenario().site;
  site.beacons = {beacon("A", {0, 0, 2.5}, 0.2), beacon("B", {8, 1, 2.4}, 0.2), beacon("C", {7, 6, 2.6}, 0.2),
                  beacon("D", {-1, 5, 2.3}, 0.2)};
  site.vehicles.clear();
  site.receivers.clear();
  add_receivers(site, {{0.3, 0.0, 0.3}, {-0.2, 0.2, 0.3}, {-0.1, -0.3, 0.3}}, 0.002);
  return site;
}

/// Times of flight to all receivers from all beacons, in sigmas.
Eigen::VectorXd predicted(const calib::Knowledge& k, const SharedState& state, const Eigen::Vector3d& pose) {
  const Pose T = Pose::planar(pose.x(), pose.y(), pose.z());
  const double speed = speed_mps(k.problem.site.medium) + state.speed_offset(0);
  Eigen::VectorXd t(12);
  for (std::size_t r = 0, i = 0; r < 3; ++r)
    for (std::size_t b = 0; b < 4; ++b, ++i)
      t[static_cast<Eigen::Index>(i)] =
          ((T * state.receiver_p_vehicle_m[r] - state.beacon_p_map_m[b]).norm() / speed +
           state.delay_s(BeaconId(b), ReceiverId(r))) /
          k.tof_sigma_s;
  return t;
}

Eigen::MatrixXd dense_information(const calib::Knowledge& k, const Eigen::Vector3d& pose) {
  const Eigen::VectorXd x = k.layout.vector_of(k.state);
  constexpr double kStep = 1e-5;
  Eigen::MatrixXd Js(12, x.size()), Jx(12, 3);
  for (Eigen::Index c = 0; c < x.size(); ++c) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(x.size(), c);
    Js.col(c) =
        (predicted(k, k.layout.state_of(x + step), pose) - predicted(k, k.layout.state_of(x - step), pose)) /
        (2 * kStep);
  }
  for (int p = 0; p < 3; ++p)
    Jx.col(p) = (predicted(k, k.state, pose + kStep * Eigen::Vector3d::Unit(p)) -
                 predicted(k, k.state, pose - kStep * Eigen::Vector3d::Unit(p))) /
                (2 * kStep);
  const Eigen::MatrixXd taken = Jx * (Jx.transpose() * Jx).ldlt().solve(Jx.transpose());
  return Js.transpose() * (Eigen::MatrixXd::Identity(12, 12) - taken) * Js;
}

TEST(StationInformation, RowsSquareToTheDenseSchurComplement) {
  const calib::Knowledge k = must(calib::knowledge_of(small_site()));
  for (const Eigen::Vector3d& pose :
       {Eigen::Vector3d(3, 3, 0.4), Eigen::Vector3d(6, 1.5, -2.0), Eigen::Vector3d(0.5, 4.5, 3.0)}) {
    const calib::StopRows rows = calib::stop_rows(k, pose.head<2>(), pose.z(), {});
    EXPECT_EQ(rows.arrival_count, 12U);
    EXPECT_EQ(rows.arrivals, (std::vector<std::size_t>{3, 3, 3, 3}));
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(k.layout.size(), k.layout.size());
    calib::add_information(rows, information);
    const Eigen::MatrixXd dense = dense_information(k, pose);
    // Central differences of 1e-5: nine digits of the largest element, less what eliminating the pose costs.
    EXPECT_LT((information - dense).cwiseAbs().maxCoeff(), 1e-6 * dense.cwiseAbs().maxCoeff());
    calib::add_information(rows, information, -1.0);
    EXPECT_LT(information.cwiseAbs().maxCoeff(), 1e-9 * dense.cwiseAbs().maxCoeff());
  }
}

TEST(StationInformation, FiringsCountAsManyArrivals) {
  const calib::Knowledge k = must(calib::knowledge_of(small_site()));
  const Eigen::Index n = k.layout.size();
  Eigen::MatrixXd once = Eigen::MatrixXd::Zero(n, n), four = once;
  calib::add_information(calib::stop_rows(k, {3, 3}, 0.4, {}), once);
  const calib::StopRows rows = calib::stop_rows(k, {3, 3}, 0.4, {.firings = 4});
  calib::add_information(rows, four);
  EXPECT_EQ(rows.arrival_count, 48U);
  EXPECT_LT((four - 4 * once).norm(), 1e-9 * four.norm());
}

TEST(StationInformation, OnlyWhatIsSurelyHeardCounts) {
  const calib::Knowledge k = must(calib::knowledge_of(small_site()));
  calib::StopModel model;
  model.hearing.range_m = 6.0;
  const Eigen::Vector2d at(6.5, 3.0);
  const calib::StopRows rows = calib::stop_rows(k, at, 0.0, model);
  // Range minus twice the worst coordinate's 0.2 m, at most a tenth: B and C are within 5.4 m, A and D are
  // not.
  EXPECT_EQ(rows.arrivals, (std::vector<std::size_t>{0, 3, 3, 0}));
  model.hearing.also = [](BeaconId b, ReceiverId, const Pose&) { return b == BeaconId(1); };
  EXPECT_EQ(calib::stop_rows(k, at, 0.0, model).arrivals, (std::vector<std::size_t>{0, 3, 0, 0}));
}

/// The heading about a single receiver changes no range, and its offset from the vehicle frame is no
/// obstacle.
TEST(StationInformation, ASingleReceiverNeedsNoHeading) {
  Site site = small_site();
  site.receivers.resize(1);
  site.vehicles[0].receiver_count = 1;
  const auto information = [&](double forward_m, double heading_rad) {
    site.receivers[0].position_m = {forward_m, 0.0, site.receivers[0].position_m.z()};
    const calib::Knowledge k = must(calib::knowledge_of(site));
    const Eigen::Vector2d receiver_m(4.0, 2.0),
        ahead_m = forward_m * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
    const calib::StopRows rows = calib::stop_rows(k, receiver_m - ahead_m, heading_rad, {});
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(k.layout.size(), k.layout.size());
    if (rows.A.rows() > 0) calib::add_information(rows, sum);
    return Eigen::MatrixXd(sum(k.layout.beacon_columns(), k.layout.beacon_columns()));
  };
  const Eigen::MatrixXd at_centre = information(0.0, 0.0);
  EXPECT_GT(at_centre.norm(), 0.0);
  EXPECT_LT((information(0.2, 0.0) - at_centre).norm(), 1e-6 * at_centre.norm());
  EXPECT_LT((information(0.2, 1.1) - at_centre).norm(), 1e-6 * at_centre.norm());
}

/// The ranges of one beacon do not determine a pose, and thus no shared parameter.
TEST(StationInformation, NoRowsWhereThePoseIsNotTold) {
  const calib::Knowledge k = must(calib::knowledge_of(small_site()));
  calib::StopModel model;
  model.hearing.also = [](BeaconId, ReceiverId r, const Pose&) { return r == ReceiverId(0); };
  model.hearing.range_m = 5.0;
  const calib::StopRows rows = calib::stop_rows(k, {7.9, 1.1}, 0.0, model);
  EXPECT_EQ(rows.A.rows(), 0);
}

}  // namespace station_information_test
}  // namespace octant::test
