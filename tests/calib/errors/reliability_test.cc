// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Leverages, w, detectable biases, ellipses and variance components: against a dense hat matrix and against
// simulated worlds.
#include "calib/errors/reliability.h"

#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "calib/errors/residual_groups.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/dense_adjustment.h"
#include "tests/support/statistics.h"

namespace octant::test {
namespace reliability_test {

using calib::ArrivalReliability;
using calib::Reliability;

/// Arrivals are never rejected, so that the errors of the tests remain.
calib::SolveOptions keep_all() { return {.rejection_sigmas = 1e3}; }

Scenario short_hall() {
  Scenario s = hall_scenario();
  s.path.epochs = 40;
  return s;
}

/// Beacons known to 5 cm: these tests concern the statistics at the optimum, not the iteration.
Scenario near_hall() {
  Scenario s = short_hall();
  for (SiteBeacon& b : s.site.beacons)
    for (auto& sigma : b.sigma_m)
      if (*sigma > 0) sigma = 0.05;
  return s;
}

/// Every redundancy number, detectable bias and influence against the dense projector of numeric derivatives.
void expect_as_dense(const Scenario& scenario, std::uint64_t seed, bool full_rank = true) {
  const calib::Problem problem = problem_of(must(simulate(scenario, seed)));
  const calib::Solution solution = calib::solve(problem);
  const Reliability& r = solution.reliability;
  ASSERT_TRUE(r.ok) << solution.message;
  const DenseAdjustment dense(problem, solution);
  EXPECT_NEAR(r.redundancy_sum, static_cast<double>(dense.rows.size()) - static_cast<double>(dense.rank()),
              1e-4);
  if (full_rank) EXPECT_NEAR(r.redundancy_sum, solution.statistics.redundancy, 1e-6);
  std::map<std::size_t, const ArrivalReliability*> by_arrival;
  for (const ArrivalReliability& a : r.arrivals) by_arrival[a.arrival] = &a;
  std::array<double, 6> of_kind = {};
  std::vector<Eigen::VectorXd> lateness(problem.site.beacons.size(),
                                        Eigen::VectorXd::Zero(dense.residual.size()));
  // Central differences: relative 1e-7 of curvature and rounding in the derivatives; the projector's
  // condition takes the rest.
  for (std::size_t i = 0; i < dense.rows.size(); ++i) {
    const DenseAdjustment::Row& row = dense.rows[i];
    const double redundancy = 1 - dense.leverage(i);
    of_kind[static_cast<std::size_t>(row.kind)] += redundancy;
    if (row.kind != DenseAdjustment::Row::kTof) continue;
    const auto at = static_cast<Eigen::Index>(i);
    lateness[row.beacon.index()][at] = 1 / dense.sigma_s(row);
    const ArrivalReliability& a = *by_arrival.at(dense.arrival(row));
    ASSERT_NEAR(a.redundancy, redundancy, 1e-5);
    if (redundancy < 1e-3) continue;
    ASSERT_NEAR(a.w, dense.residual[at] / std::sqrt(redundancy), 1e-4);
    ASSERT_NEAR(a.mdb_s, calib::kDelta0 * dense.sigma_s(row) / std::sqrt(redundancy), 1e-4 * a.mdb_s);
    if (!full_rank || i % 7 != 0) continue;  // some of them: a dense solution each
    const Eigen::VectorXd bias =
        (a.mdb_s / dense.sigma_s(row)) * Eigen::VectorXd::Unit(dense.residual.size(), at);
    ASSERT_NEAR(a.influence_m, dense.beacon_shift_m(bias), 1e-3 * a.influence_m + 1e-9);
  }
  for (const calib::VarianceComponent& kind : r.kinds) {
    const std::map<std::string, std::size_t> place = {{"tof", 0},  {"amplitude", 1}, {"bearing", 2},
                                                      {"pose", 3}, {"odometry", 4},  {"prior", 5}};
    EXPECT_NEAR(kind.redundancy, of_kind[place.at(kind.name)], 1e-3) << kind.name;
  }
  for (std::size_t b = 0; b < lateness.size(); ++b) {
    if (!r.beacons[b].lateness_mdb_s) continue;
    const double information = lateness[b].dot(dense.residuals_of(lateness[b])),
                 mdb_s = *r.beacons[b].lateness_mdb_s;
    EXPECT_NEAR(mdb_s, calib::kDelta0 / std::sqrt(information), 1e-4 * mdb_s) << r.beacons[b].name;
    if (full_rank)
      EXPECT_NEAR(*r.beacons[b].lateness_influence_m, dense.beacon_shift_m(mdb_s * lateness[b]),
                  1e-3 * *r.beacons[b].lateness_influence_m + 1e-9);
  }
}

TEST(Reliability, StationaryEpochsAsDense) { expect_as_dense(short_hall(), 1); }

TEST(Reliability, AmplitudesAsDense) {
  Scenario s = short_hall();
  add_attenuation(s);
  s.log_amplitude = true;
  expect_as_dense(s, 2);
}

TEST(Reliability, CycleOffsetsAsDense) {
  Scenario s = short_hall();
  s.site.timing.clock = Clock::kCycleOffset;
  s.site.timing.delay_per = {};
  s.site.timing.delay_s = s.site.timing.delay_sigma_s = 0.0;
  s.true_delay_s.reset();
  expect_as_dense(s, 3);
}

TEST(Reliability, MeasuredPosesAsDense) {
  Scenario s = short_hall();
  s.log_poses = true;
  expect_as_dense(s, 4);
}

/// 320 states in one chain: longer than a block of the sweep.
TEST(Reliability, DriveWithOdometryAsDense) { expect_as_dense(drive_scenario(16.0), 5); }

/// A lone antenna in the middle of the vehicle: no heading, and no unknown either.
TEST(Reliability, UnobservedHeadingCountsAsNoUnknown) {
  Scenario s = short_hall();
  s.site.vehicles.clear();
  s.site.receivers.clear();
  add_receivers(s.site, {{0.0, 0.0, 0.3}});
  s.range_m = 30.0;
  expect_as_dense(s, 6, false);
}

TEST(Reliability, WithoutSharedParameters) {
  Scenario s = short_hall();
  for (SiteBeacon& b : s.site.beacons) b.sigma_m = {0.0, 0.0, 0.0};
  for (SiteReceiver& r : s.site.receivers) r.sigma_m.setZero();
  s.site.speed_sigma_mps = 0.0;
  s.true_temperature_offset_degC = 0.0;
  s.site.timing.delay_per = {};
  s.site.timing.delay_s = s.site.timing.delay_sigma_s = 0.0;
  s.true_delay_s.reset();
  const calib::Solution solution = solution_of(must(simulate(s, 7)));
  ASSERT_TRUE(solution.reliability.ok);
  EXPECT_NEAR(solution.reliability.redundancy_sum, solution.statistics.redundancy, 1e-6);
}

/// Largest distance of the distribution of standard normal variables, as they should be, from the normal one.
double kolmogorov_distance(std::vector<double> sample) {
  std::sort(sample.begin(), sample.end());
  const auto n = static_cast<double>(sample.size());
  double distance = 0.0;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double p = normal_cdf(sample[i]), k = static_cast<double>(i);
    distance = std::max({distance, p - k / n, (k + 1) / n - p});
  }
  return distance;
}

TEST(Reliability, WIsStandardNormal) {
  std::vector<double> w, plain;
  for (std::uint64_t seed = 1; seed <= 90; ++seed) {
    const World world = must(simulate(near_hall(), 100 + seed));
    const calib::Solution solution = solution_of(world, keep_all());
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged);
    // The least controlled arrival of each epoch, where w differs most from the plain residual; one, to be
    // independent.
    std::map<std::int64_t, const ArrivalReliability*> least;
    for (const ArrivalReliability& a : solution.reliability.arrivals) {
      const ArrivalReliability*& kept = least[world.run.arrivals[a.arrival].epoch];
      if (a.redundancy > 0.05 && (kept == nullptr || a.redundancy < kept->redundancy)) kept = &a;
    }
    for (const auto& [epoch, a] : least) {
      if (a == nullptr) continue;
      w.push_back(a->w);
      plain.push_back(a->residual_s / solution.tof_sigma_s);
    }
  }
  const double bound = kolmogorov_bound(static_cast<double>(w.size()), 1e-4);
  RecordProperty("distance", std::to_string(kolmogorov_distance(w)));
  RecordProperty("bound", std::to_string(bound));
  EXPECT_LT(kolmogorov_distance(w), bound);
  EXPECT_GT(kolmogorov_distance(plain), bound);  // there are enough to tell the two apart
}

