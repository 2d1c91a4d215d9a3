// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/physics/measurement.h"

#include <array>
#include <cmath>
#include <random>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/numeric.h"

namespace octant {
namespace measurement_test {

/// Unknowns of one arrival: beacon 3, receiver 3, speed, delay, attenuation 4, pose tangent 6.
constexpr int kUnknowns = 18;
using Jet = ceres::Jet<double, kUnknowns>;
template <class T>
using V3 = Eigen::Matrix<T, 3, 1>;

struct Setting {
  Pose T;
  Eigen::Vector3d beacon, receiver;
  double speed = 343.0, delay = 1e-4;
  AttenuationModel attenuation{12.5, 0.12, 0.05, 4.5e-4};
  bool with_attenuation = true, two_way = false;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  Pose T_hear_send;
  Motion motion = Motion::kPlanar;
};

/// The measurement equation written a second time, for any scalar: tof and log amplitude.
template <class T>
std::array<T, 2> equation(const Setting& s, const T* x) {
  using std::cos;
  using std::exp;
  using std::log;
  using std::sqrt;
  const V3<T> beacon = s.beacon.cast<T>() + V3<T>(x[0], x[1], x[2]);
  const V3<T> receiver = s.receiver.cast<T>() + V3<T>(x[3], x[4], x[5]);
  const V3<T> move(x[12], x[13], s.motion == Motion::kPlanar ? T(0) : x[14]);
  const V3<T> turn = s.motion == Motion::kPlanar ? V3<T>(T(0), T(0), x[14]) : V3<T>(x[15], x[16], x[17]);
  const Eigen::Matrix<T, 3, 3> R = s.T.rotation.toRotationMatrix().cast<T>();
  // At the origin of the tangent Exp(turn) o is o + turn x o to second order, and derivatives are defined
  // there.
  const auto at = [&](const V3<T>& o) -> V3<T> {
    return R * (o + turn.cross(o)) + s.T.translation_m.cast<T>() + move;
  };
  const auto length = [](const V3<T>& v) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); };
  T d = length(at(receiver) - beacon);
  T path = d;
  if (s.two_way) {
    const V3<T> o = s.T_hear_send.rotation.toRotationMatrix().cast<T>() * receiver +
                    s.T_hear_send.translation_m.cast<T>();
    path = d + length(at(o) - beacon);
    d = path / T(2);
  }
  T tof = path / (T(s.speed) + x[6]) + T(s.delay) + x[7], log_amplitude = T(0);
  if (s.with_attenuation) {
    log_amplitude = log(T(s.attenuation.amplitude_1m_v) + x[8]) - log(d) -
                    (T(s.attenuation.absorption_np_per_m) + x[9]) * d;
    if (s.attenuation.directional() && !s.axis.isZero()) {
      // ((1 + cos) / 2)^m = cos(theta / 2)^(2 m): 3 dB down at the half-power angle. The reply's way back
      // counts.
      const V3<T> back = beacon - at(receiver),
                  axis = R * (s.axis.cast<T>() + turn.cross(V3<T>(s.axis.cast<T>())));
      const T cosine = axis.dot(back) / length(back),
              half = (T(s.attenuation.half_power_angle_rad) + x[11]) / T(2);
      log_amplitude += T(-0.5 * std::log(2.0)) / log(cos(half) * cos(half)) * log((T(1) + cosine) / T(2));
    }
    tof = tof - (T(s.attenuation.rise_time_s) + x[10]) *
                    log(T(1) - T(s.attenuation.threshold_v) / exp(log_amplitude));
  }
  return {tof, log_amplitude};
}

