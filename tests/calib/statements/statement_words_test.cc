// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Descriptions of contradicted assumptions; fits by hand, without recordings.
#include "calib/statements/statement_words.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/physics/medium.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace statement_words_test {

using calib::Statement;
using calib::What;
using ::testing::HasSubstr;
using ::testing::Not;

/// A site, and a fit in which some of its statements are not believed.
struct Disbelieved {
  calib::Problem problem;
  calib::ParameterLayout layout;
  calib::StatedSite stated;
  calib::Fit fit;
  std::vector<Statement> culprits;

  Disbelieved(Site site, std::vector<Statement> released)
      : problem(problem_of(std::move(site))),
        layout(calib::make_layout(problem, prior_state(problem.site))),
        stated(problem, layout, std::vector<bool>(8, true)),
        culprits(std::move(released)) {
    const SharedState state = prior_state(problem.site);
    fit.problem.runs.resize(1);
    fit.layout = stated.layout_without(culprits, state, fit.problem);
    fit.x = fit.layout.vector_of(state);
    fit.beacon_usable.assign(8, true);
  }
  static calib::Problem problem_of(Site site) {
    calib::Problem problem;
    problem.site = std::move(site);
    problem.runs.resize(1);
    problem.typical_range_m = 9.0;
    return problem;
  }
  void found(const ParameterId& id, double value) {
    const int c = fit.layout.column_of(id);
    ASSERT_GE(c, 0);
    fit.x[c] = value / fit.layout.parameters[static_cast<std::size_t>(c)].si_per_unit;
  }
  void found_at(std::size_t beacon, const Eigen::Vector3d& p) {
    for (std::size_t i = 0; i < 3; ++i)
      found(parameters::beacon_position(beacon, i), p[static_cast<Eigen::Index>(i)]);
  }
  [[nodiscard]] std::vector<Contradiction> words() const {
    return calib::in_words(stated, fit, culprits, std::vector<double>(culprits.size(), 12.0));
  }
  [[nodiscard]] Contradiction only() const {
    const auto all = words();
    EXPECT_EQ(all.size(), 1U);
    return all.at(0);
  }
};

Site hall_site() { return hall_scenario().site; }

TEST(StatementWords, OfAControlPointSayWhereItIsAndHowFarAway) {
  Disbelieved d(hall_site(), {{What::kControlPoint, 3}});
  d.found_at(3, {19.95, 8.45, 2.88});
  const Contradiction c = d.only();
  EXPECT_EQ(c.kind, ContradictionKind::kControlPoint);
  EXPECT_EQ(c.subject, "B3");
  EXPECT_EQ(c.stated, "at (19.950, 8.150, 2.480) m, held fixed");
  EXPECT_EQ(c.found, "at (19.950, 8.450, 2.880) m, 500.0 mm away");
  EXPECT_EQ(c.sigmas, 12.0);
  EXPECT_THAT(c.remedy, HasSubstr("survey control point B3 again"));
}

// In the plane a place below the receivers, 0.3 m up, explains arrivals as its image above them does.
TEST(StatementWords, OfAControlPointStandOnTheSideWhereItIsKnownToBe) {
  Disbelieved d(hall_site(), {{What::kControlPoint, 3}});
  d.found_at(3, {19.95, 8.15, 0.6 - 2.88});
  EXPECT_EQ(d.only().found, "at (19.950, 8.150, 2.880) m, 400.0 mm away");
}

TEST(StatementWords, OfExchangedControlPointsAreOne) {
  const Disbelieved d(hall_site(), {{What::kLabels, 0, 6}});
  const Contradiction c = d.only();
  EXPECT_EQ(c.kind, ContradictionKind::kExchanged);
  EXPECT_EQ(c.subject, "B0, B6");
  EXPECT_EQ(c.found, "at each other's places");
  EXPECT_EQ(c.sigmas, 12.0);
  EXPECT_THAT(c.remedy, HasSubstr("exchange the positions of control points B0 and B6"));
}