/// P(X <= k) of a binomial distribution.
double binomial_cdf(int k, int n, double p) {
  double sum = 0.0;
  for (int i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p) +
                    (n - i) * std::log1p(-p));
  return sum;
}
/// Fewer or more successes than this happen once in ten thousand times each.
void expect_share(int successes, int n, double p) {
  EXPECT_GT(binomial_cdf(successes, n, p), 1e-4) << successes << " of " << n << ", expected " << p;
  EXPECT_GT(1 - binomial_cdf(successes - 1, n, p), 1e-4) << successes << " of " << n << ", expected " << p;
}

/// A lateness of one arrival, `share` times its minimal detectable bias, is found in `power` of the worlds.
void expect_found(double share, int worlds, double power) {
  int found = 0;
  for (int k = 0; k < worlds; ++k) {
    const auto seed = static_cast<std::uint64_t>(1000 + k);
    World world = must(simulate(near_hall(), seed));
    const calib::Solution before = solution_of(world, keep_all());
    const std::vector<ArrivalReliability>& all = before.reliability.arrivals;
    const ArrivalReliability& chosen = all[std::mt19937(static_cast<unsigned>(seed))() % all.size()];
    world.run.arrivals[chosen.arrival].tof_s +=
        share * chosen.mdb_s * world.site.noise.tof_sigma_s / before.tof_sigma_s;
    const calib::Solution after = solution_of(world, keep_all());
    for (const ArrivalReliability& a : after.reliability.arrivals)  // w against the stated noise
      if (a.arrival == chosen.arrival)
        found += std::abs(a.w) * after.tof_sigma_s / world.site.noise.tof_sigma_s > calib::kCriticalW;
  }
  testing::Test::RecordProperty("found", found);
  expect_share(found, worlds, power);
}

