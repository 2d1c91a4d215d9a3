// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/drive_tracker.h"
#include "models/localizers/drive/drive_filter.h"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "models/localizers/common/trajectory_model.h"
#include "models/simulator/random.h"
#include "models/trajectory/linearise.h"
#include "tests/models/localizers/hall.h"

// The filter that the tracker runs, in the plane and in space.
namespace octant {
namespace drive_tracker_test {

using test::hall;
using test::with_octagon;

Deployment hall_for(Motion motion) {
  Deployment d = with_octagon(hall());
  d.motion = motion;
  return d;
}

/// Tangent of b at a, as defined for Motion.
template <int kDof>
Eigen::Matrix<double, kDof, 1> difference(const Pose& a, const Pose& b) {
  Eigen::Matrix<double, kDof, 1> d;
  const Eigen::Vector3d off = b.translation_m - a.translation_m;
  if constexpr (kDof == 3) {
    d << off.head<2>(), wrap_angle(b.heading_rad() - a.heading_rad());
  } else {
    d << off, log_rotation(a.rotation.conjugate() * b.rotation);
  }
  return d;
}

/// A pose and a step of odometry, tilted in space.
template <int kDof>
std::pair<Pose, Pose> pose_and_step() {
  if constexpr (kDof == 3) return {Pose::planar(4.0, 3.0, 0.7), Pose::planar(0.2, 0.05, 0.3)};
  return {{{4.0, 3.0, 1.0}, exp_rotation({0.2, -0.3, 0.7})},
          {{0.2, 0.05, -0.1}, exp_rotation({0.1, 0.2, 0.3})}};
}

template <int kDof>
void expect_prediction_as_numeric() {
  using Filter = DriveFilterOf<kDof>;
  const Deployment d = hall_for(Filter::kMotion);
  const EpochFixModel model = epoch_fix_model(d);
  Filter filter(model, 4.0, 0.0);
  const auto [T, step] = pose_and_step<kDof>();
  typename Filter::Covariance F, P = Filter::Covariance::Identity();
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kDof; ++i) {
    const Eigen::VectorXd by = kStep * Filter::Vector::Unit(i);
    F.col(i) =
        difference<kDof>(retract(T, -by, Filter::kMotion) * step, retract(T, by, Filter::kMotion) * step) /
        (2 * kStep);
    P(i, i) = 0.01 * (i + 1);
  }
  filter.start(T, P);
  OdometryObservation noise;
  noise.distance_sigma_m = 0.02;
  noise.heading_sigma_rad = 0.03;
  filter.predict(step, noise, 0.25);
  EXPECT_LT(difference<kDof>(T * step, filter.pose()).norm(), 1e-12);
  typename Filter::Covariance expected = F * P * F.transpose();
  for (int i = 0; i < kDof; ++i) {
    const bool is_place = i < (kDof == 3 ? 2 : 3);
    expected(i, i) += 0.25 * (is_place ? 4e-4 : 9e-4);  // a quarter of the step's variance
  }
  EXPECT_LT((filter.covariance() - expected).norm(), 1e-9);  // of the numeric derivative
}

TEST(DriveFilterOf, PredictsAsItsStepsDifferentiate) {
  expect_prediction_as_numeric<3>();
  expect_prediction_as_numeric<6>();
}

/// An arrival of a beacon at a receiver, from where the vehicle is, and that much late.
Arrival heard(const Deployment& d, const Pose& T, std::size_t beacon, std::size_t receiver, double late_s) {
  Arrival a;
  a.beacon = BeaconId(beacon);
  a.receiver = ReceiverId(receiver);
  const Eigen::Vector3d p = T * d.receivers[receiver].position_m;
  a.tof_s =
      (p - d.beacons[beacon].position_m).norm() / speed_mps(d.medium) + d.beacons[beacon].delay_s + late_s;
  return a;
}

/// Arrivals in a trajectory of one node, as the tracker has them.
Trajectory trajectory_of(const Deployment& d, const std::vector<Arrival>& arrivals) {
  const TrajectoryModel model = trajectory_model(d);
  Trajectory t;
  t.motion = d.motion;
  t.moving = true;
  t.nodes.resize(1);
  for (const Arrival& a : arrivals) t.arrivals.push_back(observe(a, model, speed_of(a, model)));
  return t;
}

template <int kDof>
void expect_update_as_least_squares() {
  using Filter = DriveFilterOf<kDof>;
  const Deployment d = hall_for(Filter::kMotion);
  const EpochFixModel model = epoch_fix_model(d);
  const Pose T = pose_and_step<kDof>().first;
  Random random(3, 1);
  std::vector<Arrival> arrivals;
  for (std::size_t beacon = 0; beacon < d.beacons.size(); ++beacon)
    arrivals.push_back(heard(d, T, beacon, beacon % d.receivers.size(), 1e-5 * random.normal()));
  const Trajectory t = trajectory_of(d, arrivals);
  typename Filter::Covariance P = 1e-4 * Filter::Covariance::Identity();
  Filter filter(model, 6.0, 0.0);
  filter.start(T, P);
  for (const ArrivalObservation& a : t.arrivals) ASSERT_EQ(filter.update(t, a), Rejection::kUsed);

  // All at once, by numeric derivatives of the distances at the start. The filter computes its own within
  // some millimetres of it, which changes a direction over four metres by a thousandth.
  typename Filter::Covariance information = P.inverse();
  typename Filter::Vector gradient = Filter::Vector::Zero();
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    const auto tof = [&](const Pose& at) {
      return heard(d, at, arrivals[i].beacon.index(), arrivals[i].receiver.index(), 0.0).tof_s;
    };
    typename Filter::Vector h;
    for (int k = 0; k < kDof; ++k) {
      const Eigen::VectorXd by = 1e-5 * Filter::Vector::Unit(k);
      h[k] = (tof(retract(T, by, d.motion)) - tof(retract(T, -by, d.motion))) / 2e-5;
    }
    const double weight = 1.0 / (t.arrivals[i].sigma_s * t.arrivals[i].sigma_s);
    information += weight * h * h.transpose();
    gradient += weight * (arrivals[i].tof_s - tof(T)) * h;
  }
  const typename Filter::Covariance posterior = information.inverse();
  const typename Filter::Vector moved = posterior * gradient;
  EXPECT_LT((difference<kDof>(T, filter.pose()) - moved).norm(), 0.01 * moved.norm());
  EXPECT_LT((filter.covariance() - posterior).norm(), 0.01 * posterior.norm());
}

