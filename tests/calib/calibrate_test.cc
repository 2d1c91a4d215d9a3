// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The product is one function: false statements are named in the same words by every way to it.
#include "calib/calibrate.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/check.h"
#include "tests/calib/memory_source.h"
#include "tests/calib/readings/cart.h"

namespace octant::test {
namespace calibrate_test {

using ::testing::Contains;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// A hall in which one thing that the user states is false.
struct FalseStatement {
  const char* name;
  void (*falsify)(World& world);
};

const FalseStatement kFalseStatements[] = {
    {"ControlPoint",
     [](World& w) { w.site.beacons[3].position_m[0] = *w.site.beacons[3].position_m[0] - 0.5; }},
    {"ControlPointsExchanged",
     [](World& w) { std::swap(w.site.beacons[0].position_m, w.site.beacons[3].position_m); }},
    {"Thermometer",
     [](World& w) {
       w.site.medium.temperature_degC += 15.0;
       w.site.speed_sigma_mps = 0.5;
     }},
    {"ReceiversExchanged",
     [](World& w) { std::swap(w.site.receivers[1].position_m, w.site.receivers[2].position_m); }},
    {"ReceiverPosition", [](World& w) { w.site.receivers[2].position_m.x() += 0.05; }},
    {"DelayOfABeacon",
     [](World& w) {
       w.site.beacons[4].delay_s = 5e-4;
       w.site.beacons[4].delay_sigma_s = 1e-5;
     }},
    {"NoDelays",
     [](World& w) {
       w.site.timing.delay_per = {};
       w.site.timing.delay_s = 0.0;
       w.site.timing.delay_sigma_s = 0.0;
     }},
    {"TwoWayTimes",
     [](World& w) {
       for (Arrival& a : w.run.arrivals) a.tof_s *= 2;
     }},
    {"ClockThatJumped", [](World& w) { static_cast<void>(jump_clock(w, 0.5, 1e-3)); }},
    {"Epochs",
     [](World& w) {
       for (Arrival& a : w.run.arrivals) a.epoch = kNoEpoch;
       w.run.has_epochs = false;
     }},
};

/// Contradictions, without values that depend on the method.
std::vector<std::string> culprits(const calib::Solution& solution) {
  std::vector<std::string> found = {std::string("status ") + calib::to_string(solution.status)};
  for (const Contradiction& c : solution.contradictions)
    found.push_back(std::string(to_string(c.kind)) + " " + c.subject + ": " + c.remedy);
  return found;
}

std::vector<std::string> texts(const std::vector<calib::Finding>& findings) {
  std::vector<std::string> words;
  for (const calib::Finding& f : findings) words.push_back(f.text);
  std::ranges::sort(words);
  return words;
}

calib::Calibration calibrated(const World& world, const calib::CalibrationOptions& options = {}) {
  calib::CalibrationOptions all = options;
  all.solve.diagnosis_s = INFINITY;  // what is found may not depend on the speed of the machine
  return must(calib::calibrate(world.site, {world.run}, all));
}

class FalseStatements : public testing::TestWithParam<FalseStatement> {};

TEST_P(FalseStatements, AreNamedInTheSameWordsByAllWays) {
  World world = cart(40, 3, 0.0);
  GetParam().falsify(world);
  const calib::Calibration whole = calibrated(world);
  const std::vector<std::string> expected = culprits(whole.solution);
  EXPECT_GE(expected.size() + whole.findings.size(), 2U) << "nothing is named";

  MemorySource source({world.run}, 300);
  calib::CalibrationOptions small;
  small.solve.diagnosis_s = INFINITY;
  small.memory_bytes = std::size_t{8} << 20U;
  const calib::Calibration streamed = must(calib::calibrate(world.site, source, small));
  EXPECT_THAT(culprits(streamed.solution), ElementsAreArray(expected)) << "streamed";
  EXPECT_EQ(texts(streamed.findings), texts(whole.findings));
  EXPECT_EQ(streamed.deployment.has_value(), whole.deployment.has_value());

  calib::CalibrationOptions sparse;
  sparse.solve.dense_limit = 1;
  EXPECT_THAT(culprits(calibrated(world, sparse).solution), ElementsAreArray(expected))
      << "as a site of very many parameters";

  const calib::Forecast forecast = calib::forecast(problem_of(world), {.diagnosis_s = INFINITY});
  EXPECT_THAT(culprits(forecast.solution), ElementsAreArray(expected)) << "check";
}

INSTANTIATE_TEST_SUITE_P(Calibrate, FalseStatements, testing::ValuesIn(kFalseStatements),
                         [](const auto& of) { return std::string(of.param.name); });

TEST(Calibrate, IsSilentOnAHallThatIsAsStated) {
  const World world = cart(40, 3, 0.0);
  const calib::Calibration calibration = calibrated(world);
  EXPECT_TRUE(calibration.solution.contradictions.empty());
  EXPECT_TRUE(calibration.findings.empty());
  ASSERT_TRUE(calibration.deployment);
  EXPECT_FALSE(calibration.solution.diagnosis.is_cut_short);
  EXPECT_GT(calibration.solution.diagnosis.fit_s, 0.0);
}

// Findings are known where an error ends the calibration.
TEST(Calibrate, PassesFindingsOnBeforeItEndsInAnError) {
  World world = cart(40, 3, 0.0);
  for (Arrival& a : world.run.arrivals) a.tof_s *= 1e3;  // milliseconds
  std::vector<std::string> found;
  calib::CalibrationOptions options;
  options.on_finding = [&](const calib::Finding& f) { found.push_back(f.kind); };
  EXPECT_FALSE(calib::calibrate(world.site, {world.run}, options));
  EXPECT_THAT(found, testing::Contains("unit"));
}

// A user who stops the search keeps the calibration, and reads that the search is not complete.
TEST(Calibrate, IsCompleteWhenItsDiagnosisIsCutShort) {
  World world = cart(40, 3, 0.0);
  kFalseStatements[0].falsify(world);
  calib::CalibrationOptions options;
  options.solve.on_progress = [](const calib::Progress& p) {
    return p.stage != "search for what contradicts the data";
  };
  const calib::Calibration calibration = calibrated(world, options);
  EXPECT_EQ(calibration.solution.status, calib::SolveStatus::kConverged);
  EXPECT_TRUE(calibration.deployment);
  EXPECT_TRUE(calibration.solution.diagnosis.is_cut_short);
  EXPECT_THAT(calibration.solution.warnings,
              testing::Contains(HasSubstr("before all hypotheses were examined")));
}

// Residuals of fifty sigmas that no hypothesis explains are never Good.
TEST(Calibrate, ContradictsNoiseThatNothingExplains) {
  World world = cart(40, 3, 0.0);
  world.site.noise.tof_sigma_s = 2e-7;
  const calib::Calibration calibration = calibrated(world);
  ASSERT_FALSE(calibration.solution.contradictions.empty());
  EXPECT_THAT(calibration.solution.contradictions.front().found, HasSubstr("variance factor"));
}

// Residuals within the stated noise are no misfit, but a lag of the poses moves beacons all the same.
TEST(Calibrate, CorrectsPosesThatAreStampedEarly) {
  Scenario drive = drive_scenario(40.0);
  drive.log_poses = true;
  World world = must(simulate(drive, 11));
  world.site.noise.tof_sigma_s *= 5;
  constexpr double kLag_s = 0.05;
  const double true_s = world.run.poses.front().time_s;
  for (TimedPose& pose : world.run.poses) pose.time_s -= kLag_s;
  calib::CalibrationOptions options;  // with ranges between beacons, one of which is an echo
  const auto& beacons = world.truth.beacons;
  const double c_mps = world.truth.speed_mps(world.truth.medium.temperature_degC);
  for (std::size_t a = 0; a < beacons.size(); ++a)
    for (std::size_t b = a + 1; b < beacons.size(); ++b)
      options.beacon_flights.push_back({0.0, BeaconId(a), BeaconId(b),
                                        world.site.timing.delay_s +
                                            (beacons[a].position_m - beacons[b].position_m).norm() / c_mps +
                                            (a == 1 && b == 4 ? 9e-3 : 0.0)});
  const calib::Calibration calibration = must(calib::calibrate(world.site, {world.run}, options));
  EXPECT_THAT(calibration.solution.contradictions, IsEmpty());
  EXPECT_THAT(calibration.solution.warnings, Contains(HasSubstr("s early")));
  EXPECT_THAT(calibration.solution.warnings, Contains(HasSubstr("between the beacons B1 and B4")));
  // At 0.6 m/s this is the sigma of an arrival, of which there are thousands.
  EXPECT_NEAR(calibration.problem.runs[0].poses.front().time_s, true_s, 0.006);
}

}  // namespace calibrate_test
}  // namespace octant::test
