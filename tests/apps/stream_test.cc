// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant calibrate --memory-mb: logs that are read in chunks.
#include <csignal>
#include <filesystem>

#include <gmock/gmock.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace stream_test {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class Stream : public HallFolder {
 protected:
  void SetUp() override { make(1500); }
  [[nodiscard]] nlohmann::json deployment() const { return nlohmann::json::parse(slurp(out("d.json"))); }
  [[nodiscard]] std::string tof() const { return slurp(hall("run/tof.csv")); }

  /// Calibrates the hall in memory and in chunks: objects of the command, deployments, in this order.
  struct Both {
    nlohmann::json whole, streamed, whole_deployment, streamed_deployment;
  };
  void expect_the_same(std::size_t epochs, Both& both) const {
    const Outcome whole = calibrate({"--json"});
    ASSERT_EQ(whole.exit, 0) << whole.err;
    both.whole = whole.json();
    both.whole_deployment = deployment();
    EXPECT_TRUE(both.whole["streamed"].is_null());
    const Outcome streamed = calibrate({"--json", "--memory-mb", "1", "--report", out("r.md")});
    ASSERT_EQ(streamed.exit, 0) << streamed.err;
    EXPECT_THAT(streamed.err, HasSubstr("read in chunks"));
    both.streamed = streamed.json();
    both.streamed_deployment = deployment();
    EXPECT_EQ(both.streamed["streamed"]["epochs"], epochs);
    for (const char* key :
         {"arrivals", "rejected", "unknowns", "redundancy", "undetermined", "left_out", "datum"})
      EXPECT_EQ(both.whole[key], both.streamed[key]) << key;
    const auto &found = both.streamed_deployment, &expected = both.whole_deployment;
    EXPECT_EQ(found["inputs"], expected["inputs"]);
    for (std::size_t i = 0; i < expected["beacons"].size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(found["beacons"][i]["position_m"][axis].get<double>(),
                    expected["beacons"][i]["position_m"][axis].get<double>(), 1e-6);
    EXPECT_THAT(slurp(out("r.md")), HasSubstr("B7"));
  }
};

/// Changes data rows at regular intervals.
template <class Change>
std::string changed(const std::string& text, int every, Change&& change) {
  std::string out;
  int line = 0;
  for (std::size_t begin = 0; begin < text.size(); ++line) {
    const std::size_t end = text.find('\n', begin);
    const std::string row = text.substr(begin, end - begin);
    out += (line > 0 && line % every == 0 ? change(row) : row) + "\n";
    begin = end + 1;
  }
  return out;
}

TEST_F(Stream, GivesTheAnswerOfTheWhole) {
  make(4100);  // so many begin with a part, streamed or not
  // Rows that are no measurement, and one in quotes, behind which the reader goes another way.
  spit(hall("run/tof.csv"), changed(tof(), 997, [](const std::string& row) {
         const std::size_t tof = row.find(',', row.find(',') + 1) + 1;  // time_s,beacon,tof_s,...
         return row.substr(0, tof) + "nan" + row.substr(row.find(',', tof));
       }));
  std::string text = tof();
  const std::size_t middle = text.find('\n', text.size() / 2) + 1, comma = text.find(',', middle);
  text = text.substr(0, middle) + "\"" + text.substr(middle, comma - middle) + "\"" + text.substr(comma);
  spit(hall("run/tof.csv"), text);

  Both both;
  expect_the_same(4100, both);
  EXPECT_EQ(both.whole["warnings"], both.streamed["warnings"]);
  EXPECT_EQ(both.whole["reliability"]["beacons"].size(), both.streamed["reliability"]["beacons"].size());
  EXPECT_EQ(both.streamed_deployment["validity"]["temperature_degC"],
            both.whole_deployment["validity"]["temperature_degC"]);
}

TEST_F(Stream, DrivesGiveTheAnswerOfTheWhole) {
  make(hall_scenario_text(
      "path: {kind: stops, epochs: 150, epoch_period_s: 5.0, slot_s: 0.05}\nheldout_path: {epochs: 40}",
      "path: {kind: drive, duration_s: 500}\nheldout_path: {duration_s: 5}"));
  Both both;
  expect_the_same(10001, both);  // states, at the rows of odometry.csv
}