TEST(StatementWords, OfHeightsSayInWhichDirectionTheyCount) {
  const Disbelieved d(hall_site(), {{What::kHeights}});
  EXPECT_THAT(d.only().found, HasSubstr("heights count downwards"));
}

TEST(StatementWords, OfADelaySayItInMicrosecondsOrNanoseconds) {
  Disbelieved sound(hall_site(), {{What::kBeaconDelay, 4}});
  sound.found(parameters::beacon_delay(4), 4.123e-4);
  Contradiction c = sound.only();
  EXPECT_EQ(c.kind, ContradictionKind::kDelay);
  EXPECT_EQ(c.subject, "B4");
  EXPECT_EQ(c.stated, "100.0 us, sigma 50.0 us");
  EXPECT_EQ(c.found, "412.3 us");
  Site site = hall_site();
  site.beacons[4].delay_s = 2e-9;
  site.beacons[4].delay_sigma_s = 1e-9;
  Disbelieved radio(site, {{What::kBeaconDelay, 4}});
  radio.found(parameters::beacon_delay(4), 31.25e-9);
  c = radio.only();
  EXPECT_EQ(c.stated, "2.00 ns, sigma 1.00 ns") << "the beacon's own prior";
  EXPECT_EQ(c.found, "31.25 ns");
}

// For any owner of the one delay, the description has the full delay, not the additional part.
TEST(StatementWords, OfAHeldDelaySayTheWholeOfIt) {
  const DelayPer kinds[] = {{}, {.beacon = true}, {.receiver = true}, {.site = true}};
  for (const DelayPer& per : kinds) {
    SCOPED_TRACE(testing::Message() << per.beacon << per.receiver << per.site);
    Site site = hall_site();
    site.timing.delay_per = per;
    site.timing.delay_s = 1.5e-4;
    site.timing.delay_sigma_s = 0.0;
    Disbelieved d(site, {{What::kNoDelays, 0}});
    const SharedState state = prior_state(site);
    for (int b = 0; b < 8; ++b) {
      const double held_elsewhere_s =
          state.delay_s(BeaconId(b), ReceiverId(0)) - state.beacon_delay_s[static_cast<std::size_t>(b)];
      d.found(parameters::beacon_delay(static_cast<std::size_t>(b)), 5e-4 + 1e-5 * b - held_elsewhere_s);
    }
    const Contradiction c = d.only();
    EXPECT_EQ(c.subject, "all beacons");
    EXPECT_EQ(c.stated, "a delay of exactly 150.0 us");
    EXPECT_EQ(c.found, "delays from 500.0 us to 570.0 us");
  }
}

TEST(StatementWords, OfNoDelaySayThatNoneWasStated) {
  Site site = hall_site();
  site.timing.delay_per = {};
  site.timing.delay_s = site.timing.delay_sigma_s = 0.0;
  Disbelieved d(site, {{What::kNoDelays, 0}});
  d.fit.beacon_usable[7] = false;  // of which nothing is said
  for (std::size_t b = 0; b < 8; ++b)
    d.found(parameters::beacon_delay(b), b == 7 ? 1.0 : 1e-4 * static_cast<double>(b + 1));
  EXPECT_EQ(d.only().stated, "no delay (timing.delay_per: none)");
  EXPECT_EQ(d.only().found, "delays from 100.0 us to 700.0 us");
}

TEST(StatementWords, NameTheOnlyBeaconWithADelay) {
  Site site = hall_site();
  site.timing.delay_per = {};
  site.timing.delay_s = site.timing.delay_sigma_s = 0.0;
  Disbelieved d(site, {{What::kNoDelays, 0}});
  for (std::size_t b = 0; b < 8; ++b)
    d.found(parameters::beacon_delay(b), b == 3 ? -3.5e-4 : 1e-6 * static_cast<double>(b));
  EXPECT_EQ(d.only().subject, "B3");
  EXPECT_EQ(d.only().found, "a delay of -350.0 us, and about 4.0 us of all others");
}

