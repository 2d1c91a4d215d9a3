// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/reject.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "calib/problem/gates.h"
#include "models/simulator/random.h"
#include "tests/calib/at_truth.h"
#include "tests/support/statistics.h"

namespace octant::test {
namespace reject_test {

/// Magnitudes of a normal variable at evenly spread probabilities: a sample without chance.
std::vector<double> normal_magnitudes(std::size_t count, double sigma) {
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) {
    const double p = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    out.push_back(sigma * std::sqrt(chi2_quantile(p, 1.0)));
  }
  return out;
}

TEST(AgreeingSigma, OfNormalErrorsIsTheirOwn) {
  // It ends where a round changes it by less than a thousandth, a factor of some two before its limit.
  for (const double sigma : {1e-3, 1.0, 700.0})
    EXPECT_NEAR(calib::agreeing_sigma(normal_magnitudes(801, sigma)), sigma, 3e-3 * sigma);
}

TEST(AgreeingSigma, IsNotWidenedByEchoesHoweverFar) {
  std::vector<double> magnitudes = normal_magnitudes(1200, 1.0);
  for (int i = 0; i < 800; ++i) magnitudes.push_back(30.0 + i);
  const double near = calib::agreeing_sigma(magnitudes);
  for (std::size_t i = 1200; i < magnitudes.size(); ++i) magnitudes[i] *= 1e6;
  EXPECT_EQ(calib::agreeing_sigma(magnitudes), near);
  EXPECT_NEAR(near, 1.0, 3e-3);
}

TEST(AgreeingSigma, OfTooFewIsOne) {
  EXPECT_EQ(calib::agreeing_sigma(std::vector<double>()), 1.0);
  EXPECT_EQ(calib::agreeing_sigma(std::vector<double>(29, 5.0)), 1.0);
  EXPECT_NE(calib::agreeing_sigma(normal_magnitudes(30, 5.0)), 1.0);
}

TEST(AgreeingSigma, OfErrorsThatAreNoneIsANumber) {
  const double sigma = calib::agreeing_sigma(std::vector<double>(100, 0.0));
  EXPECT_TRUE(std::isfinite(sigma));
  EXPECT_GT(sigma, 0.0);
}

RC_GTEST_PROP(AgreeingSigma, GoesWithTheUnitAndNotWithTheOrder, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  std::vector<double> magnitudes;
  for (int i = 0; i < 200; ++i) magnitudes.push_back(std::abs(draws.normal()) * (i % 5 == 0 ? 20.0 : 1.0));
  const double sigma = calib::agreeing_sigma(magnitudes);
  std::reverse(magnitudes.begin(), magnitudes.end());
  RC_ASSERT(calib::agreeing_sigma(magnitudes) == sigma);
  for (double& m : magnitudes) m *= 1024.0;  // exact
  RC_ASSERT(std::abs(calib::agreeing_sigma(magnitudes) - 1024.0 * sigma) < 1e-9 * sigma);
}

Scenario quiet_hall(int epochs) {
  Scenario s = without_noise(hall_scenario());
  s.path.epochs = epochs;
  // Weights as with noise: sigmas are those of the site.
  return s;
}

/// A hall without noise, with a given error for each arrival.
struct Arrivals : AtTruth {
  explicit Arrivals(int epochs = 20) : AtTruth(quiet_hall(epochs), 1) {
    for (ArrivalObservation& a : all()) a.sigma_s = 1e-5;
  }
  std::vector<ArrivalObservation>& all() { return trajectories[0].arrivals; }
  void put_off(std::size_t i, double sigmas) { all()[i].tof_s += sigmas * all()[i].sigma_s; }
};

// If two or three arrivals determine a position they agree, whatever the noise. The noise estimated from them
// was a hundredth of the true one, half of a log was rejected, and a control point was contradicted by 26
// sigmas.
TEST(AgreeingSigma, OfStopsThatHearHardlyMoreThanTheirPlaceIsNoLessThanStated) {
  Arrivals arrivals;
  const auto sigma = [&] { return calib::agreeing_sigma(arrivals.trajectories, arrivals.state); };
  for (std::size_t i = 0; i < arrivals.all().size(); ++i) arrivals.put_off(i, i % 2 == 0 ? 0.1 : -0.1);
  EXPECT_LT(sigma(), 0.2);
  std::map<std::uint32_t, int> heard;
  for (ArrivalObservation& a : arrivals.all())
    if (++heard[a.node] > 5) a.rejection = Rejection::kBeaconUnusable;
  EXPECT_EQ(sigma(), 1.0);
  for (std::size_t i = 0; i < arrivals.all().size(); ++i) arrivals.put_off(i, i % 2 == 0 ? 5.0 : -5.0);
  EXPECT_NEAR(sigma(), 5.1, 0.5) << "more than stated it may be";
}

TEST(MarkRejected, TellsLateFromEarlyBeyondTheLimit) {
  Arrivals arrivals;
  const std::vector<std::pair<double, Rejection>> cases = {
      {3.9, Rejection::kUsed},   {-3.9, Rejection::kUsed}, {4.1, Rejection::kLate},
      {-4.1, Rejection::kEarly}, {1e4, Rejection::kLate},  {-100, Rejection::kEarly}};
  for (std::size_t i = 0; i < cases.size(); ++i) arrivals.put_off(i, cases[i].first);
  EXPECT_EQ(calib::reject_outliers(arrivals.trajectories, arrivals.state, 4.0), 4U);
  for (std::size_t i = 0; i < arrivals.all().size(); ++i)
    EXPECT_EQ(arrivals.all()[i].rejection, i < cases.size() ? cases[i].second : Rejection::kUsed) << i;
  EXPECT_EQ(calib::reject_outliers(arrivals.trajectories, arrivals.state, 4.0), 0U) << "all stands as it was";
}

// Between 0.9 of the limit and the limit each mark is kept, so that marks do not alternate.
TEST(MarkRejected, ReadmitsOnlyWhatIsWellWithin) {
  Arrivals arrivals;
  arrivals.put_off(0, 3.7);
  arrivals.put_off(1, 3.7);
  arrivals.put_off(2, 3.5);
  arrivals.all()[1].rejection = Rejection::kLate;
  arrivals.all()[2].rejection = Rejection::kLate;
  EXPECT_EQ(calib::reject_outliers(arrivals.trajectories, arrivals.state, 4.0), 1U);
  EXPECT_EQ(arrivals.all()[0].rejection, Rejection::kUsed);
  EXPECT_EQ(arrivals.all()[1].rejection, Rejection::kLate);
  EXPECT_EQ(arrivals.all()[2].rejection, Rejection::kUsed);
}

TEST(MarkRejected, LeavesWhatHasNoPlaceAndBelievesGatesOnlyWhereTheResidualAgrees) {
  Arrivals arrivals;
  arrivals.all()[0].rejection = Rejection::kBeaconUnusable;
  arrivals.all()[1].rejection = Rejection::kNoPose;
  for (std::size_t i = 2; i < 8; ++i)
    arrivals.all()[i].rejection = i % 3 == 2   ? Rejection::kTriangle
                                  : i % 3 == 0 ? Rejection::kOutOfRange
                                               : Rejection::kReflection;
  for (const std::size_t i : {5U, 6U, 7U}) arrivals.put_off(i, 50.0);
  EXPECT_EQ(calib::reject_outliers(arrivals.trajectories, arrivals.state, 4.0), 3U);
  EXPECT_EQ(arrivals.all()[0].rejection, Rejection::kBeaconUnusable);
  EXPECT_EQ(arrivals.all()[1].rejection, Rejection::kNoPose);
  for (const std::size_t i : {2U, 3U, 4U}) EXPECT_EQ(arrivals.all()[i].rejection, Rejection::kUsed) << i;
  EXPECT_EQ(arrivals.all()[5].rejection, Rejection::kTriangle) << "the gate's reason stays";
  EXPECT_EQ(arrivals.all()[6].rejection, Rejection::kOutOfRange);
  EXPECT_EQ(arrivals.all()[7].rejection, Rejection::kReflection);
}

TEST(MarkRejected, DoesNotDependOnThreads) {
  Scenario s = hall_scenario();
  s.path.epochs = 60;
  s.echo_fraction = 0.2;
  AtTruth one(s, 3), three(s, 3);
  const std::size_t changed = calib::reject_outliers(one.trajectories, one.state, 4.0, 1);
  EXPECT_EQ(calib::reject_outliers(three.trajectories, three.state, 4.0, 3), changed);
  EXPECT_GT(changed, 20U);
  for (std::size_t i = 0; i < one.trajectories[0].arrivals.size(); ++i) {
    const Rejection mark = one.trajectories[0].arrivals[i].rejection;
    EXPECT_EQ(three.trajectories[0].arrivals[i].rejection, mark);
    // Echoes of 0.3 ms and more are thirty sigmas late, with or without a mark by a gate.
    const double lateness_s = one.world.run_lateness_s[one.trajectories[0].arrivals[i].arrival];
    if (lateness_s > 0) EXPECT_NE(mark, Rejection::kUsed) << i;
  }
}

TEST(RescaleNoise, ExchangesTheTimesShareOfTheVariance) {
  Arrivals arrivals;
  arrivals.all()[1].sigma_s = std::hypot(1e-5, 3e-5);  // 30 us of it are the walk's
  calib::rescale_noise(arrivals.trajectories, 1e-5, 4e-5);
  EXPECT_DOUBLE_EQ(arrivals.all()[0].sigma_s, 4e-5);
  EXPECT_NEAR(arrivals.all()[1].sigma_s, 5e-5, 1e-18);  // 3, 4, 5
  calib::rescale_noise(arrivals.trajectories, 4e-5, 1e-5);
  EXPECT_NEAR(arrivals.all()[1].sigma_s, std::hypot(1e-5, 3e-5), 1e-18);
}

TEST(ReadmitAll, LeavesOutWhatCannotBeUsedAndWhatAGateMarked) {
  Arrivals arrivals;
  std::vector<bool> usable(8, true);
  usable[2] = false;
  Trajectory& t = arrivals.trajectories[0];
  t.nodes[5].placed = false;
  for (std::size_t i = 0; i < t.arrivals.size(); ++i)
    t.arrivals[i].rejection = i % 4 == 0   ? Rejection::kLate
                              : i % 4 == 1 ? Rejection::kTriangle
                              : i % 4 == 2 ? Rejection::kNoPose
                                           : Rejection::kUsed;
  calib::readmit_all(arrivals.trajectories, usable);
  std::size_t of_each[4] = {};
  for (std::size_t i = 0; i < t.arrivals.size(); ++i) {
    const ArrivalObservation& a = t.arrivals[i];
    const Rejection want = a.beacon == BeaconId(2) ? Rejection::kBeaconUnusable
                           : a.node == 5           ? Rejection::kNoPose
                           : i % 4 == 1            ? Rejection::kTriangle
                                                   : Rejection::kUsed;
    EXPECT_EQ(a.rejection, want) << i;
    ++of_each[want == Rejection::kBeaconUnusable ? 0
              : want == Rejection::kNoPose       ? 1
              : want == Rejection::kTriangle     ? 2
                                                 : 3];
  }
  for (const std::size_t count : of_each) EXPECT_GT(count, 0U) << "the world has each case";
}

}  // namespace reject_test
}  // namespace octant::test
