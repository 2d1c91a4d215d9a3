// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The published systems by name, on the worlds after their papers.
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace methods_test {

using ::testing::HasSubstr;

class Methods : public ::testing::Test {
 protected:
  void make(const std::string& folder) {
    const Outcome made =
        octant({"simulate", std::string(OCTANT_SOURCE_DIR) + "/datasets/" + folder + "/scenario.yaml", "-o",
                box / "w"});
    ASSERT_EQ(made.exit, 0) << made.err;
  }
  [[nodiscard]] Outcome localize(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "localize", box / "w/deployment.true.json", box / "w/heldout", "-o", box / "f.tum", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return octant(words);
  }
  /// Rows of verify --all-methods by name.
  [[nodiscard]] std::map<std::string, nlohmann::json> compare() const {
    const Outcome said =
        octant({"verify", box / "w/deployment.true.json", box / "w/heldout", "--all-methods", "--json"});
    EXPECT_EQ(said.exit, 0) << said.err;
    std::map<std::string, nlohmann::json> rows;
    const nlohmann::json object = said.json();
    for (const auto& row : object["methods"]) rows[row["method"].get<std::string>()] = row;
    return rows;
  }
  TemporaryFolder box;
};

TEST_F(Methods, AreComparedOnTheSameRun) {
  make("head_tail");
  const auto rows = compare();
  EXPECT_EQ(rows.size(), 9U);
  for (const char* method : {"head_tail", "least_squares", "one_beacon"}) {
    ASSERT_TRUE(rows.at(method)["possible"].get<bool>()) << method;
    EXPECT_LT(rows.at(method)["position_rmse_m"].get<double>(), 0.002)
        << method;  // the datasets' README: 1.3 mm
    EXPECT_GE(rows.at(method)["fixes"].get<int>(), 38) << method;
  }
  EXPECT_FALSE(rows.at("rail")["possible"].get<bool>());
  EXPECT_THAT(rows.at("rail")["reason"].get<std::string>(), HasSubstr("rail"));
  EXPECT_THAT(rows.at("tracker")["reason"].get<std::string>(), HasSubstr("stops"));
}

TEST_F(Methods, AutoTakesTheRailAndSaysSo) {
  make("greenhouse");
  const auto said = localize({}).json();
  EXPECT_EQ(said["method"], "rail");
  EXPECT_EQ(said["why"], "the vehicle runs on a rail");
  EXPECT_EQ(localize({"--method", "one_beacon"}).json()["method"], "one_beacon");
  const auto rows = compare();
  EXPECT_LT(rows.at("rail")["position_rmse_m"].get<double>(), 0.008);
  EXPECT_LT(rows.at("rail")["max_error_m"].get<double>(), 0.03);  // figure 7: no serious fault
}

TEST_F(Methods, AutoMatchesUnlabelledBearings) {
  make("reflectors");
  const auto said = localize({}).json();
  EXPECT_EQ(said["method"], "reflectors");
  EXPECT_GE(said["fixes"].get<int>(), 55);
}

/// `--heading`: from the set of receivers that receive, as published and as sectors, and interpolated;
/// datasets/kleeman/README.md.
TEST_F(Methods, KleemansHeadingIsChosen) {
  make("kleeman");
  const auto heading_rad = [&](const char* from) {
    const Outcome said = octant({"verify", box / "w/deployment.true.json", box / "w/heldout", "--method",
                                 "kleeman", "--heading", from, "--json"});
    EXPECT_EQ(said.exit, 0) << said.err;
    return said.json()["heading_rmse_rad"].get<double>();
  };
  const double published = heading_rad("mean_axes"), hearing = heading_rad("hearing");
  const double interpolated = heading_rad("interpolation");
  EXPECT_LT(hearing, 0.96 * published);
  EXPECT_LT(hearing, 0.085);
  EXPECT_LT(interpolated, 0.026);
  EXPECT_EQ(localize({"--method", "kleeman", "--heading", "compass"}).exit, 2);
}

TEST_F(Methods, ScansAloneAskForAMap) {
  make("driveway");
  const Outcome without = localize({});
  EXPECT_EQ(without.exit, 3);
  EXPECT_THAT(without.json()["error"]["message"].get<std::string>(), HasSubstr("--map"));
  const Outcome with = localize({"--map", box / "w/run"});
  EXPECT_EQ(with.exit, 0) << with.err;
  EXPECT_EQ(with.json()["method"], "line_map");
  EXPECT_GT(with.json()["fixes"].get<int>(), 20);
}

TEST_F(Methods, AMethodThatDoesNotFitSaysWhatItWants) {
  make("binaural");
  const Outcome said = localize({"--method", "rail"});
  EXPECT_EQ(said.exit, 3);
  EXPECT_THAT(said.json()["error"]["message"].get<std::string>(), HasSubstr("rail"));
  EXPECT_EQ(localize({"--method", "gps"}).exit, 2);
  EXPECT_EQ(localize({"--method", "binaural"}).json()["no_fix"], 0);
}

}  // namespace methods_test
}  // namespace octant::test
