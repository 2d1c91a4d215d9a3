// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The description of the datum by the site file; its free motions compared with rigid motions of the map.
#include "calib/verdict/datum.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "calib/adjust/priors.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace datum_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

calib::Problem hall_problem() {
  calib::Problem problem;
  problem.site = hall_scenario().site;
  problem.runs.resize(1);
  problem.typical_range_m = 10.0;
  return problem;
}

void hold(calib::Problem& problem, std::size_t control_points, std::optional<double> others_sigma_m) {
  for (std::size_t b = 0; b < problem.site.beacons.size(); ++b) {
    const std::optional<double> sigma = b < control_points ? std::optional(0.0) : others_sigma_m;
    problem.site.beacons[b].sigma_m = {sigma, sigma, sigma};
    if (!sigma) problem.site.beacons[b].position_m = {};
  }
}

TEST(DatumOf, TakesControlPointsFirst) {
  const Datum datum = calib::datum_of(hall_problem());
  EXPECT_EQ(datum.position, "control points");
  EXPECT_EQ(datum.orientation, "control points");
  EXPECT_THAT(datum.scale, HasSubstr("control points"));
  EXPECT_THAT(datum.control_points, ElementsAre("B0", "B3", "B6"));
  EXPECT_THAT(datum.description, HasSubstr("position by control points (B0, B3, B6), orientation by"));
}

TEST(DatumOf, OneControlPointHoldsThePlaceAlone) {
  calib::Problem problem = hall_problem();
  hold(problem, 1, 0.3);
  Datum datum = calib::datum_of(problem);
  EXPECT_EQ(datum.position, "control points");
  EXPECT_EQ(datum.orientation, "approximate beacon positions (priors)");
  EXPECT_THAT(datum.scale, Not(HasSubstr("control points")));
  hold(problem, 1, std::nullopt);
  EXPECT_EQ(calib::datum_of(problem).orientation, "inner constraints (free network)");
  problem.runs[0].poses.resize(1);
  datum = calib::datum_of(problem);
  EXPECT_EQ(datum.orientation, "measured poses");
  EXPECT_THAT(datum.scale, HasSubstr("measured poses"));
}

TEST(DatumOf, PosesGoBeforeApproximatePositions) {
  calib::Problem problem = hall_problem();
  hold(problem, 0, 0.3);
  EXPECT_EQ(calib::datum_of(problem).position, "approximate beacon positions (priors)");
  problem.runs[0].poses.resize(1);
  EXPECT_EQ(calib::datum_of(problem).position, "measured poses");
  problem.runs[0].poses.clear();
  hold(problem, 0, std::nullopt);
  EXPECT_EQ(calib::datum_of(problem).position, "inner constraints (free network)");
}

TEST(DatumOf, ListsAllThatCarriesTheScale) {
  calib::Problem problem = hall_problem();
  hold(problem, 0, std::nullopt);
  problem.site.receivers.resize(1);
  problem.site.speed_sigma_mps = 100.0;
  EXPECT_EQ(calib::datum_of(problem).scale, "nothing");
  problem.site.speed_sigma_mps = 2.0;
  EXPECT_EQ(calib::datum_of(problem).scale, "medium (speed prior)");
  problem.site.speed_sigma_mps = 0.0;
  EXPECT_EQ(calib::datum_of(problem).scale, "medium (speed held)");
  problem.site.distances.push_back({BeaconId(0), BeaconId(1), 5.0, 0.01});
  problem.runs[0].odometry.resize(2);
  problem.site.receivers.resize(2);
  EXPECT_EQ(calib::datum_of(problem).scale, "taped distances, odometry, receiver array, medium (speed held)");
}

TEST(SetFreeNetwork, LeavesWhatControlPointsHold) {
  calib::Problem problem = hall_problem();
  hold(problem, 1, 0.3);
  Datum datum = calib::datum_of(problem);
  calib::set_free_network(datum);
  EXPECT_EQ(datum.position, "control points");
  EXPECT_EQ(datum.orientation, "inner constraints (free network)");
  EXPECT_THAT(datum.description, HasSubstr("orientation by inner constraints (free network)"));
}

/// Beacons without priors, tied to each other by tapes between all of them.
calib::Problem taped(Motion motion) {
  calib::Problem problem = hall_problem();
  problem.site.motion = motion;
  for (int a = 0; a < 8; ++a) {
    for (std::size_t i = 0; i < 3; ++i)
      problem.site.beacons[static_cast<std::size_t>(a)].sigma_m[i] = std::nullopt;
    for (int b = 0; b < a; ++b) problem.site.distances.push_back({BeaconId(a), BeaconId(b), 0.0, 0.01});
  }
  return problem;
}

struct Net {
  calib::Problem problem;
  SharedState state;
  calib::ParameterLayout layout;
  Eigen::MatrixXd N;