void expect_derivatives(const Setting& s) {
  std::array<Jet, kUnknowns> x;
  for (int i = 0; i < kUnknowns; ++i) x[static_cast<std::size_t>(i)] = Jet(0.0, i);
  const auto expected = equation(s, x.data());
  PathInput in{&s.T,
               s.beacon,
               s.receiver,
               s.speed,
               s.delay,
               s.with_attenuation ? &s.attenuation : nullptr,
               s.two_way ? &s.T_hear_send : nullptr,
               s.axis.isZero() ? nullptr : &s.axis};
  const PathOutput out = predict_arrival(in, s.motion);
  const PathOutput value = predict_arrival_value(in);
  EXPECT_NEAR(out.tof_s, expected[0].a, 1e-15);
  EXPECT_EQ(out.tof_s, value.tof_s);
  EXPECT_EQ(out.distance_m, value.distance_m);
  Eigen::Matrix<double, 1, kUnknowns> tof, amplitude;
  const int dof = pose_dof(s.motion);
  tof << out.tof_by_beacon, out.tof_by_receiver, out.tof_by_speed, 1.0, out.tof_by_attenuation,
      out.tof_by_pose;
  // Rounding: derivatives of 1/c size, products of a handful of factors.
  for (int i = 0; i < 12 + dof; ++i)
    EXPECT_NEAR(tof[i], expected[0].v[i], 1e-12 * (1 + std::abs(expected[0].v[i]))) << i;
  if (!s.with_attenuation) return;
  EXPECT_NEAR(out.log_amplitude, expected[1].a, 1e-12);
  EXPECT_EQ(out.log_amplitude, value.log_amplitude);
  amplitude << out.log_amplitude_by_beacon, out.log_amplitude_by_receiver, 0.0, 0.0,
      out.log_amplitude_by_attenuation, out.log_amplitude_by_pose;
  for (int i = 0; i < 12 + dof; ++i)
    EXPECT_NEAR(amplitude[i], expected[1].v[i], 1e-11 * (1 + std::abs(expected[1].v[i]))) << i;
}

/// Derivatives of the receiver's directivity, in particular by its axis.
double gain_of(const Setting& s) {
  if (s.axis.isZero() || !s.attenuation.directional()) return 1.0;
  const Eigen::Vector3d towards = (s.beacon - s.T * s.receiver).normalized();
  return std::exp(
      log_directivity((s.T.rotation * s.axis).dot(towards), s.attenuation.half_power_angle_rad).value);
}

Setting random_setting(std::mt19937& random, Motion motion) {
  std::uniform_real_distribution<double> u(-1, 1);
  Setting s;
  s.motion = motion;
  s.T = Pose::planar(10 * u(random), 10 * u(random), M_PI * u(random));
  if (motion == Motion::kSpatial)
    s.T = {{5 * u(random), 5 * u(random), u(random)}, exp_rotation({u(random), u(random), 2 * u(random)})};
  s.beacon = {10 * u(random), 10 * u(random), 2.5 + u(random)};
  s.receiver = {0.3 * u(random), 0.3 * u(random), 0.3 + 0.1 * u(random)};
  s.T_hear_send = {{0.3 * u(random), 0.3 * u(random), 0.0}, exp_rotation({0, 0, 0.2 * u(random)})};
  s.axis = Eigen::Vector3d(1 + u(random), u(random), 0.3 * u(random)).normalized();
  s.attenuation.half_power_angle_rad = 0.8 + 0.6 * u(random);
  // Received at any distance: the threshold is a share of the amplitude there.
  s.attenuation.threshold_v =
      0.4 * (1 + u(random)) * amplitude_v((s.T * s.receiver - s.beacon).norm(), s.attenuation);
  return s;
}

TEST(Measurement, DerivativesAgreeWithAutomaticOnes) {
  std::mt19937 random(7);
  for (const Motion motion : {Motion::kPlanar, Motion::kSpatial})
    for (int i = 0; i < 200; ++i) {
      Setting s = random_setting(random, motion);
      s.with_attenuation = i % 2 == 0;
      s.two_way = i % 4 < 2;
      if (i % 3 == 0) s.axis.setZero();
      if (i % 5 == 0) s.attenuation.half_power_angle_rad = 0.0;
      // The threshold is below the amplitude there, as far off the axis as it is.
      s.attenuation.threshold_v *= s.with_attenuation ? gain_of(s) : 1.0;
      SCOPED_TRACE(i);
      expect_derivatives(s);
    }
}

TEST(Measurement, DerivativesHoldNearTheBeaconAndAtTheThreshold) {
  std::mt19937 random(11);
  Setting near = random_setting(random, Motion::kPlanar);
  near.beacon = near.T * near.receiver + Eigen::Vector3d(2e-3, 1e-3, -1e-3);  // 2 mm away
  near.with_attenuation = false;
  expect_derivatives(near);
  Setting weak = random_setting(random, Motion::kPlanar);
  const double d = (weak.T * weak.receiver - weak.beacon).norm();
  weak.attenuation.threshold_v =
      0.95 * gain_of(weak) * amplitude_v(d, weak.attenuation);  // walk of three rise times
  expect_derivatives(weak);
}

