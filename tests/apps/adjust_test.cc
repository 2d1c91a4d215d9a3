// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant adjust: published networks with the results of GNU Gama 2.18.5 (tests/gama-local of its sources),
// and files that are refused.
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/apps/process.h"

namespace octant::test {
namespace adjust_test {

using ::testing::HasSubstr;

nlohmann::json adjusted(const std::string& network) {
  const Outcome outcome =
      octant({"adjust", std::string(OCTANT_SOURCE_DIR) + "/tests/golden/networks/" + network, "--json"});
  EXPECT_EQ(outcome.exit, 0) << outcome.err;
  return outcome.json();
}

/// Coordinates [m] and standard deviations [mm] of one point, to the digits that GNU Gama prints.
void expect_point(const nlohmann::json& result, std::size_t point, const std::vector<double>& position_m,
                  const std::vector<double>& variance_mm2) {
  const nlohmann::json& p = result.at("points").at(point);
  for (std::size_t i = 0; i < position_m.size(); ++i)
    EXPECT_NEAR(p.at("position_m").at(i).get<double>(), position_m[i], 1e-6) << p.at("id");
  for (std::size_t i = 0; i < variance_mm2.size(); ++i)
    EXPECT_NEAR(1e6 * std::pow(p.at("sigma_m").at(i).get<double>(), 2), variance_mm2[i],
                2e-5 * variance_mm2[i])
        << p.at("id");
}

TEST(Adjust, AgreesWithGamaInThePlane) {
  const nlohmann::json result = adjusted("ghilani_16_2.gkf");
  EXPECT_EQ(result.at("redundancy"), 12);
  EXPECT_NEAR(std::sqrt(result.at("variance_factor").get<double>()), 3.5261578e-01, 1e-6);
  // GNU Gama stops at the derivatives of the approximate coordinates: 3.06 m instead of 3.057 m east of Q.
  // The variance of R's x follows from the azimuth: (x / y)^2 var(y), plus the sigma of the azimuth across.
  const double x_m = 3.0571511051, y_m = 1640.0050759878, across_mm = 1e3 * y_m * 0.001 * M_PI / 648000.0;
  const double variance_mm2 = std::pow(x_m / y_m, 2) * 3.5675414e+01 + std::pow(across_mm * 0.35261578, 2);
  expect_point(result, 1, {1003.0571511051, 2640.0050759878}, {variance_mm2, 3.5675414e+01});
  expect_point(result, 2, {2323.0626484624, 2638.4742039682}, {3.0141441e+01, 4.3519328e+01});
  expect_point(result, 3, {2661.7386089226, 1096.0867085219}, {3.4818758e+01, 5.2881995e+01});
  const nlohmann::json& distance = result.at("observations").at(0);
  EXPECT_NEAR(distance.at("redundancy").get<double>(), 389.076 / (26.0 * 26.0), 1e-5);
  EXPECT_NEAR(distance.at("w").get<double>(), -1.161, 6e-4);
}

TEST(Adjust, AgreesWithGamaInAFreeNetwork) {
  const nlohmann::json result = adjusted("wolf_free.gkf");
  EXPECT_EQ(result.at("defect"), 3);
  EXPECT_THAT(result.at("datum").get<std::string>(), HasSubstr("inner constraints"));
  EXPECT_NEAR(result.at("variance_factor").get<double>(), std::pow(1.0202096e3 / 2500.0, 2), 1e-7);
  expect_point(result, 0, {184423.0335191526, 726419.6616475640}, {4.7641385e+02, 9.7161640e+02});
  expect_point(result, 8, {185963.2619484142, 723322.2793840811}, {});
}

TEST(Adjust, AgreesWithGamaInSpaceWithoutApproximateCoordinates) {
  const nlohmann::json result = adjusted("caspary_space.gkf");
  EXPECT_EQ(result.at("points").at(4).at("approximate_computed"), true);
  expect_point(result, 4, {5000.0148233706, 1999.9923351154, 1799.9868125315},
               {2.9567365e+02, 3.4429161e+02, 1.1902376e+03});
}

TEST(Adjust, AgreesWithGamaInCoordinatesWithCovariances) {
  const nlohmann::json result = adjusted("krumm_dynamic.gkf");
  EXPECT_EQ(result.at("redundancy"), 2);
  EXPECT_NEAR(result.at("variance_factor").get<double>(), std::pow(7.2564948e-04, 2), 1e-12);
  const std::vector<double> heights_m = {105.6363955224, 115.7072283582, 112.8826265672, 107.7541, 103.4535};
  const std::vector<double> variances_mm2 = {1.8469147e-01, 1.5325462e-01, 2.2996053e-01};
  for (std::size_t p = 0; p < heights_m.size(); ++p) {
    const nlohmann::json& point = result.at("points").at(p);
    EXPECT_NEAR(point.at("position_m").at(2).get<double>(), heights_m[p], 1e-6);
    if (p >= variances_mm2.size()) continue;
    EXPECT_NEAR(1e6 * std::pow(point.at("sigma_m").at(2).get<double>(), 2), variances_mm2[p],
                2e-5 * variances_mm2[p]);
  }
}

TEST(Adjust, AgreesWithGamaInHeightsOfInstrumentAndTarget) {
  expect_point(adjusted("baumann_space.gkf"), 3, {1181.7645205437, 1071.6795225922, 94.2598289267},
               {1.2085648e+01, 1.5669703e+01, 2.7710840e+01});
}

/// Coordinates and sigmas of a network after its conversion are those before.
TEST(Adjust, AgreesWithItselfAfterConversion) {
  const TemporaryFolder box;
  for (const std::string name :
       {"ghilani_16_2", "wolf_free", "caspary_space", "krumm_dynamic", "baumann_space"}) {
    const nlohmann::json before = adjusted(name + ".gkf");
    const std::string yaml = box / (name + ".yaml");
    const Outcome converted = octant(
        {"convert", std::string(OCTANT_SOURCE_DIR) + "/tests/golden/networks/" + name + ".gkf", "-o", yaml});
    ASSERT_EQ(converted.exit, 0) << converted.err;
    const Outcome outcome = octant({"adjust", yaml, "--json"});
    ASSERT_EQ(outcome.exit, 0) << outcome.err;
    const nlohmann::json after = outcome.json();
    EXPECT_EQ(after.at("redundancy"), before.at("redundancy"));
    EXPECT_EQ(after.at("datum"), before.at("datum"));
    EXPECT_NEAR(after.at("variance_factor").get<double>(), before.at("variance_factor").get<double>(), 1e-9);
    ASSERT_EQ(after.at("points").size(), before.at("points").size());
    for (std::size_t p = 0; p < before.at("points").size(); ++p)
      for (const char* key : {"position_m", "sigma_m"})
        for (std::size_t i = 0; i < 3; ++i) {
          const nlohmann::json &a = after.at("points").at(p).at(key).at(i),
                               &b = before.at("points").at(p).at(key).at(i);
          ASSERT_EQ(a.is_null(), b.is_null()) << name << p << key << i;
          if (!b.is_null()) EXPECT_NEAR(a.get<double>(), b.get<double>(), 1e-9) << name << p << key << i;
        }
  }
}

TEST(Adjust, NamesTheLineOfAnErrorInASurvey) {
  const TemporaryFolder box;
  spit(box / "s.yaml",
       "octant_survey: 1\npoints:\n  - {id: A}\ndistances:\n  - {from: A, to: X, slope_m: 3}\n");
  const Outcome o = octant({"adjust", box / "s.yaml", "--json"});
  EXPECT_EQ(o.exit, 3) << o.out;
  EXPECT_EQ(o.json().at("error").at("line"), 5);
}

class AdjustFile : public ::testing::Test {
 protected:
  Outcome adjust(const std::string& content, const std::string& before = "",
                 const std::string& axes = "axes-xy='en' angles='right-handed'") {
    spit(box / "n.gkf", before + "<gama-local><network " + axes + ">\n<points-observations>\n" + content +
                            "\n</points-observations></network></gama-local>\n");
    return octant({"adjust", box / "n.gkf", "--json"});
  }
  TemporaryFolder box;
  const std::string kFixed = "<point id='A' x='0' y='0' fix='xy'/><point id='B' x='100' y='0' fix='xy'/>\n";
};

TEST_F(AdjustFile, RefusesWhatItCannotUse) {
  const auto refused = [&](const Outcome& o, const std::string& words, int line) {
    EXPECT_EQ(o.exit, 3) << o.out;
    EXPECT_THAT(o.json().at("error").at("message").get<std::string>(), HasSubstr(words));
    if (line > 0) {
      EXPECT_EQ(o.json().at("error").at("line"), line) << o.out;
    }
  };
  refused(adjust("", "<!DOCTYPE a [<!ENTITY b SYSTEM '/etc/passwd'>]>"), "DOCTYPE", 1);
  refused(adjust("<point id='P' adj='xy'/>"), "without observations", 0);
  const std::string free = kFixed + "<point id='P' x='50' y='50' adj='xy'/>\n";
  refused(adjust(free + "<obs from='A'><distance to='P' val='70' stdev='0'/></obs>"), "standard deviation",
          5);
  refused(adjust(free + "<obs from='A'><distance to='P' val='70'/></obs>"), "without standard deviation", 5);
  refused(adjust(free + "<obs from='A'><distance to='P' val='7O' stdev='1'/></obs>"), "'7O'", 5);
  refused(adjust(free + "<obs from='A'><distance to='A' val='70' stdev='1'/></obs>"), "coincident", 5);
  refused(adjust(free + "<obs from='A'>\n<distance to='P' val='70'/><distance to='P' val='70'/>"
                        "<cov-mat dim='2' band='1'>1 2 1</cov-mat></obs>"),
          "not positive definite", 6);
  const Outcome open = adjust(free + "<obs from='A'><distance to='P' val='70' stdev='1'/></obs>");
  EXPECT_EQ(open.exit, 5) << open.out;
  EXPECT_THAT(open.json().at("error").at("message").get<std::string>(), HasSubstr("determine P"));
}

TEST_F(AdjustFile, LeavesOutWhatIsNotDetermined) {
  const std::string points = kFixed + "<point id='P' x='60' y='80' adj='xy'/><point id='Q' adj='xy'/>" +
                             "<point id='R' x='50' y='50' adj='xy'/>\n";
  const Outcome o =
      adjust(points + "<obs from='A'><distance to='P' val='100' stdev='1'/>" +
             "<distance to='Q' val='50' stdev='1'/><distance to='R' val='70' stdev='1'/></obs>" +
             "<obs from='B'><distance to='P' val='89.4427191' stdev='1'/>" +
             "<distance to='P' val='88.2' stdev='1'/></obs>");
  ASSERT_EQ(o.exit, 0) << o.out;
  const nlohmann::json result = o.json();
  EXPECT_NEAR(result.at("points").at(2).at("position_m").at(0).get<double>(), 60.0, 1e-6);
  EXPECT_EQ(result.at("points").at(3).at("position_m").at(0), nullptr);
  EXPECT_EQ(result.at("points").at(4).at("position_m").at(0), nullptr);
  EXPECT_THAT(o.err, HasSubstr("do not locate (give coordinates or add observations): Q."));
  EXPECT_THAT(o.err, HasSubstr("do not determine: R."));
  EXPECT_THAT(o.err, HasSubstr("horizontal distance B P (line 5) is left out"));
}

/// P is at (60, 80): 100 m from A, 89.443 m from B. From A it is 59.0334 gon counter-clockwise from B.
TEST_F(AdjustFile, ComputesApproximateCoordinatesInAllOrientationsOfAxes) {
  for (const std::string axes : {"en", "nw", "se", "ws", "ne", "sw", "es", "wn"})
    for (const std::string angles : {"left-handed", "right-handed"}) {
      const bool clockwise = axes == "ne" || axes == "sw" || axes == "es" || axes == "wn";
      const std::string turn = clockwise == (angles == "left-handed") ? "59.0334470602" : "340.9665529398";
      const Outcome o =
          adjust(kFixed + "<point id='P' adj='xy'/><obs from='A'><direction to='B' val='0' stdev='10'/>" +
                     "<direction to='P' val='" + turn + "' stdev='10'/>" +
                     "<distance to='P' val='100' stdev='1'/></obs>",
                 "", "axes-xy='" + axes + "' angles='" + angles + "'");
      ASSERT_EQ(o.exit, 0) << o.out;
      const nlohmann::json p = o.json().at("points").at(2).at("position_m");
      EXPECT_NEAR(p.at(0).get<double>(), 60.0, 1e-6) << axes << angles;
      EXPECT_NEAR(p.at(1).get<double>(), 80.0, 1e-6) << axes << angles;
    }
}

/// Beacons at the corners of a hall and in its middle, three of them known, from exact ranges but one.
TEST(Adjust, FindsBeaconsFromRangesBetweenThemAlone) {
  const std::vector<std::array<double, 3>> places = {{0, 0, 3},  {20, 0, 3},  {20, 12, 4}, {0, 12, 3},
                                                     {10, 5, 4}, {10, -1, 3}, {5, 13, 4},  {21, 6, 3}};
  std::string site =
                  "octant_site: 1\nname: hall\nmotion: planar\nmedium: {model: constant, speed_mps: 3e8, "
                  "sigma_mps: 0}\ntiming: {delay_per: none}\nnoise: {tof_sigma_s: 1e-10}\nbeacons:\n",
              rows = "time_s,beacon_from,beacon_to,tof_s\n";
  for (std::size_t a = 0; a < places.size(); ++a) {
    const auto& [x, y, z] = places[a];
    site += a < 3 ? fmt::format("  - {{id: B{}, position_m: [{}, {}, {}], sigma_m: 0}}\n", a, x, y, z)
                  : fmt::format("  - {{id: B{}, position_m: [null, null, {}], sigma_m: [null, null, 0]}}\n",
                                a, z);
    for (std::size_t b = a + 1; b < places.size(); ++b) {
      const double length_m = std::hypot(x - places[b][0], y - places[b][1], z - places[b][2]);
      const double echo_m = a == 3 && b == 6 ? 4.0 : 0.001 * std::sin(10.0 * static_cast<double>(a + 7 * b));
      rows += fmt::format("0,B{},B{},{}\n", a, b, (length_m + echo_m) / 3e8);
    }
  }
  site += "vehicles: [{id: robot, receivers: [{id: r, position_m: [0, 0, 0]}]}]\n";
  const TemporaryFolder box;
  std::filesystem::create_directory(box.path() / "run");
  spit(box / "site.yaml", site);
  spit(box / "run/beacon_tof.csv", rows);
  const Outcome o = octant({"adjust", box / "site.yaml", box / "run", "--json"});
  ASSERT_EQ(o.exit, 0) << o.out;
  for (std::size_t p = 0; p < places.size(); ++p)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(o.json().at("points").at(p).at("position_m").at(i).get<double>(), places[p][i], 0.005) << p;
  EXPECT_THAT(o.err, HasSubstr("The slope distance B3 B6 is left out"));
}

}  // namespace adjust_test
}  // namespace octant::test
