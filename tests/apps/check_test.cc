// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant check as a process: exit codes, one JSON object, no files written, truth.tum never opened.
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace check_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Check : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string fewer = std::regex_replace(
        hall_scenario_text(), std::regex("epochs: [0-9]+, epoch_period_s"), "epochs: 40, epoch_period_s");
    spit(box / "scenario.yaml", fewer);
    ASSERT_EQ(octant({"simulate", box / "scenario.yaml", "-o", box / "hall"}).exit, 0);
  }
  [[nodiscard]] std::string hall(const std::string& name) const { return box / ("hall/" + name); }
  [[nodiscard]] Outcome check(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"check", hall("site.yaml"), hall("run"), "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    return octant(words);
  }
  /// tof.csv with its rows changed: by the header's names.
  void rewrite(const std::function<bool(std::vector<std::string>& cells,
                                        const std::vector<std::string>& header)>& keep) const {
    std::istringstream in(slurp(hall("run/tof.csv")));
    std::string line, out;
    std::vector<std::string> header;
    while (std::getline(in, line)) {
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (!line.empty() && line.back() == ',') cells.emplace_back();
      if (header.empty())
        header = cells;
      else if (!keep(cells, header))
        continue;
      for (std::size_t i = 0; i < cells.size(); ++i) out += (i > 0 ? "," : "") + cells[i];
      out += "\n";
    }
    spit(hall("run/tof.csv"), out);
  }
  static std::size_t at(const std::vector<std::string>& header, const std::string& name) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  }
  static std::set<std::string> kinds(const nlohmann::json& object) {
    std::set<std::string> found;
    for (const auto& f : object["health"]["findings"]) found.insert(f["kind"].get<std::string>());
    return found;
  }
  TemporaryFolder box;
};

TEST_F(Check, AGoodHallIsExit0WithTableAndForecast) {
  const Outcome fine = check();
  EXPECT_EQ(fine.exit, 0) << fine.err;
  EXPECT_THAT(fine.err, IsEmpty());
  for (const char* word : {"beacon", "arrivals", "robot/r7", "clock jumps", "forecast", "speed",
                           "these data can determine", "present (not opened)"})
    EXPECT_THAT(fine.out, HasSubstr(word));
  EXPECT_TRUE(fine.out.starts_with("verdict          these data can determine")) << "what one came for";
  EXPECT_THAT(fine.out, HasSubstr(" fixed  fixed  fixed ")) << "control points are no 0.00";
}

TEST_F(Check, JsonIsOneObjectAndNothingIsWritten) {
  const auto before = slurp(hall("run/tof.csv"));
  const Outcome fine = check({"--json"});
  EXPECT_EQ(fine.exit, 0);
  const auto object = fine.json();
  ASSERT_TRUE(object.is_object()) << fine.out;
  EXPECT_EQ(object["status"], "ok");
  EXPECT_TRUE(object["warnings"].is_array());
  EXPECT_EQ(object["health"]["runs"].size(), 1U);
  EXPECT_EQ(object["health"]["runs"][0]["beacons"].size(), 8U);
  EXPECT_TRUE(object["health"]["runs"][0]["truth"].get<bool>());
  EXPECT_EQ(object["verdict"]["status"], "ok");
  EXPECT_TRUE(object["verdict"]["forecast"].get<bool>());
  EXPECT_GT(object["verdict"]["speed_sigma_mps"].get<double>(), 0.0);
  ASSERT_EQ(object["beacons"].size(), 8U);
  EXPECT_GT(object["beacons"][1]["sigma_m"][0].get<double>(), 0.0);
  EXPECT_EQ(slurp(hall("run/tof.csv")), before);
  EXPECT_THAT(box.names(), ::testing::ElementsAre("hall", "scenario.yaml"));
}

TEST_F(Check, TruthIsNeverOpened) {
  spit(hall("run/truth.tum"), "this is no track\n");
  EXPECT_EQ(check().exit, 0);
  std::filesystem::remove(hall("run/truth.tum"));
  EXPECT_FALSE(check({"--json"}).json()["health"]["runs"][0]["truth"].get<bool>());
}

TEST_F(Check, SilentBeaconIsAWarning) {
  rewrite([](auto& cells, const auto& header) { return cells[at(header, "beacon")] != "B5"; });
  const Outcome silent = check({"--json"});
  EXPECT_EQ(silent.exit, 0);
  const auto object = silent.json();
  EXPECT_THAT(kinds(object), Contains("silent_beacon"));
  EXPECT_THAT(object["verdict"]["undetermined"], Contains("beacon/B5"));
  EXPECT_TRUE(object["beacons"][5]["sigma_m"].is_null());
  EXPECT_THAT(check().err, HasSubstr("beacon B5 is in the site but was never heard"));
  EXPECT_EQ(check({"--strict"}).exit, 5);
}

