// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/statement.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace octant::test {
namespace statement_test {

using calib::Statement;
using calib::What;

/// A site with its assumptions, without a solution.
struct Stated {
  calib::Problem problem;
  SharedState state;
  calib::ParameterLayout layout;
  calib::StatedSite stated;

  explicit Stated(Site site, std::vector<bool> usable = std::vector<bool>(8, true))
      : problem(problem_of(std::move(site))),
        state(prior_state(problem.site)),
        layout(calib::make_layout(problem, state, usable)),
        stated(problem, layout, usable) {}

  static calib::Problem problem_of(Site site) {
    calib::Problem problem;
    problem.site = std::move(site);
    problem.runs.resize(1);
    problem.typical_range_m = 9.0;
    return problem;
  }
  [[nodiscard]] std::size_t count(What what) const {
    const auto all = stated.all();
    return static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [what](const Statement& s) { return s.what == what; }));
  }
};

Site hall_site() { return hall_scenario().site; }

TEST(StatedSite, StatesWhatItHoldsAndWhatItHasPriorsOf) {
  Site site = hall_site();
  site.distances.push_back({BeaconId(1), BeaconId(2), 8.0, 0.01});
  const Stated s(site);
  EXPECT_EQ(s.count(What::kControlPoint), 3U);
  EXPECT_EQ(s.count(What::kBeaconDelay), 8U);
  EXPECT_EQ(s.count(What::kReceiver), 8U);
  EXPECT_EQ(s.count(What::kSpeed), 1U);
  EXPECT_EQ(s.count(What::kDistance), 1U);
  for (const What what : {What::kReceiverDelay, What::kSiteDelay, What::kNoDelays, What::kAttenuation})
    EXPECT_EQ(s.count(what), 0U);
}

TEST(StatedSite, ThatThereIsNoDelayIsAStatementWhereTimesAreOfOneClock) {
  Site site = hall_site();
  site.timing.delay_sigma_s = 0.0;
  EXPECT_EQ(Stated(site).count(What::kNoDelays), 1U) << "held on the beacons";
  site.timing.delay_per = {};
  EXPECT_EQ(Stated(site).count(What::kNoDelays), 1U);
  site.beacons[2].delay_sigma_s = 1e-4;  // not in use
  EXPECT_EQ(Stated(site).count(What::kNoDelays), 1U);
  site.timing.clock = Clock::kCycleOffset;
  EXPECT_EQ(Stated(site).count(What::kNoDelays), 0U) << "each cycle has an offset of its own";
  site.timing.clock = Clock::kSynchronised;
  site.tof_sigma_given = false;
  EXPECT_EQ(Stated(site).count(What::kNoDelays), 0U) << "bearings alone";
}

TEST(StatedSite, AControlPointThatIsNotInUseStatesNothing) {
  std::vector<bool> usable(8, true);
  usable[3] = false;
  EXPECT_EQ(Stated(hall_site(), usable).count(What::kControlPoint), 2U);
}

TEST(StatedSite, EveryStatementHasTheColumnsOfItsOwner) {
  Scenario scenario = hall_scenario();
  add_attenuation(scenario);
  scenario.site.timing.delay_per = {.beacon = true, .receiver = true, .site = true};
  const Stated s(scenario.site);
  const auto ids = [&](const Statement& statement) {
    std::vector<ParameterId> out;
    for (const int c : columns_of(statement, s.layout))
      out.push_back(s.layout.parameters[static_cast<std::size_t>(c)].id);
    return out;
  };
  using Ids = std::vector<ParameterId>;
  EXPECT_EQ(ids({What::kBeaconDelay, 4}), Ids{parameters::beacon_delay(4)});
  EXPECT_EQ(ids({What::kReceiverDelay, 2}), Ids{parameters::receiver_delay(2)});
  EXPECT_EQ(ids({What::kSiteDelay, 0}), Ids{parameters::site_delay()});
  EXPECT_EQ(ids({What::kSpeed, 0}), Ids{parameters::speed()});
  EXPECT_EQ(ids({What::kReceiver, 5}),
            (Ids{parameters::receiver_position(5, 0), parameters::receiver_position(5, 1),
                 parameters::receiver_position(5, 2)}));
  EXPECT_EQ(ids({What::kAttenuation, 1}), Ids{parameters::attenuation(1)});
  EXPECT_TRUE(ids({What::kControlPoint, 0}).empty()) << "held: none before it is released";
  EXPECT_EQ(ids({What::kNoDelays, 0}).size(), 8U);
  EXPECT_TRUE(ids({What::kDistance, 0}).empty());
}

