// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/pose.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"
#include "tests/support/numeric.h"

namespace octant {
namespace pose_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Rotation vectors of all lengths, with many near the singular ones: 0, the switch to the series, a half
/// turn.
Vector3d random_rotation_vector() {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Vector3d axis = draws.normal3().normalized();
  switch (*rc::gen::inRange(0, 4)) {
    case 0: return draws.log_uniform(1e-14, 1e-3) * axis;
    case 1: return draws.uniform(0.9e-4, 1.1e-4) * axis;
    case 2: return (M_PI - draws.log_uniform(1e-9, 1e-1)) * axis;
    default: return draws.uniform(0.0, M_PI) * axis;
  }
}

Pose random_pose() {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Vector3d p = 10 * draws.normal3();
  return {p, exp_rotation(random_rotation_vector())};
}

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return log_rotation(a.conjugate() * b).norm();
}

RC_GTEST_PROP(Rotation, LogUndoesExp, ()) {
  const Vector3d phi = random_rotation_vector();
  RC_ASSERT((log_rotation(exp_rotation(phi)) - phi).norm() < 1e-14);  // a few roundings of pi
}

RC_GTEST_PROP(Rotation, LogDoesNotDependOnTheSignOfTheQuaternion, ()) {
  const Eigen::Quaterniond q = exp_rotation(random_rotation_vector());
  RC_ASSERT((log_rotation(q) - log_rotation(Eigen::Quaterniond(-q.coeffs()))).norm() < 1e-15);
}

RC_GTEST_PROP(Rotation, ExpAgreesWithEigen, ()) {
  const Vector3d phi = random_rotation_vector();
  const Eigen::AngleAxisd eigen(phi.norm(), phi.normalized());
  RC_ASSERT((exp_rotation(phi).toRotationMatrix() - eigen.toRotationMatrix()).norm() < 1e-14);
}

TEST(Rotation, NothingAndHalfATurn) {
  EXPECT_TRUE(exp_rotation(Vector3d::Zero()).coeffs().isApprox(Eigen::Quaterniond::Identity().coeffs()));
  EXPECT_EQ(log_rotation(Eigen::Quaterniond::Identity()).norm(), 0.0);
  EXPECT_NEAR(log_rotation(Eigen::Quaterniond(0, 0, 0, 1)).z(), M_PI, 1e-15);
  EXPECT_EQ(right_jacobian(Vector3d::Zero()), Matrix3d::Identity());
  EXPECT_EQ(right_jacobian_inverse(Vector3d::Zero()), Matrix3d::Identity());
}

RC_GTEST_PROP(Rotation, SkewIsTheCrossProduct, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  const Vector3d a = draws.normal3(), b = draws.normal3();
  RC_ASSERT((skew(a) * b - a.cross(b)).norm() < 1e-15 * 10);
}

RC_GTEST_PROP(Rotation, RightJacobianIsTheDerivative, ()) {
  const Vector3d phi = random_rotation_vector();
  const Eigen::Quaterniond back = exp_rotation(phi).conjugate();
  const auto f = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return log_rotation(back * exp_rotation(x));
  };
  // Central differences with 1e-5: truncation 1e-11, rounding 1e-16 / 1e-5.
  RC_ASSERT((right_jacobian(phi) - test::numeric_jacobian(f, phi, 1e-5)).norm() < 1e-9);
}

RC_GTEST_PROP(Rotation, InverseOfTheRightJacobian, ()) {
  const Vector3d phi = random_rotation_vector();
  RC_ASSERT((right_jacobian(phi) * right_jacobian_inverse(phi) - Matrix3d::Identity()).norm() < 1e-11);
}

RC_GTEST_PROP(Rotation, InverseRightJacobianIsTheDerivativeOfLog, ()) {
  const Vector3d phi = random_rotation_vector();
  RC_PRE(phi.norm() < M_PI - 1e-3);  // beyond, the difference steps over the half turn
  const Eigen::Quaterniond q = exp_rotation(phi);
  const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return log_rotation(q * exp_rotation(d));
  };
  RC_ASSERT((right_jacobian_inverse(phi) - test::numeric_jacobian(f, Vector3d::Zero(), 1e-5)).norm() < 1e-8);
}

RC_GTEST_PROP(Angle, IsWrappedIntoTheHalfOpenTurn, ()) {
  const double angle = *rc::gen::inRange(-100000, 100000) * 1e-3;
  const double wrapped = wrap_angle(angle);
  RC_ASSERT(wrapped > -M_PI && wrapped <= M_PI);
  RC_ASSERT(std::abs(std::sin(wrapped) - std::sin(angle)) < 1e-13 &&
            std::abs(std::cos(wrapped) - std::cos(angle)) < 1e-13);
}

TEST(Angle, HalfTurnIsPositive) {
  EXPECT_EQ(wrap_angle(M_PI), M_PI);
  EXPECT_EQ(wrap_angle(-M_PI), M_PI);
  EXPECT_EQ(wrap_angle(3 * M_PI), M_PI);
}

