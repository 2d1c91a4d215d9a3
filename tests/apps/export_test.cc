// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Runs and fixes for other programs, and back.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace export_test {

using ::testing::HasSubstr;

class Export : public HallFolder {
 protected:
  void SetUp() override {
    make(20);
    ASSERT_EQ(calibrate().exit, 0);
    ASSERT_EQ(octant({"localize", out("d.json"), hall("heldout"), "-o", out("fixes.tum"), "--csv",
                      out("fixes.csv")})
                  .exit,
              0);
  }
};

TEST_F(Export, ARunComesBackFromMcapAsItWas) {
  const Outcome done =
      octant({"export", out("d.json"), hall("heldout"), out("fixes.csv"), "-o", out("hall.mcap"), "--json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.json()["beacons"], 8);
  const Outcome back = octant({"convert", out("hall.mcap"), "-o", out("back"), "--json"});
  ASSERT_EQ(back.exit, 0) << back.err;
  EXPECT_EQ(back.json()["format"], "bag");
  EXPECT_EQ(back.json()["arrivals"], done.json()["arrivals"]);
  for (const char* file : {"/tof.csv", "/truth.tum"})
    EXPECT_EQ(slurp(out("back") + file), slurp(hall("heldout") + file)) << file;
  const Outcome as = octant({"verify", out("d.json"), out("back"), "--json"}),
                were = octant({"verify", out("d.json"), hall("heldout"), "--json"});
  EXPECT_EQ(as.json()["position_rmse_m"], were.json()["position_rmse_m"]);

  const Outcome without =
      octant({"convert", out("hall.mcap"), "-o", out("less"), "--ignore", "B1,B2", "--json"});
  ASSERT_EQ(without.exit, 0) << without.err;
  EXPECT_GT(without.json()["ignored"], 0);
  EXPECT_THAT(without.err, HasSubstr("rows of beacon 'B1', which is ignored"));
  EXPECT_EQ(slurp(out("less") + "/tof.csv").find(",B1,"), std::string::npos);
}

TEST_F(Export, MapsAndTrajectories) {
  ASSERT_EQ(octant({"export", out("d.json"), out("fixes.csv"), "-o", out("hall.geojson"), "--origin",
                    "52.5,13.4,35"})
                .exit,
            0);
  EXPECT_THAT(slurp(out("hall.geojson")), HasSubstr("\"FeatureCollection\""));
  const Outcome nowhere = octant({"export", out("d.json"), "-o", out("hall.geojson")});
  EXPECT_EQ(nowhere.exit, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("--origin LATITUDE,LONGITUDE"));
  ASSERT_EQ(octant({"export", out("fixes.tum"), "-o", out("again.tum")}).exit, 0);
  EXPECT_EQ(slurp(out("again.tum")), slurp(out("fixes.tum")));
  EXPECT_EQ(octant({"export", out("d.json"), "-o", out("hall.kml")}).exit, 2);
  EXPECT_EQ(octant({"export", out("d.json"), "-o", out("none.tum")}).exit, 2);
  EXPECT_EQ(octant({"export", box / "no_such_run", "-o", out("x.mcap")}).exit, 3);
  EXPECT_FALSE(std::filesystem::exists(out("x.mcap")));
}

// evo and others that read the format are strict: eight numbers with one blank between, no blank at the end,
// comments whole lines alone, times that ascend, quaternions of length one.
TEST_F(Export, FixesAreATrackForReadersThatAreStrict) {
  ASSERT_EQ(octant({"export", hall("heldout"), "-o", out("truth.tum")}).exit, 0);
  for (const std::string& file : {out("fixes.tum"), out("truth.tum")}) {
    std::istringstream text(slurp(file));
    double last_s = -HUGE_VAL;
    std::size_t rows = 0;
    for (std::string line; std::getline(text, line);) {
      if (line.starts_with('#')) continue;
      ASSERT_EQ(std::count(line.begin(), line.end(), ' '), 7) << file << ": " << line;
      std::array<double, 8> values{};
      const char* at = line.data();
      const char* const end = line.data() + line.size();
      for (double& value : values) {
        const auto [stop, wrong] = std::from_chars(at, end, value);
        ASSERT_TRUE(wrong == std::errc{} && (stop == end) == (&value == &values.back()))
            << file << ": " << line;
        at = stop + 1;
      }
      EXPECT_GT(values[0], last_s) << file;
      EXPECT_NEAR(std::hypot(std::hypot(values[4], values[5]), std::hypot(values[6], values[7])), 1.0, 1e-9);
      last_s = values[0];
      ++rows;
    }
    EXPECT_GT(rows, 20u) << file;
  }
}

TEST_F(Export, AKitsLogBecomesARun) {
  spit(box / "dwm.log",
       "10.0 DIST,2,AN0,1151,5.00,8.00,2.25,6.50,AN1,0CA8,0.00,8.00,2.25,8.00,POS,3.1,4.2,1.9,98\n");
  const Outcome done = octant(
      {"convert", box / "dwm.log", "--format", "dwm1001", "-o", out("dwm"), "--speed-mps", "268435456"});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(slurp(out("dwm") + "/tof.csv"),
            "time_s,beacon,tof_s\n10,1151,2.421438694000244e-08\n10,0CA8,2.9802322387695312e-08\n");
  EXPECT_EQ(octant({"convert", box / "dwm.log", "--format", "marvelmind", "-o", out("none")}).exit, 3);
  EXPECT_FALSE(std::filesystem::exists(out("none")));
  const Outcome bag = octant({"convert", out("d.json"), "--topics", "range=/r", "-o", out("none")});
  EXPECT_EQ(bag.exit, 2);
  EXPECT_THAT(bag.err, HasSubstr("does not say of which beacon"));
}

}  // namespace export_test
}  // namespace octant::test