TEST(LayoutWithout, AControlPointMayMoveFromWhereItWasStated) {
  const Stated s(hall_site());
  calib::Problem problem = s.problem;
  const Statement b3{What::kControlPoint, 3};
  const calib::ParameterLayout layout = s.stated.layout_without({b3}, s.state, problem);
  const std::vector<int> columns = columns_of(b3, layout);
  ASSERT_EQ(columns.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const calib::Parameter& p = layout.parameters[static_cast<std::size_t>(columns[i])];
    EXPECT_EQ(p.prior_mean, *s.problem.site.beacons[3].position_m[i]);
    EXPECT_EQ(p.prior_sigma, 9.0) << "a typical range: finite, and nothing to the data";
    EXPECT_EQ(s.stated.value(b3, layout, columns[i]), p.prior_mean);
    EXPECT_EQ(s.stated.sigma(b3, layout, columns[i]), 0.0) << "it was held";
  }
  EXPECT_EQ(layout.size(), s.layout.size() + 3);
  for (const calib::Parameter& p : s.layout.parameters) {  // all else is believed as before
    const int c = layout.column_of(p.id);
    ASSERT_GE(c, 0);
    EXPECT_EQ(layout.parameters[static_cast<std::size_t>(c)].prior_sigma, p.prior_sigma);
    EXPECT_EQ(layout.parameters[static_cast<std::size_t>(c)].prior_mean, p.prior_mean);
  }
}

TEST(StatedSite, ExchangesABeaconThatIsFoundAtThePositionOfAnotherOne) {
  const Stated s(hall_site());
  const auto place = [&](std::size_t b) { return s.state.beacon_p_map_m[b]; };
  const Eigen::Vector3d near_m(0.3, -0.2, 0.0);
  EXPECT_EQ(s.stated.exchange_of({What::kControlPoint, 6}, place(0) + near_m),
            (Statement{What::kLabels, 0, 6}));
  EXPECT_EQ(s.stated.exchange_of({What::kControlPoint, 6}, place(6) + near_m), std::nullopt);
  EXPECT_EQ(s.stated.exchange_of({What::kSpeed}, place(0)), std::nullopt);
}

// Only the alternatives' own positions change. All other priors are kept.
TEST(LayoutWithout, AlternativesChangePositionsAndReleaseNone) {
  Site site = hall_site();
  site.beacons[1].sigma_m = {0.1, 0.1, 0.1};
  const Stated s(site);
  for (const Statement& alternative : {Statement{What::kLabels, 0, 1}, Statement{What::kHeights}}) {
    calib::Problem problem = s.problem;
    const SharedState start = s.stated.with_alternative(alternative, s.state);
    const calib::ParameterLayout layout = s.stated.layout_without({alternative}, start, problem);
    EXPECT_EQ(layout.vector_of(start), layout.vector_of(prior_state(problem.site)));
  }
  calib::Problem problem = s.problem;
  (void)s.stated.layout_without({{What::kLabels, 0, 1}}, s.state, problem);
  for (const std::size_t b : {0U, 1U}) {
    EXPECT_EQ(problem.site.beacons[b].position_m, s.problem.site.beacons[1 - b].position_m);
    EXPECT_EQ(problem.site.beacons[b].sigma_m[0], 0.1) << "either line may be the one with the larger sigma";
  }
}

