// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Knowledge of an earlier deployment as the site and the prior of a second visit.
#include "calib/revisit/revisited_site.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "models/changes/change_sigmas.h"
#include "models/simulator/random.h"
#include "tests/calib/revisit/calibrated_hall.h"

namespace octant::test {
namespace revisited_site_test {

calib::ParameterLayout layout_of(const Site& site) {
  calib::Problem problem;
  problem.site = site;
  problem.runs.resize(1);
  return calib::make_layout(problem, prior_state(site));
}

TEST(RevisitedSite, BeginsWhereTheDeploymentEnded) {
  for (const bool attenuation : {false, true}) {
    const Deployment d = calibrated_hall(attenuation);
    const KnownParameters known = known_parameters(d);
    const Site site =
        calib::revisited_site(d, known, calib::room_for_change(known) + known.covariance.diagonal());
    const SharedState was = shared_state(d), is = prior_state(site);
    for (std::size_t b = 0; b < d.beacons.size(); ++b) {
      EXPECT_EQ(is.beacon_p_map_m[b], was.beacon_p_map_m[b]);
      EXPECT_EQ(is.beacon_delay_s[b], was.beacon_delay_s[b]);
      if (attenuation) EXPECT_NEAR(is.beacon_log_gain[b], std::log(0.9), 1e-15);
    }
    for (std::size_t r = 0; r < d.receivers.size(); ++r)
      EXPECT_EQ(is.receiver_p_vehicle_m[r], was.receiver_p_vehicle_m[r]);
    ASSERT_EQ(is.attenuation.has_value(), attenuation);
    if (attenuation) {
      EXPECT_EQ(is.attenuation->amplitude_1m_v, was.attenuation->amplitude_1m_v);
      EXPECT_EQ(is.attenuation->absorption_np_per_m, was.attenuation->absorption_np_per_m);
      EXPECT_EQ(is.attenuation->rise_time_s, was.attenuation->rise_time_s);
      EXPECT_EQ(is.attenuation->threshold_v, was.attenuation->threshold_v);
    }
    // Offsets of the speed start at zero, with their earlier value as sigma.
    EXPECT_EQ(is.speed_offset_mps[0], 0.0);
    EXPECT_GE(site.speed_sigma_mps, std::abs(d.speed_offset_mps));
  }
}

TEST(RevisitedSite, EverythingMayChangeControlPointsToo) {
  const Deployment d = calibrated_hall();
  const KnownParameters known = known_parameters(d);
  const Eigen::VectorXd variance = calib::room_for_change(known) + known.covariance.diagonal();
  const calib::ParameterLayout layout = layout_of(calib::revisited_site(d, known, variance));
  const std::vector<int> columns = calib::columns_of(layout, known);
  for (Eigen::Index k = 0; k < known.size(); ++k) {
    const ParameterId& id = known.parameters[static_cast<std::size_t>(k)];
    if (id.kind == ParameterKind::kReceiverDelay || id.kind == ParameterKind::kSpeed)
      continue;  // room by maxima
    const int c = columns[static_cast<std::size_t>(k)];
    ASSERT_GE(c, 0) << k;
    const calib::Parameter& p = layout.parameters[static_cast<std::size_t>(c)];
    EXPECT_NEAR(p.prior_sigma * p.si_per_unit, std::sqrt(variance[k]), 1e-12 * std::sqrt(variance[k]));
    EXPECT_NEAR(p.prior_mean * p.si_per_unit, known.value[k],
                1e-14 * std::max(1.0, std::abs(known.value[k])));
  }
}

TEST(RevisitedSite, CountsAllNoiseOfASingleArrivalOnce) {
  const Deployment d = calibrated_hall();
  const KnownParameters known = known_parameters(d);
  const Site site = calib::revisited_site(d, known, known.covariance.diagonal());
  EXPECT_DOUBLE_EQ(site.noise.tof_sigma_s, std::hypot(1e-5, 4e-6, 3e-6));
  EXPECT_FALSE(site.noise.pair_sigma_s.has_value());
  EXPECT_FALSE(site.timing.delay_per.site) << "it stands on the beacons";
}

TEST(RevisitedSite, OfABeaconThatWasNotDeterminedKnowsNothing) {
  Deployment d = calibrated_hall();
  d.beacons[4].status = BeaconStatus::kUndetermined;
  const KnownParameters known = known_parameters(d);
  const Site site =
      calib::revisited_site(d, known, calib::room_for_change(known) + known.covariance.diagonal());
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_FALSE(site.beacons[4].position_m[i] || site.beacons[4].sigma_m[i]);
  EXPECT_EQ(site.beacons.size(), d.beacons.size()) << "names stay where they were";
}

TEST(RoomForChange, IsAVarianceOfWhatIsLookedFor) {
  const KnownParameters known = known_parameters(calibrated_hall(true));
  const ChangeSigmas room = usual_changes(known.speed_mps);
  const Eigen::VectorXd variance = calib::room_for_change(known);
  const auto at = [&](const ParameterId& id) { return variance[known.index_of(id)]; };
  EXPECT_DOUBLE_EQ(at(parameters::beacon_position(0, 1)), room.beacon_m * room.beacon_m);
  EXPECT_DOUBLE_EQ(at(parameters::beacon_delay(3)), room.delay_s * room.delay_s);
  EXPECT_DOUBLE_EQ(at(parameters::receiver_position(2, 2)), room.receiver_m * room.receiver_m);
  EXPECT_DOUBLE_EQ(at(parameters::speed()), room.speed_mps * room.speed_mps);
  EXPECT_DOUBLE_EQ(at(parameters::beacon_gain(1)), room.log_gain * room.log_gain);
  EXPECT_EQ(at(parameters::receiver_delay(1)), 0.0);
  EXPECT_EQ(at(parameters::attenuation(0)), 0.0);
}

// In SI units: half the squares of the prior at a step are half the Mahalanobis distance of that step.
TEST(SetJointPrior, IsTheCovarianceInTheLayoutsUnits) {
  const Deployment d = calibrated_hall();
  const KnownParameters known = known_parameters(d);
  Eigen::MatrixXd P = known.covariance;
  P.diagonal() += calib::room_for_change(known) + drift_variances(known, Drift());
  calib::ParameterLayout layout = layout_of(calib::revisited_site(d, known, P.diagonal()));
  const std::vector<int> columns = calib::columns_of(layout, known);
  calib::set_joint_prior(layout, known, P);
  ASSERT_TRUE(layout.joint_prior.has_value());
  Random draws(6);
  std::vector<int> told;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(known.size());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(layout.size());
  for (Eigen::Index k = 0; k < known.size(); ++k) {
    const int c = columns[static_cast<std::size_t>(k)];
    if (c < 0) continue;
    told.push_back(static_cast<int>(k));
    step[k] = std::sqrt(P(k, k)) * draws.normal();
    const calib::Parameter& p = layout.parameters[static_cast<std::size_t>(c)];
    x[c] = (known.value[k] + step[k]) / p.si_per_unit;
    EXPECT_TRUE(std::isinf(p.prior_sigma)) << "not believed twice";
  }
  const Eigen::VectorXd unit = P.diagonal().cwiseSqrt();
  const Eigen::MatrixXd R =
      (unit.cwiseInverse().asDiagonal() * P * unit.cwiseInverse().asDiagonal())(told, told);
  const Eigen::VectorXd s = step.cwiseQuotient(unit)(told);
  const double want = s.dot(R.fullPivLu().solve(s));
  EXPECT_NEAR(layout.joint_prior->residual(x).squaredNorm(), want, 1e-8 * want);  // some 1e4 of condition
}

}  // namespace revisited_site_test
}  // namespace octant::test