TEST(Reliability, ADetectableBiasIsFoundInEightyOfAHundred) {
  expect_found(1.0, 120, normal_cdf(calib::kDelta0 - calib::kCriticalW));
}
TEST(Reliability, OneAndAHalfTimesIsFoundAlmostAlways) {
  expect_found(1.5, 30, normal_cdf(1.5 * calib::kDelta0 - calib::kCriticalW));
}

TEST(Reliability, ErrorEllipsesHoldTheTruth) {
  int inside = 0, in_box = 0, n = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed, ++n) {
    const World world = must(simulate(near_hall(), 2000 + seed));
    const calib::Solution solution = solution_of(world);
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged);
    const std::size_t b = std::array<std::size_t, 5>{
        1, 2, 4, 5, 7}[seed % 5];  // one a world: the beacons of a world err together
    ASSERT_TRUE(solution.reliability.beacons[b].ellipse);
    const calib::ErrorEllipse& e = *solution.reliability.beacons[b].ellipse;
    const Eigen::Vector3d error = solution.state.beacon_p_map_m[b] - world.truth.beacons[b].position_m;
    const Eigen::Vector2d major(std::cos(e.azimuth_rad), std::sin(e.azimuth_rad)),
        minor(-major.y(), major.x());
    inside += std::pow(major.dot(error.head<2>()) / e.semi_major_m, 2) +
                  std::pow(minor.dot(error.head<2>()) / e.semi_minor_m, 2) <
              1;
    in_box += error.norm() < e.semi_axes_m[0];
  }
  RecordProperty("inside", inside);
  expect_share(inside, n, 0.95);
  EXPECT_GT(binomial_cdf(in_box, n, 0.95),
            1e-4);  // the ball round the ellipsoid holds more than the ellipsoid
}