TEST(DriveFilterOf, CorrectsAsLeastSquaresDoes) {
  expect_update_as_least_squares<3>();
  expect_update_as_least_squares<6>();
}

template <int kDof>
void expect_gate() {
  using Filter = DriveFilterOf<kDof>;
  const Deployment d = hall_for(Filter::kMotion);
  const EpochFixModel model = epoch_fix_model(d);
  const Pose T = pose_and_step<kDof>().first;
  const Trajectory t = trajectory_of(d, {heard(d, T, 0, 0, 1e-3), heard(d, T, 0, 0, -1e-3)});
  Filter filter(model, 4.0, 0.0);
  filter.start(T, 1e-6 * Filter::Covariance::Identity());
  EXPECT_FALSE(filter.fits(t, t.arrivals[0]));
  EXPECT_EQ(filter.update(t, t.arrivals[0]), Rejection::kLate);
  EXPECT_EQ(filter.update(t, t.arrivals[1]), Rejection::kEarly);
  EXPECT_EQ(filter.pose().translation_m, T.translation_m) << "what is left out moves nothing";
  for (int i = 0; i < 40; ++i) static_cast<void>(filter.update(t, t.arrivals[0]));
  EXPECT_TRUE(filter.is_lost()) << "where nothing fits any more";
}

TEST(DriveFilterOf, LeavesOutWhatIsBeyondTheGateAndIsLostByMuchOfIt) {
  expect_gate<3>();
  expect_gate<6>();
}

}  // namespace drive_tracker_test
}  // namespace octant