TEST(Measurement, StaysFiniteOnTheBeaconAndBelowTheThreshold) {
  Setting s;
  s.T = Pose::planar(1, 2, 0.3);
  s.receiver = {0.1, 0, 0.3};
  s.beacon = s.T * s.receiver;
  PathInput in{&s.T, s.beacon, s.receiver, 343.0, 0.0, &s.attenuation, nullptr};
  EXPECT_TRUE(predict_arrival(in, Motion::kPlanar).tof_by_pose.allFinite());
  in.p_beacon_map_m = {300, 0, 0};  // the model's amplitude there is far below the threshold
  const PathOutput out = predict_arrival(in, Motion::kPlanar);
  EXPECT_FALSE(out.heard);
  EXPECT_TRUE(std::isfinite(out.tof_s));
  EXPECT_TRUE(out.tof_by_attenuation.allFinite());
}

TEST(Measurement, ADirectionalReceiverHearsLessAndLaterOffItsAxis) {
  Setting s;
  s.T = Pose::planar(0, 0, 0);
  s.receiver = {0, 0, 0.3};
  s.attenuation.half_power_angle_rad = 0.3927;
  const auto at = [&](double off_rad, const Eigen::Vector3d* axis) {
    PathInput in{&s.T,       {5 * std::cos(off_rad), 5 * std::sin(off_rad), 0.3},
                 s.receiver, 343.0,
                 0.0,        &s.attenuation,
                 nullptr,    axis};
    return predict_arrival_value(in);
  };
  const Eigen::Vector3d forward = Eigen::Vector3d::UnitX(), none = Eigen::Vector3d::Zero();
  EXPECT_NEAR(at(0.0, &forward).log_amplitude, at(0.0, nullptr).log_amplitude, 1e-14);
  EXPECT_NEAR(at(0.3927, &forward).log_amplitude, at(0.0, nullptr).log_amplitude - 0.5 * std::log(2.0),
              1e-12);
  EXPECT_EQ(at(0.3927, &none).log_amplitude, at(0.3927, nullptr).log_amplitude) << "no axis: all round alike";
  EXPECT_GT(at(0.8, &forward).tof_s, at(0.4, &forward).tof_s);
  EXPECT_GT(at(0.4, &forward).tof_s, at(0.0, &forward).tof_s);
  EXPECT_FALSE(at(M_PI, &forward).heard);
}

TEST(Measurement, AMeasuredAmplitudeTakesThePlaceOfThePredictedOneInTheWalk) {
  std::mt19937 random(13);
  const Setting s = random_setting(random, Motion::kPlanar);
  PathInput in{&s.T, s.beacon, s.receiver, s.speed, s.delay, &s.attenuation, nullptr, &s.axis};
  in.log_amplitude = std::log(2 * s.attenuation.threshold_v);
  const PathOutput out = predict_arrival(in, Motion::kPlanar);
  const double flight_s = (s.T * s.receiver - s.beacon).norm() / s.speed;
  EXPECT_NEAR(out.tof_s, flight_s + s.delay + s.attenuation.rise_time_s * std::log(2.0), 1e-15);
  EXPECT_NEAR(out.tof_by_attenuation[2], std::log(2.0), 1e-14);
  EXPECT_EQ(out.tof_by_attenuation[0], 0.0);
  in.attenuation = nullptr;
  EXPECT_NEAR((out.tof_by_pose - predict_arrival(in, Motion::kPlanar).tof_by_pose).norm(), 0.0, 1e-15)
      << "nothing of the pose";
}

TEST(Measurement, BearingDerivativesAgreeWithNumericOnes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const Pose T = Pose::planar(5 * u(random), 5 * u(random), 3 * u(random));
    const Eigen::Vector3d p(8 * u(random), 8 * u(random), u(random)), o(0.2 * u(random), 0.2 * u(random), 0);
    const BearingOutput out = predict_bearing(T, p, o);
    const Eigen::MatrixXd J = test::numeric_jacobian(
        [&](const Eigen::VectorXd& x) {
          const double b =
              predict_bearing(retract(T, x.head(3), Motion::kPlanar), p + Eigen::Vector3d(x.tail<3>()), o)
                  .bearing_rad;
          return Eigen::VectorXd::Constant(1, wrap_angle(b - out.bearing_rad));
        },
        Eigen::VectorXd::Zero(6));
    EXPECT_LT((J.leftCols(3) - out.by_pose).norm(), 1e-7 * (1 + out.by_pose.norm()));
    EXPECT_LT((J.rightCols(3) - out.by_reflector).norm(), 1e-7 * (1 + out.by_reflector.norm()));
  }
}

}  // namespace measurement_test
}  // namespace octant