TEST(Reliability, EllipseOfAKnownCovariance) {
  const double turn = 0.6;
  Eigen::Matrix3d R = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const calib::ErrorEllipse e =
      calib::error_ellipse(R * Eigen::Vector3d(4e-6, 1e-6, 9e-6).asDiagonal() * R.transpose());
  EXPECT_NEAR(e.azimuth_rad, turn, 1e-9);
  EXPECT_NEAR(e.semi_major_m, 2e-3 * std::sqrt(chi2_quantile(0.95, 2)), 1e-7);
  EXPECT_NEAR(e.semi_minor_m, 1e-3 * std::sqrt(chi2_quantile(0.95, 2)), 1e-7);
  EXPECT_NEAR(e.semi_axes_m[0], 3e-3 * std::sqrt(chi2_quantile(0.95, 3)), 1e-7);
  EXPECT_NEAR(e.semi_axes_m[2], 1e-3 * std::sqrt(chi2_quantile(0.95, 3)), 1e-7);
}

TEST(Reliability, ABeaconOfTwiceTheNoiseIsNamedByItsVarianceComponent) {
  constexpr std::size_t kNoisy = 5;
  double noisy = 0.0, noisy_expected = 0.0, variance = 0.0, others = 0.0, others_expected = 0.0;
  const int worlds = 12;
  for (int k = 0; k < worlds; ++k) {
    World world = must(simulate(near_hall(), 3000 + static_cast<std::uint64_t>(k)));
    std::mt19937_64 random(static_cast<std::uint64_t>(k));
    std::normal_distribution<double> more(0.0, std::sqrt(3.0) * world.site.noise.tof_sigma_s);
    for (Arrival& a : world.run.arrivals)
      if (a.beacon.index() == kNoisy) a.tof_s += more(random);
    const calib::Problem problem = problem_of(world);
    const calib::Solution solution = calib::solve(problem, keep_all());
    ASSERT_EQ(solution.status, calib::SolveStatus::kConverged);
    // Expectation of v'Pv of a part: trace of (I - H) S (I - H) over it, S the true variances over the stated
    // ones.
    const DenseAdjustment dense(problem, solution);
    Eigen::VectorXd S = Eigen::VectorXd::Ones(dense.residual.size());
    Eigen::VectorXi of = Eigen::VectorXi::Constant(S.size(), -1);
    for (std::size_t i = 0; i < dense.rows.size(); ++i)
      if (dense.rows[i].kind == DenseAdjustment::Row::kTof)
        of[static_cast<Eigen::Index>(i)] = dense.rows[i].beacon.value;
    for (Eigen::Index i = 0; i < S.size(); ++i)
      if (of[i] == static_cast<int>(kNoisy)) S[i] = 4.0;
    const Eigen::MatrixXd R = dense.residual_projector();
    const auto expected = [&](int beacon) {
      double squares = 0.0, redundancy = 0.0;
      for (Eigen::Index i = 0; i < S.size(); ++i) {
        if (of[i] != beacon) continue;
        squares += R.row(i).cwiseAbs2().dot(S);
        redundancy += R(i, i);
      }
      return squares / redundancy;
    };
    const auto& beacons = solution.reliability.beacons;
    noisy += *beacons[kNoisy].component.factor / worlds;
    const double mean = expected(kNoisy);
    noisy_expected += mean / worlds;
    variance += 2 * mean * mean / beacons[kNoisy].component.redundancy / worlds /
                worlds;  // of a scaled chi-square, nearly
    others += *beacons[1].component.factor / worlds;
    others_expected += expected(1) / worlds;
    EXPECT_LT(*beacons[kNoisy].component.chi2_p, 1e-4);
    EXPECT_EQ(std::max_element(beacons.begin(), beacons.end(),
                               [](const auto& a, const auto& b) {
                                 return a.component.factor.value_or(0) < b.component.factor.value_or(0);
                               })
                  ->name,
              problem.site.beacons[kNoisy].name);
  }
  RecordProperty("noisy", std::to_string(noisy));
  RecordProperty("noisy_expected", std::to_string(noisy_expected));
  RecordProperty("others", std::to_string(others));
  EXPECT_NEAR(noisy, noisy_expected, 3.9 * std::sqrt(variance));  // one in ten thousand
  EXPECT_NEAR(others, others_expected, 3.9 * std::sqrt(variance) / 3);
  EXPECT_GT(noisy_expected, 3.0);  // one step from equal weights: a part of the noise hides in the states
  EXPECT_LT(noisy_expected, 4.0);
}