  explicit Net(calib::Problem p) : problem(std::move(p)), state(hall_state()) {
    layout = calib::make_layout(problem, state);
    N = calib::prior_information(problem, layout, layout.vector_of(state));
    for (int c = 0; c < layout.size(); ++c)  // all else is known
      if (layout.parameters[static_cast<std::size_t>(c)].id.kind != ParameterKind::kBeaconPosition)
        N(c, c) += 1e6;
  }
  static SharedState hall_state() { return prior_state(hall_scenario().site); }
  /// The vector by which a motion moves the beacons.
  [[nodiscard]] Eigen::VectorXd moved_by(const Pose& T) const {
    SharedState there = state;
    for (Eigen::Vector3d& p : there.beacon_p_map_m) p = T * p;
    return layout.vector_of(there) - layout.vector_of(state);
  }
};

TEST(FreeDatum, OfANetOfTapesIsEveryRigidMotion) {
  // Heights are known in the plane by the arrivals, which this network does not have.
  Net net(taped(Motion::kSpatial));
  const Eigen::MatrixXd F = calib::free_datum(net.problem, net.layout, net.state, net.N);
  ASSERT_EQ(F.cols(), 6);
  EXPECT_LT((F.transpose() * F - Eigen::MatrixXd::Identity(6, 6)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((net.N * F).cwiseAbs().maxCoeff(), 1e-9 * net.N.cwiseAbs().maxCoeff());
  const double a = 1e-7;  // turns to second order are 1e-13 of twenty metres
  for (const Pose& T :
       {Pose{{1, 2, 3}, Eigen::Quaterniond::Identity()}, Pose{{0, 0, 0}, exp_rotation({a, 0, 0})},
        Pose{{0, 0, 0}, exp_rotation({0, -a, 0.5 * a})}}) {
    const Eigen::VectorXd v = net.moved_by(T);
    EXPECT_LT((v - F * (F.transpose() * v)).norm(), 1e-6 * v.norm());
  }
}

TEST(FreeDatum, InThePlaneIsTwoShiftsAndATurn) {
  Net net(taped(Motion::kPlanar));
  for (const auto& beacon : net.layout.beacon) net.N(beacon[2], beacon[2]) += 1e4;
  const Eigen::MatrixXd F = calib::free_datum(net.problem, net.layout, net.state, net.N);
  ASSERT_EQ(F.cols(), 3);
  for (const auto& beacon : net.layout.beacon) EXPECT_EQ(F.row(beacon[2]).norm(), 0.0);
  for (const Pose& T : {Pose::planar(1, -2, 0), Pose::planar(0, 0, 1e-7)}) {
    const Eigen::VectorXd v = net.moved_by(T);
    EXPECT_LT((v - F * (F.transpose() * v)).norm(), 1e-6 * v.norm());
  }
  const Eigen::MatrixXd sparse =
      calib::free_datum(net.problem, net.layout, net.state, Eigen::SparseMatrix<double>(net.N.sparseView()));
  EXPECT_LT((F * F.transpose() - sparse * sparse.transpose()).cwiseAbs().maxCoeff(), 1e-9)
      << "of either matrix";
}

TEST(FreeDatum, AControlPointLeavesTheTurnsAboutItAndTwoInThePlaneNone) {
  for (const std::size_t points : {1U, 2U}) {
    calib::Problem problem = taped(Motion::kPlanar);
    for (std::size_t b = 0; b < points; ++b) problem.site.beacons[b].sigma_m = {0.0, 0.0, 0.0};
    Net net(problem);
    for (const auto& beacon : net.layout.beacon)
      if (beacon[2] >= 0) net.N(beacon[2], beacon[2]) += 1e4;
    const Eigen::MatrixXd F = calib::free_datum(net.problem, net.layout, net.state, net.N);
    EXPECT_EQ(F.cols(), points == 1 ? 1 : 0);
    if (points != 1) continue;
    const Eigen::Vector3d pivot = net.state.beacon_p_map_m[0];
    Pose T = Pose::planar(0, 0, 1e-7);
    T.translation_m = pivot - T.rotation * pivot;
    const Eigen::VectorXd v = net.moved_by(T);
    EXPECT_LT((v - F * (F.transpose() * v)).norm(), 1e-6 * v.norm());
  }
}

// Eight beacons known to sigma hold their map to sigma / sqrt(8), which has to be a quarter of the range.
TEST(FreeDatum, PositionsGivenToManyMetresCarryNoMap) {
  for (const auto& [sigma_m, motions] : {std::pair{6.9, 0}, {7.2, 3}}) {
    calib::Problem problem = taped(Motion::kPlanar);
    for (SiteBeacon& b : problem.site.beacons) b.sigma_m = {sigma_m, sigma_m, 0.01};
    Net net(problem);
    EXPECT_EQ(calib::free_datum(net.problem, net.layout, net.state, net.N).cols(), motions) << sigma_m;
  }
}

TEST(FreeDatum, OfNoFreeBeaconIsNone) {
  calib::Problem problem = taped(Motion::kPlanar);
  hold(problem, 8, 0.0);
  Net net(problem);
  EXPECT_EQ(calib::free_datum(net.problem, net.layout, net.state, net.N).cols(), 0);
  const calib::ParameterLayout nothing;
  EXPECT_EQ(calib::free_datum(net.problem, nothing, net.state, Eigen::MatrixXd(0, 0)).cols(), 0);
}

}  // namespace datum_test
}  // namespace octant::test