// Contradictions have the same descriptions for streamed arrivals, and plan reports them too.
TEST_F(Stream, NamesTheSameCulprits) {
  std::string site = slurp(hall("site.yaml"));
  const std::string stated = "position_m: [19.95, 8.15, 2.48]";  // control point B3
  ASSERT_NE(site.find(stated), std::string::npos);
  spit(hall("site.yaml"), site.replace(site.find(stated), stated.size(), "position_m: [19.45, 8.15, 2.48]"));
  const Outcome whole = calibrate({"--json"}), streamed = calibrate({"--json", "--memory-mb", "1"});
  EXPECT_EQ(whole.exit, 6) << whole.err;
  EXPECT_EQ(streamed.exit, 6) << streamed.err;
  EXPECT_THAT(streamed.err, HasSubstr("read in chunks"));
  const auto expected = whole.json()["verdict"]["contradictions"],
             found = streamed.json()["verdict"]["contradictions"];
  ASSERT_FALSE(expected.empty());
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (const char* key : {"kind", "subject", "stated", "remedy"})
      EXPECT_EQ(found[i][key], expected[i][key]);
    // Sums in another order reject another arrival or two at the threshold.
    const double sigmas = expected[i]["sigmas"];
    EXPECT_NEAR(found[i]["sigmas"].get<double>(), sigmas, 0.05 * sigmas);
  }
  const std::string culprit = expected[0]["subject"];
  EXPECT_EQ(culprit, "B3");
  const Outcome plan = octant(
      {"plan", hall("site.yaml"), hall("run"), "--stations", "1", "--grid", "3", "--progress", "none"});
  EXPECT_THAT(plan.err, HasSubstr("contradict"));
  EXPECT_THAT(plan.err, HasSubstr(culprit));
}

TEST_F(Stream, SaysWhereARowIsWrong) {
  spit(hall("run/tof.csv"), tof() + "1e9,B99,0.01,0,r0\n");
  const Outcome whole = calibrate(), streamed = calibrate({"--memory-mb", "1"});
  EXPECT_EQ(streamed.exit, 3);
  EXPECT_THAT(streamed.err, HasSubstr(whole.err));
  EXPECT_THAT(outputs(), IsEmpty());
}

// An arrival at the limit of what agrees may be in use in the one and left out in the other.
TEST_F(Stream, StopsWithOdometryBetweenThemAreStreamed) {
  spit(hall("run/odometry.csv"), "time_s,dx_m,dy_m,dheading_rad\n10.0,0,0,0\n11.0,0.1,0,0\n");
  const Outcome whole = calibrate({"--json"}), streamed = calibrate({"--json", "--memory-mb", "1"});
  ASSERT_EQ(whole.exit, 0) << whole.err;
  ASSERT_EQ(streamed.exit, 0) << streamed.err;
  EXPECT_THAT(streamed.err, HasSubstr("they are read in chunks"));
  EXPECT_TRUE(whole.json()["streamed"].is_null());
  EXPECT_EQ(streamed.json()["streamed"]["epochs"], 1500);
  EXPECT_NEAR(streamed.json()["arrivals"].get<double>(), whole.json()["arrivals"].get<double>(), 3);
}

TEST_F(Stream, SmallLogsAreNot) {
  const Outcome done = calibrate({"-v"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_THAT(done.err, Not(HasSubstr("chunks")));
  EXPECT_EQ(calibrate({"--memory-mb", "0"}).exit, 2);
}

TEST_F(Stream, InterruptedLeavesNothingBehind) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Outcome stopped = octant({"calibrate", hall("site.yaml"), hall("run"), "-o", out("d.json"),
                                    "--json", "--progress", "json", "--memory-mb", "1"},
                                   {.interrupt_signal = signal});
    EXPECT_EQ(stopped.exit, 130) << stopped.err;
    EXPECT_EQ(stopped.json()["status"], "interrupted") << stopped.out;
    EXPECT_THAT(outputs(), IsEmpty());
  }
}

}  // namespace stream_test
}  // namespace octant::test