TEST_F(Check, MillisecondsAreExit3AndNamed) {
  rewrite([](auto& cells, const auto& header) {
    std::string& tof = cells[at(header, "tof_s")];
    tof = std::to_string(1e3 * std::stod(tof));
    return true;
  });
  const Outcome wrong = check({"--json"});
  EXPECT_EQ(wrong.exit, 3);
  const auto object = wrong.json();
  ASSERT_TRUE(object.is_object()) << wrong.out;
  EXPECT_EQ(object["status"], "error");
  EXPECT_EQ(object["error"]["code"], "bad_input");
  EXPECT_THAT(object["error"]["file"].get<std::string>(), HasSubstr("tof.csv"));
  EXPECT_THAT(kinds(object), Contains("unit"));
  EXPECT_THAT(check().err, HasSubstr("looks like milliseconds"));
  EXPECT_THAT(check().out, HasSubstr("median range")) << "the health is told all the same";
}

TEST_F(Check, ExchangedReceiversAreNamed) {
  rewrite([](auto& cells, const auto& header) {
    std::string& receiver = cells[at(header, "receiver")];
    receiver = receiver == "r0" ? "r4" : receiver == "r4" ? "r0" : receiver;
    return true;
  });
  EXPECT_THAT(check().err, HasSubstr("receivers r0 and r4 of robot are exchanged"));
}

TEST_F(Check, CalibrateNamesExchangedReceiversAndExportsNothing) {
  rewrite([](auto& cells, const auto& header) {
    std::string& receiver = cells[at(header, "receiver")];
    receiver = receiver == "r0" ? "r4" : receiver == "r4" ? "r0" : receiver;
    return true;
  });
  const Outcome refused = octant(
      {"calibrate", hall("site.yaml"), hall("run"), "-o", box / "d.json", "--json", "--progress", "none"});
  EXPECT_EQ(refused.exit, 6) << refused.out;
  const auto object = refused.json();
  EXPECT_EQ(object["verdict"]["grade"], "Contradicted");
  ASSERT_EQ(object["verdict"]["contradictions"].size(), 1U) << "the rest are its consequences";
  EXPECT_EQ(object["verdict"]["contradictions"][0]["kind"], "wiring");
  EXPECT_THAT(object["error"]["message"].get<std::string>(),
              HasSubstr("receivers r0 and r4 of robot are exchanged"));
  EXPECT_FALSE(std::filesystem::exists(box / "d.json"));
}

TEST_F(Check, WithoutEpochsCalibrateSaysSo) {
  std::string text = slurp(hall("run/tof.csv"));
  spit(hall("run/tof.csv"), std::regex_replace(text, std::regex("^([^,]*,)(.*)epoch"), "$1$2colour"));
  const Outcome refused = octant(
      {"calibrate", hall("site.yaml"), hall("run"), "-o", box / "d.json", "--json", "--progress", "none"});
  EXPECT_EQ(refused.exit, 5) << refused.out;
  EXPECT_THAT(refused.json()["error"]["advice"].get<std::string>(), HasSubstr("column epoch"));
  EXPECT_THAT(refused.json()["error"]["message"].get<std::string>(),
              ::testing::Not(HasSubstr("approximate positions")));
  EXPECT_THAT(check().err, HasSubstr("column epoch"));
  EXPECT_EQ(check().exit, 5);
  EXPECT_THAT(check().out, HasSubstr("calibrate would refuse (exit 5)"));
}

TEST_F(Check, BeaconsThatLackTheSameAreTheWordsOfOneLine) {
  spit(hall("site.yaml"),
       std::regex_replace(slurp(hall("site.yaml")), std::regex("sigma_m: 0\\}"), "sigma_m: 0.3}"));
  const Outcome refused = check();
  ASSERT_EQ(refused.exit, 5) << refused.out << refused.err;
  EXPECT_THAT(refused.err,
              ::testing::ContainsRegex("beacons B0, B1, .*their positions are known to [0-9]+ mm( "
                                       "to [0-9]+ mm)? only, the tolerance is 30 mm"));
  EXPECT_THAT(refused.out, HasSubstr("weak             beacons B0, B1, "));
}

TEST_F(Check, UndeterminedIsExit5WithCalibratesWords) {
  rewrite([](auto& cells, const auto& header) { return std::stoi(cells[at(header, "epoch")]) < 2; });
  const Outcome calibrate = octant(
      {"calibrate", hall("site.yaml"), hall("run"), "-o", box / "d.json", "--json", "--progress", "none"});
  ASSERT_EQ(calibrate.exit, 5) << calibrate.out;
  const Outcome refused = check({"--json"});
  EXPECT_EQ(refused.exit, 5);
  const auto object = refused.json();
  EXPECT_EQ(object["status"], "undetermined");
  EXPECT_EQ(object["verdict"]["undetermined"], calibrate.json()["undetermined"]);
  EXPECT_EQ(object["verdict"]["weak"], calibrate.json()["weak"]);
  EXPECT_EQ(object["error"]["exit"], 5);
  EXPECT_THAT(check().out, HasSubstr("cannot determine what the site asks for"));
}

TEST_F(Check, BadInputAndWrongUsage) {
  EXPECT_EQ(octant({"check", box / "nowhere.yaml", hall("run"), "--json"}).exit, 3);
  EXPECT_EQ(octant({"check", hall("site.yaml"), box / "nowhere", "--json"}).exit, 3);
  EXPECT_EQ(octant({"check", hall("site.yaml")}).exit, 2);
  EXPECT_EQ(octant({"check"}).exit, 2);
}

}  // namespace check_test
}  // namespace octant::test