TEST(Reliability, LeftOutArrivalsAreCountedByBeacon) {
  Scenario s = short_hall();
  s.echo_fraction = 0.2;
  const World world = must(simulate(s, 8));
  const calib::Solution solution = solution_of(world);
  std::size_t used = 0, late = 0, left_out = 0;
  for (const auto& b : solution.reliability.beacons) {
    used += b.used;
    late += b.late;
    left_out += b.late + b.early + b.other;
  }
  EXPECT_EQ(used, solution.statistics.arrivals);
  EXPECT_EQ(left_out, solution.left_out.size());
  EXPECT_GT(late, world.run.arrivals.size() / 20);
}

TEST(Reliability, ResidualsByGroup) {
  Scenario s = hall_scenario();
  s.warming_degC = 4.0;
  const calib::Solution solution = solution_of(must(simulate(s, 9)));
  const Reliability& r = solution.reliability;
  for (const auto* groups :
       {&r.by_beacon, &r.by_receiver, &r.by_distance, &r.by_temperature, &r.by_incidence, &r.by_time}) {
    std::size_t count = 0;
    double squares = 0.0;
    for (const auto& g : *groups) {
      count += g.count;
      squares += static_cast<double>(g.count) * g.rms_s * g.rms_s;
      EXPECT_LE(g.from, g.to);
      EXPECT_NEAR(g.rms_m, 345 * g.rms_s, 0.02 * g.rms_m);  // 343 to 350 m/s in this hall
    }
    EXPECT_EQ(count, solution.statistics.arrivals);
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(count)), solution.statistics.rms_s,
                1e-9 * solution.statistics.rms_s);
  }
  EXPECT_EQ(r.by_distance.size(), 8u);
  EXPECT_EQ(r.by_temperature.size(), 8u);
  EXPECT_GE(r.by_incidence.front().from, 0.0);
  EXPECT_LE(r.by_incidence.back().to, M_PI);
  EXPECT_DOUBLE_EQ(r.by_time.front().from, 0.0);
}

TEST(ResidualGroups, EqualKeysStayTogether) {
  std::vector<calib::GroupedResidual> all;
  for (int i = 0; i < 400; ++i) all.push_back({i < 300 ? 1.0 : 2.0 + i, 1e-6, 340.0});
  const auto groups = calib::groups_by_quantity(all, 4);
  ASSERT_EQ(groups.size(), 4u);
  EXPECT_EQ(groups[0].count, 300u);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(static_cast<double>(groups[i].count), 100.0 / 3, 1.0);
  EXPECT_NEAR(groups[0].mean_m, 340e-6, 1e-12);
  EXPECT_TRUE(calib::groups_by_quantity({}).empty());
}

}  // namespace reliability_test
}  // namespace octant::test