TEST(LayoutWithout, APriorIsWidenedAndItsStatementKept) {
  const Stated s(hall_site());
  calib::Problem problem = s.problem;
  for (const Statement& statement :
       {Statement{What::kSpeed, 0}, {What::kBeaconDelay, 2}, {What::kReceiver, 1}}) {
    const calib::ParameterLayout layout = s.stated.layout_without({statement}, s.state, problem);
    ASSERT_EQ(layout.size(), s.layout.size());
    for (const int c : columns_of(statement, layout)) {
      const calib::Parameter &now = layout.parameters[static_cast<std::size_t>(c)],
                             &was = s.layout.parameters[static_cast<std::size_t>(c)];
      EXPECT_GT(now.prior_sigma, 10 * was.prior_sigma);
      EXPECT_TRUE(std::isfinite(now.prior_sigma));
      EXPECT_EQ(s.stated.value(statement, layout, c), was.prior_mean);
      EXPECT_EQ(s.stated.sigma(statement, layout, c), was.prior_sigma);
    }
  }
}

TEST(LayoutWithout, TapesAreLeftOutHoweverManyAreReleased) {
  Site site = hall_site();
  for (int b = 1; b < 6; ++b) site.distances.push_back({BeaconId(0), BeaconId(b), 1.0 * b, 0.01});
  const Stated s(site);
  calib::Problem problem = s.problem;
  static_cast<void>(s.stated.layout_without(
      {{What::kDistance, 1}, {What::kDistance, 4}, {What::kDistance, 2}}, s.state, problem));
  ASSERT_EQ(problem.site.distances.size(), 2U);
  EXPECT_EQ(problem.site.distances[0].distance_m, 1.0);
  EXPECT_EQ(problem.site.distances[1].distance_m, 4.0);
}

TEST(LayoutWithout, MendedPriorsStay) {
  Stated s(hall_site());
  const int mended = s.layout.column_of(parameters::beacon_position(4, 1));
  s.layout.parameters[static_cast<std::size_t>(mended)].prior_sigma = INFINITY;  // its label was doubted
  calib::Problem problem = s.problem;
  const calib::ParameterLayout layout = s.stated.layout_without({{What::kSpeed, 0}}, s.state, problem);
  EXPECT_TRUE(std::isinf(layout.parameters[static_cast<std::size_t>(mended)].prior_sigma));
}

// Released delays of the beacons are added to those of the site or the receivers: at their given values every
// arrival is predicted as before.
TEST(LayoutWithout, DelaysThatAreReleasedBeginWhereTheyWereHeld) {
  const DelayPer kinds[] = {
      {}, {.beacon = true}, {.receiver = true}, {.site = true}, {.receiver = true, .site = true}};
  for (const DelayPer& per : kinds) {
    SCOPED_TRACE(testing::Message() << per.beacon << per.receiver << per.site);
    Site site = hall_site();
    site.timing.delay_per = per;
    site.timing.delay_s = 1.5e-4;
    site.timing.delay_sigma_s = 0.0;
    const Stated s(site);
    const Statement none{What::kNoDelays, 0};
    calib::Problem problem = s.problem;
    const calib::ParameterLayout layout = s.stated.layout_without({none}, s.state, problem);
    const std::vector<int> columns = columns_of(none, layout);
    ASSERT_EQ(columns.size(), 8U);
    Eigen::VectorXd x = layout.vector_of(s.state);
    for (const int c : columns) x[c] = s.stated.value(none, layout, c);
    const SharedState as_stated = layout.state_of(x);
    for (int b = 0; b < 8; ++b) {
      EXPECT_NEAR(as_stated.delay_s(BeaconId(b), ReceiverId(0)), 1.5e-4, 1e-18);
      EXPECT_NEAR(s.state.delay_s(BeaconId(b), ReceiverId(0)), 1.5e-4, 1e-18);
      const calib::Parameter& p =
          layout.parameters[static_cast<std::size_t>(columns[static_cast<std::size_t>(b)])];
      EXPECT_EQ(p.prior_mean, s.stated.value(none, layout, columns[static_cast<std::size_t>(b)]));
    }
  }
}

}  // namespace statement_test
}  // namespace octant::test
