// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Weights of correlated arrivals against sums over all pairs of them.
#include "models/localizers/common/correlated_arrivals.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "models/simulator/random.h"

namespace octant::test {
namespace correlated_arrivals_test {

/// Arrivals of three pairs at uneven times, some left out, behind some of another segment.
Trajectory any_arrivals(Random& draws) {
  Trajectory t;
  for (int i = 0; i < 40; ++i) {
    ArrivalObservation a;
    a.beacon = BeaconId(i % 3 == 0 ? 0 : 1);
    a.receiver = ReceiverId(i % 3 == 2 ? 1 : 0);
    a.time_s = 0.1 * i + 0.05 * draws.uniform();
    if (i % 7 == 6) a.time_s = t.arrivals.back().time_s;  // at one instant
    a.sigma_s = 3e-5 * draws.uniform(1.0, 2.0);
    if (i % 5 == 4) a.rejection = Rejection::kLate;
    t.arrivals.push_back(a);
  }
  return t;
}

Segment from_third() {
  Segment s;
  s.first_arrival = 3;
  s.last_arrival = 40;
  return s;
}

/// sum over the pair's others in use of exp(-|dt| / time_s), and their number; one by one.
struct Others {
  double rho = 0.0;
  int count = 0;
};
Others others_of(const Trajectory& t, std::size_t i, double time_s) {
  Others out;
  for (std::size_t j = 3; j < 40; ++j) {
    const ArrivalObservation &a = t.arrivals[i], &b = t.arrivals[j];
    if (i == j || a.beacon != b.beacon || a.receiver != b.receiver || b.rejection != Rejection::kUsed)
      continue;
    const double dt = std::abs(a.time_s - b.time_s);
    out.rho += time_s > 0 ? std::exp(-dt / time_s) : dt == 0.0 ? 1.0 : 0.0;
    ++out.count;
  }
  return out;
}

RC_GTEST_PROP(CorrelatedArrivals, AlongADriveWeighEachByItsOthers, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  Trajectory t = any_arrivals(draws);
  const Trajectory before = t;
  const CorrelatedNoise noise{
      .sigma_s = 2e-5, .time_s = *rc::gen::element(0.0, 0.3, 5.0), .pair_sigma_s = 1e-5};
  CorrelatedArrivals sigmas(t, from_third(), noise, CorrelatedArrivals::Side::kChanging);
  sigmas.weigh();
  sigmas.weigh();  // from the single ones each time
  for (std::size_t i = 0; i < 40; ++i) {
    const ArrivalObservation& a = before.arrivals[i];
    double want2 = a.sigma_s * a.sigma_s;
    if (i >= 3 && a.rejection == Rejection::kUsed) want2 += 4e-10 * others_of(before, i, noise.time_s).rho;
    RC_ASSERT(std::abs(t.arrivals[i].sigma_s - std::sqrt(want2)) < 1e-12 * std::sqrt(want2));
  }
  sigmas.restore();
  for (std::size_t i = 0; i < 40; ++i) RC_ASSERT(t.arrivals[i].sigma_s == before.arrivals[i].sigma_s);
}

// At one place the variance of a pair's mean counts: each gets the mean of the shared information.
RC_GTEST_PROP(CorrelatedArrivals, AtOnePlaceShareWhatTheirMeanIsWorth, ()) {
  Random draws(static_cast<std::uint64_t>(*rc::gen::arbitrary<std::uint32_t>()));
  Trajectory t = any_arrivals(draws);
  for (ArrivalObservation& a : t.arrivals) a.sigma_s = 3e-5;
  const Trajectory before = t;
  const CorrelatedNoise noise{.sigma_s = 2e-5, .time_s = 0.7, .pair_sigma_s = 1e-5};
  CorrelatedArrivals(t, from_third(), noise, CorrelatedArrivals::Side::kSame).weigh();
  for (int pair = 0; pair < 3; ++pair) {
    double information = 0.0, covariance = 0.0;  // of the sum of the pair's errors, whole
    int n = 0;
    for (std::size_t i = 3; i < 40; ++i) {
      const ArrivalObservation& a = t.arrivals[i];
      if (static_cast<int>(i % 3) != pair || a.rejection != Rejection::kUsed) continue;
      information += 1 / (a.sigma_s * a.sigma_s);
      const Others others = others_of(before, i, noise.time_s);
      covariance += 9e-10 + 4e-10 * others.rho + 1e-10 * others.count;
      ++n;
    }
    RC_ASSERT(std::abs(1 / information - covariance / (n * n)) < 1e-9 * covariance);
  }
}

TEST(CorrelatedArrivals, WithoutSuchNoiseStayAsTheyAre) {
  Random draws(1);
  Trajectory t = any_arrivals(draws);
  const Trajectory before = t;
  CorrelatedArrivals sigmas(t, from_third(), CorrelatedNoise{}, CorrelatedArrivals::Side::kSame);
  sigmas.weigh();
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(t.arrivals[i].sigma_s, before.arrivals[i].sigma_s);
}

/// A node at the origin, and arrivals from a beacon at 10 m that deviate by these numbers of sigmas.
Trajectory deviating_by(const std::vector<double>& sigmas, const SharedState& state) {
  Trajectory t;
  t.nodes.emplace_back();
  for (const double s : sigmas) {
    ArrivalObservation& a = t.arrivals.emplace_back();
    a.beacon = BeaconId(0);
    a.receiver = ReceiverId(0);
    a.sigma_s = 1e-5;
    a.model_speed_mps = 340.0;
    a.tof_s = state.beacon_p_map_m[0].norm() / 340.0 + s * a.sigma_s;
  }
  return t;
}

TEST(CorrelatedArrivals, BeyondTwoSigmasGetHalfTheirResidualAsSigma) {
  SharedState state;
  state.beacon_p_map_m = {{10, 0, 0}};
  state.receiver_p_vehicle_m = {{0, 0, 0}};
  state.beacon_delay_s = {0.0};
  state.receiver_delay_s = {0.0};
  Trajectory t = deviating_by({0.5, -1.9, 3.0, -6.0, 9.0}, state);
  t.arrivals[4].rejection = Rejection::kLate;
  Segment all;
  all.last_arrival = t.arrivals.size();
  // The correlation is negligible, so that the sigmas of the tails alone remain.
  CorrelatedArrivals sigmas(t, all, {.sigma_s = 1e-12, .time_s = 1.0}, CorrelatedArrivals::Side::kSame);
  EXPECT_TRUE(sigmas.widen_tails(state));
  sigmas.weigh();
  const double want[] = {1e-5, 1e-5, 1.5e-5, 3e-5, 1e-5};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(t.arrivals[i].sigma_s, want[i], 1e-11) << i;
  sigmas.restore();
  EXPECT_FALSE(sigmas.widen_tails(state)) << "the residuals are the same";
  sigmas.narrow_tails();
  sigmas.weigh();
  EXPECT_NEAR(t.arrivals[3].sigma_s, 1e-5, 1e-11);
  CorrelatedArrivals white(t, all, CorrelatedNoise{}, CorrelatedArrivals::Side::kSame);
  EXPECT_FALSE(white.widen_tails(state));
}

TEST(CorrelatedNoise, TakesTheLargerBiasOfPairsAndAddsAllForOneArrival) {
  Deployment d;
  d.noise.tof_sigma_s = 1e-5;
  EXPECT_FALSE(correlated_noise(d).any());
  EXPECT_EQ(single_arrival_sigma_s(d), 1e-5);
  d.correlated_noise = {.sigma_s = 2e-5, .time_s = 3.0, .pair_sigma_s = 1e-6};
  d.noise.pair_sigma_s = 2e-5;  // as the site states it
  EXPECT_EQ(correlated_noise(d).pair_sigma_s, 2e-5);
  EXPECT_EQ(correlated_noise(d).time_s, 3.0);
  EXPECT_NEAR(single_arrival_sigma_s(d), 3e-5, 1e-18);  // 1, 2, 2
  d.noise.pair_sigma_s = 1e-9;
  EXPECT_EQ(correlated_noise(d).pair_sigma_s, 1e-6);
}

}  // namespace correlated_arrivals_test
}  // namespace octant::test