RC_GTEST_PROP(PoseGroup, InverseUndoes, ()) {
  const Pose T = random_pose();
  const Pose I = T.inverse() * T;
  RC_ASSERT(I.translation_m.norm() < 1e-13 && log_rotation(I.rotation).norm() < 1e-14);
}

RC_GTEST_PROP(PoseGroup, ProductActsInOrder, ()) {
  const Pose a = random_pose(), b = random_pose();
  const Vector3d p(1.0, -2.0, 3.0);
  RC_ASSERT(((a * b) * p - a * (b * p)).norm() < 1e-13);
}

RC_GTEST_PROP(PlanarPose, KeepsItsHeading, ()) {
  const double heading = *rc::gen::inRange(-3141592, 3141592) * 1e-6;
  const Pose T = Pose::planar(3.0, -4.0, heading);
  RC_ASSERT(std::abs(T.heading_rad() - heading) < 1e-15 * 4);
  const Vector3d ahead = T * Vector3d(1, 0, 0);  // counter-clockwise from +x, right-handed
  RC_ASSERT((ahead - Vector3d(3 + std::cos(heading), -4 + std::sin(heading), 0)).norm() < 1e-15 * 10);
}

RC_GTEST_PROP(Interpolation, MeetsItsEndsAndTurnsEvenly, ()) {
  const Pose a = random_pose();
  const Vector3d phi = random_rotation_vector();
  RC_PRE(phi.norm() < M_PI - 1e-6);  // at a half turn the shorter way is not decided
  const Pose b{a.translation_m + Vector3d(1, 2, -3), a.rotation * exp_rotation(phi)};
  for (double alpha : {0.0, 0.25, 1.0}) {
    const Pose T = interpolate(a, b, alpha);
    RC_ASSERT((T.translation_m - a.translation_m - alpha * Vector3d(1, 2, -3)).norm() < 1e-13);
    RC_ASSERT(angle_between(T.rotation, a.rotation * exp_rotation(alpha * phi)) < 1e-13);
  }
}

TEST(Interpolation, TakesTheShortWayOverTheCut) {
  const Pose T = interpolate(Pose::planar(0, 0, 3.0), Pose::planar(0, 0, -3.0), 0.5);
  EXPECT_NEAR(std::abs(T.heading_rad()), M_PI, 1e-15);
}

RC_GTEST_PROP(Retract, NothingMovesNothing, ()) {
  const Pose T = random_pose();
  const Pose same = retract(T, Eigen::VectorXd::Zero(6), Motion::kSpatial);
  RC_ASSERT((same.translation_m - T.translation_m).norm() == 0.0 &&
            angle_between(same.rotation, T.rotation) < 1e-15 * 10);
}

RC_GTEST_PROP(Retract, PlanarAddsInTheMap, ()) {
  const Pose T = Pose::planar(1.0, 2.0, *rc::gen::inRange(-3141, 3141) * 1e-3);
  const Pose moved = retract(T, Vector3d(0.1, -0.2, 0.3), Motion::kPlanar);
  RC_ASSERT((moved.translation_m - Vector3d(1.1, 1.8, 0.0)).norm() < 1e-15);
  RC_ASSERT(std::abs(wrap_angle(moved.heading_rad() - T.heading_rad() - 0.3)) < 1e-14);
}

RC_GTEST_PROP(Retract, SpatialTurnsInTheVehicleFrame, ()) {
  const Pose T = random_pose();
  Eigen::VectorXd delta(6);
  delta << 0.1, -0.2, 0.3, 0.01, 0.02, -0.03;
  const Pose moved = retract(T, delta, Motion::kSpatial);
  RC_ASSERT((moved.translation_m - T.translation_m - delta.head<3>()).norm() < 1e-13);
  RC_ASSERT((log_rotation(T.rotation.conjugate() * moved.rotation) - delta.tail<3>()).norm() < 1e-14);
}

TEST(Pose, TheTangentBetweenTwoIsWhatRetractMovesBy) {
  const Pose T{{1.0, 2.0, 0.5}, exp_rotation({0.2, -0.3, 0.7})};
  Eigen::VectorXd delta(6);
  delta << 0.1, -0.2, 0.3, 0.4, -0.1, 0.2;
  EXPECT_LT((tangent_between(T, retract(T, delta, Motion::kSpatial), Motion::kSpatial) - delta).norm(),
            1e-12);
  // Over the cut of the angle.
  const Pose planar = Pose::planar(1.0, 2.0, 3.1);
  const Vector3d moved(0.1, -0.2, 0.3);
  const PoseTangent back = tangent_between(planar, retract(planar, moved, Motion::kPlanar), Motion::kPlanar);
  ASSERT_EQ(back.size(), 3);
  EXPECT_LT((back - moved).norm(), 1e-12);
}

}  // namespace pose_test
}  // namespace octant
