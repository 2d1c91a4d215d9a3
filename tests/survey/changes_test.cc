// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/changes.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "tests/survey/report_input.h"

namespace octant::survey {
namespace changes_test {

TEST(Changes, ChanceIsUniformWhereNothingMoved) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const int trials = 4000;
  int below = 0;
  for (int i = 0; i < trials; ++i) {
    Deployment before = full_report().plan.deployment, now = before;
    for (int axis = 0; axis < 3; ++axis) {
      before.beacons[1].position_m[axis] += 0.002 * normal(random);
      now.beacons[1].position_m[axis] += 0.002 * normal(random);
    }
    below += *changes_between(before, now).beacons[1].p < 0.1;
  }
  // 400 expected, standard deviation 19: five of them.
  EXPECT_NEAR(below, 400, 95);
}

TEST(Changes, FindsWhatMoved) {
  Deployment before = full_report().plan.deployment, now = before;
  now.beacons[1].position_m.x() += 0.02;
  now.beacons[2].name = "new";
  const Changes changes = changes_between(before, now);
  ASSERT_EQ(changes.beacons.size(), 2u);
  EXPECT_FALSE(changes.beacons[0].p.has_value());  // a control point in both
  EXPECT_FALSE(changes.beacons[0].significant);
  EXPECT_TRUE(changes.beacons[1].significant);
  EXPECT_NEAR(changes.beacons[1].sigma_m.x(), 0.002 * std::sqrt(2.0), 1e-12);
  EXPECT_EQ(changes.gone, std::vector<std::string>{"B2"});
  EXPECT_EQ(changes.added, std::vector<std::string>{"new"});
  EXPECT_TRUE(changes.same_datum);
  now.datum.control_points = {"B1"};
  EXPECT_FALSE(changes_between(before, now).same_datum);
}

/// Changes found by the visit are not searched again in the difference of the files, which could give another
/// result.
TEST(Changes, OfARecalibrationAreThoseThatItsVisitFound) {
  Deployment before = full_report().plan.deployment, now = before;
  before.digest = "first";
  now.beacons[1].position_m.x() += 0.02;
  Change found;
  found.subject = now.beacons[2].name;
  found.size = 0.1;
  now.previous = Previous{before.digest, before.created, {}, {}, {found}};
  const Changes changes = changes_between(before, now);
  ASSERT_EQ(changes.found.size(), 1u);
  EXPECT_EQ(changes.found[0].subject, now.beacons[2].name);
  for (const BeaconChange& c : changes.beacons) EXPECT_EQ(c.significant, c.name == found.subject) << c.name;
  before.digest = "another";
  EXPECT_TRUE(changes_between(before, now).beacons[1].significant);
}

TEST(Changes, KnownHeightIsNoDirectionToJudgeBy) {
  Deployment before = full_report().plan.deployment;
  before.beacons[1].covariance_m2 = Eigen::Vector3d(4e-6, 4e-6, 0).asDiagonal();
  Deployment now = before;
  now.beacons[1].position_m.x() += std::sqrt(8e-6 * 5.991);
  EXPECT_NEAR(*changes_between(before, now).beacons[1].p, 0.05, 2e-5);  // two degrees of freedom
}

TEST(Changes, ADelayIsAPartOfTheTest) {
  Deployment before = full_report().plan.deployment;
  before.timing.delay_per.beacon = true;
  for (DeploymentBeacon& b : before.beacons) b.delay_sigma_s = 1e-5;
  Deployment now = before;
  now.beacons[1].delay_s += 178e-6;  // 12.6 sigma
  const Changes changes = changes_between(before, now);
  EXPECT_TRUE(changes.beacons[1].delay_significant);
  EXPECT_TRUE(changes.beacons[1].changed());
  EXPECT_FALSE(changes.beacons[1].moved());
  EXPECT_FALSE(changes.beacons[2].changed());
  EXPECT_TRUE(changes.doubted_control_points.empty());
  now.timing.delay_per = {};  // the site's one delay is nobody's own
  EXPECT_FALSE(changes_between(before, now).beacons[1].delay_p.has_value());
}

/// A control point that moved: its delay adapts, and the others with it. They are not accused.
TEST(Changes, ADoubtfulControlPointMayExplainTheShiftsOfOthers) {
  Deployment before = full_report().plan.deployment;
  before.timing.delay_per.beacon = true;
  for (DeploymentBeacon& b : before.beacons) b.delay_sigma_s = 1e-5;
  Deployment now = before;
  ASSERT_EQ(now.beacons[0].status, BeaconStatus::kControlPoint);
  now.beacons[0].delay_s -= 387e-6;
  now.beacons[1].position_m.x() += 0.05;
  const Changes changes = changes_between(before, now);
  EXPECT_EQ(changes.doubted_control_points, std::vector<std::string>{now.beacons[0].name});
  EXPECT_TRUE(changes.beacons[1].by_datum);
  EXPECT_FALSE(changes.beacons[1].moved());
}

bool is_told(const Changes& changes, ChangeKind kind, const std::string& subject) {
  return std::any_of(changes.found.begin(), changes.found.end(),
                     [&](const Change& c) { return c.kind == kind && c.subject == subject; });
}

/// A beacon replaced at a control point's position, with a delay of 9 mm, moves no other by half a metre.
TEST(Changes, ASmallDelayOfAControlPointExplainsNoLargeShift) {
  Deployment before = full_report().plan.deployment;
  before.timing.delay_per.beacon = true;
  for (DeploymentBeacon& b : before.beacons) b.delay_sigma_s = 1e-6;
  Deployment now = before;
  now.beacons[0].delay_s += 25e-6;
  now.beacons[1].position_m.x() += 0.5;
  const Changes changes = changes_between(before, now);
  EXPECT_EQ(changes.doubted_control_points.size(), 1u);
  EXPECT_TRUE(changes.beacons[1].moved());
  EXPECT_TRUE(is_told(changes, ChangeKind::kBeaconMoved, now.beacons[1].name));
  EXPECT_TRUE(is_told(changes, ChangeKind::kDelay, now.beacons[0].name));
}

/// A control point that was surveyed again at another position is there, for any delay of another one.
TEST(Changes, AControlPointStatedElsewhereIsTold) {
  Deployment before = full_report().plan.deployment;
  before.timing.delay_per.beacon = true;
  for (DeploymentBeacon& b : before.beacons) b.delay_sigma_s = 1e-6;
  before.beacons[2].status = BeaconStatus::kControlPoint;
  before.beacons[2].covariance_m2.setZero();
  Deployment now = before;
  now.beacons[0].position_m.y() += 0.5;
  now.beacons[2].delay_s += 25e-6;
  const Changes changes = changes_between(before, now);
  ASSERT_EQ(changes.doubted_control_points, std::vector<std::string>{now.beacons[2].name});
  EXPECT_TRUE(changes.beacons[0].moved());
  EXPECT_TRUE(is_told(changes, ChangeKind::kBeaconMoved, now.beacons[0].name));
}

TEST(Changes, AnotherSourceOfTheScaleIsNoOtherFrame) {
  Deployment before = full_report().plan.deployment, now = before;
  before.datum.scale = "control points, medium, odometry";
  now.datum.scale = "control points, medium";
  EXPECT_TRUE(changes_between(before, now).same_datum);
  std::reverse(now.datum.control_points.begin(), now.datum.control_points.end());
  EXPECT_TRUE(changes_between(before, now).same_datum);
}

}  // namespace changes_test
}  // namespace octant::survey