TEST(StatementWords, OfTheSpeedSayWhatTemperatureItWouldBe) {
  Disbelieved d(hall_site(), {{What::kSpeed, 0}});
  Trajectory t;
  ArrivalObservation a;
  a.model_speed_mps = speed_mps(d.problem.site.medium);
  t.arrivals.assign(10, a);
  d.fit.trajectories = {t};
  const double true_mps = speed_mps(d.problem.site.medium, 30.0);
  d.found(parameters::speed(), true_mps - a.model_speed_mps);
  const Contradiction c = d.only();
  EXPECT_EQ(c.kind, ContradictionKind::kSpeed);
  EXPECT_THAT(c.stated, HasSubstr("at 21.0 degC"));
  EXPECT_THAT(c.found, HasSubstr("as at 30.0 degC"));
  EXPECT_THAT(c.found, Not(HasSubstr("Fahrenheit")));
  EXPECT_THAT(c.remedy, HasSubstr("thermometer"));
}

TEST(StatementWords, KnowDegreesFahrenheit) {
  Site site = hall_site();
  site.medium.temperature_degC = 69.8;  // 21 degC
  Disbelieved d(site, {{What::kSpeed, 0}});
  Trajectory t;
  ArrivalObservation a;
  a.model_speed_mps = speed_mps(site.medium);
  t.arrivals.assign(10, a);
  d.fit.trajectories = {t};
  d.found(parameters::speed(), speed_mps(site.medium, 21.0) - a.model_speed_mps);
  EXPECT_THAT(d.only().found, HasSubstr("69.8 degF are 21.0 degC"));
  EXPECT_THAT(d.only().remedy, HasSubstr("Fahrenheit"));
}

TEST(StatementWords, OfAConstantMediumSayNothingOfAThermometer) {
  Site site = hall_site();
  site.medium = {.model = MediumModel::kConstant, .speed_mps = 1480.0};
  Disbelieved d(site, {{What::kSpeed, 0}});
  d.found(parameters::speed(), 20.0);
  EXPECT_THAT(d.only().remedy, HasSubstr("check medium.speed_mps"));
  EXPECT_THAT(d.only().stated, Not(HasSubstr("degC")));
}

TEST(StatementWords, OfAReceiverAndATape) {
  Site site = hall_site();
  site.distances.push_back({BeaconId(1), BeaconId(5), 12.0, 0.003});
  Disbelieved d(site, {{What::kReceiver, 2}, {What::kDistance, 0}});
  const Eigen::Vector3d at = site.receivers[2].position_m;
  d.found(parameters::receiver_position(2, 0), at.x() + 0.03);
  d.found(parameters::receiver_position(2, 1), at.y() + 0.04);
  d.found_at(1, {10, 0, 2});
  d.found_at(5, {10, 11.5, 2});
  const auto words = d.words();
  ASSERT_EQ(words.size(), 2U);
  EXPECT_EQ(words[0].subject, "robot/r2");
  EXPECT_THAT(words[0].found, HasSubstr("50.0 mm away"));
  EXPECT_EQ(words[1].kind, ContradictionKind::kDistance);
  EXPECT_EQ(words[1].subject, "B1, B5");
  EXPECT_EQ(words[1].stated, "12.0000 m, sigma 3.0 mm");
  EXPECT_EQ(words[1].found, "11.5000 m");
}

TEST(StatementWords, OfAnAttenuationAreInItsOwnUnits) {
  Scenario scenario = hall_scenario();
  add_attenuation(scenario);
  Disbelieved d(scenario.site, {{What::kAttenuation, 2}});
  d.found(parameters::attenuation(2), 9e-4);
  const Contradiction c = d.only();
  EXPECT_EQ(c.kind, ContradictionKind::kAttenuation);
  EXPECT_EQ(c.stated, "0.00045, sigma 0.0001");
  EXPECT_EQ(c.found, "0.0009");
  EXPECT_THAT(c.subject, HasSubstr("rise_time_s"));
}

}  // namespace statement_words_test
}  // namespace octant::test
