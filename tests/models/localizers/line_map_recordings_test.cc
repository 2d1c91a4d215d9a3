// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Public recordings of laser scans in buildings, stored next to the repository. Skipped if they are absent.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "io/run/run_folder.h"
#include "io/site/site_yaml.h"
#include "models/localizers/line_map/line_map_localizer.h"
#include "tests/support/worlds.h"

namespace octant {
namespace line_map_recordings_test {

namespace fs = std::filesystem;
using test::must;

const fs::path kRecordings = fs::path(OCTANT_SOURCE_DIR) / ".." / "shared" / "datasets";

struct Outcome {
  double rmse_m = 0.0, median_m = 0.0, p95_m = 0.0, max_m = 0.0, heading_rad = 0.0, nees = 0.0;
  std::size_t ok = 0;
};

/// The stored map is built from every second scan, at its reference pose; the other scans are located on it,
/// from the first one's reference pose on, with the raw odometry. No scan is both on the map and located.
class ScanRecordings : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kRecordings)) GTEST_SKIP() << "no recordings beside the repository";
  }

  static Outcome judge(const std::vector<Fix>& fixes, const std::map<double, Pose>& truth) {
    Outcome o;
    std::vector<double> off;
    for (const Fix& fix : fixes) {
      o.ok += fix.ok();
      Eigen::Vector3d e = fix.T_map_vehicle.translation_m - truth.at(fix.time_s).translation_m;
      e.z() = wrap_angle(fix.T_map_vehicle.heading_rad() - truth.at(fix.time_s).heading_rad());
      off.push_back(e.head<2>().norm());
      o.rmse_m += e.head<2>().squaredNorm();
      o.heading_rad += e.z() * e.z();
      o.nees += e.dot(Eigen::Matrix3d(fix.covariance).inverse() * e) / 3;
    }
    const auto n = static_cast<double>(off.size());
    std::sort(off.begin(), off.end());
    o.rmse_m = std::sqrt(o.rmse_m / n);
    o.heading_rad = std::sqrt(o.heading_rad / n);
    o.nees /= n;
    o.median_m = off[off.size() / 2];
    o.p95_m = off[off.size() * 95 / 100];
    o.max_m = off.back();
    return o;
  }

  /// With the map, and odometry alone.
  static std::pair<Outcome, Outcome> run(const std::string& dataset) {
    const Site site = must(io::read_site((kRecordings / dataset / "site.yaml").string()));
    const MeasurementLog log = must(io::read_run((kRecordings / dataset / "driven").string(), names_of(site),
                                                 site.timing, {.read_truth = true}));
    std::map<double, Pose> truth;
    for (const TimedPose& t : log.truth) truth[t.time_s] = t.T_map_vehicle;
    LineMapOptions options;
    options.scan.range_max_m = 40.0;  // longer ones in these logs saw nothing, or next to it
    std::vector<Scan> mapped, located;
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < log.scans.size(); ++i) {
      if (i % 2 == 0) {
        mapped.push_back(log.scans[i]);
        poses.push_back(truth.at(log.scans[i].time_s));
      } else {
        located.push_back(log.scans[i]);
      }
    }
    const TimedPose start{located[0].time_s, truth.at(located[0].time_s)};
    const PoseAccuracy accuracy{.position_sigma_m = 0.02, .heading_sigma_rad = 0.01};
    const LineMap map = build_line_map(mapped, poses, options);
    const Outcome with = judge(
        LineMapLocalizer(map, options).locate(located, log.odometry, log.odometry_accuracy, start, accuracy),
        truth);
    const Outcome without = judge(LineMapLocalizer(LineMap{}, options)
                                      .locate(located, log.odometry, log.odometry_accuracy, start, accuracy),
                                  truth);
    std::cout << dataset << ": " << map.lines.size() << " walls, " << located.size() << " scans, " << with.ok
              << " ok; RMSE " << with.rmse_m << " m (odometry alone " << without.rmse_m << "), median "
              << with.median_m << ", 95 % " << with.p95_m << ", largest " << with.max_m << ", heading RMSE "
              << with.heading_rad << ", NEES " << with.nees << "\n";
    return {with, without};
  }
};

// The reference is a mapping program's result, accurate to some centimetres; odometry alone has errors of
// 9.9, 25.8 and 9.3 m (EXPECTED.md). Limits: a median of a tenth of a metre (scans were matched to 0.03 m
// against the reference by an independent program), and a fiftieth of odometry's error, or a thirtieth along
// the corridor, where over long distances no wall determines the position along it.
TEST_F(ScanRecordings, Aces) {
  const auto [with, without] = run("carmen-aces");
  EXPECT_NEAR(without.rmse_m, 9.90, 0.1 * 9.90);
  EXPECT_LT(with.median_m, 0.1);
  EXPECT_LT(with.rmse_m, without.rmse_m / 50);
  EXPECT_LT(with.nees, 2.0);
}

TEST_F(ScanRecordings, Intel) {
  const auto [with, without] = run("carmen-intel");
  EXPECT_NEAR(without.rmse_m, 25.81, 0.1 * 25.81);
  EXPECT_LT(with.median_m, 0.1);
  EXPECT_LT(with.rmse_m, without.rmse_m / 50);
  EXPECT_LT(with.nees, 2.0);
}

TEST_F(ScanRecordings, InfiniteCorridor) {
  const auto [with, without] = run("carmen-infinite-corridor");
  EXPECT_NEAR(without.rmse_m, 9.32, 0.1 * 9.32);
  EXPECT_LT(with.median_m, 0.1);
  EXPECT_LT(with.rmse_m, without.rmse_m / 30);
  EXPECT_LT(with.nees, 2.0);
}

}  // namespace line_map_recordings_test
}  // namespace octant
