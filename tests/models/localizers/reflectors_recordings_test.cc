// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Public recordings of bearings, stored next to the repository. Skipped if they are absent.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/run/run_folder.h"
#include "io/site/site_yaml.h"
#include "models/localizers/reflectors/reflectors.h"
#include "tests/support/worlds.h"

namespace octant {
namespace reflectors_recordings_test {

namespace fs = std::filesystem;
using test::must;

const fs::path kRecordings = fs::path(OCTANT_SOURCE_DIR) / ".." / "shared" / "datasets";

struct Outcome {
  int epochs = 0;
  std::map<FixStatus, int> status;
  std::vector<double> off_m;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double heading2 = 0.0;
  [[nodiscard]] int fixes() const { return static_cast<int>(off_m.size()); }
  [[nodiscard]] double rmse_m() const {
    double sum = 0.0;
    for (const double e : off_m) sum += e * e;
    return std::sqrt(sum / static_cast<double>(off_m.size()));
  }
  [[nodiscard]] double quantile_m(double q) const {
    auto sorted = off_m;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
  }
};

class BearingRecordings : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kRecordings)) GTEST_SKIP() << "no recordings beside the repository";
  }

  /// The site's landmarks at the places that reference.json gives, or its own; the calibration is not this
  /// test's subject.
  static Deployment deployment(const std::string& dataset, double bearing_sigma_rad) {
    const Site site = must(io::read_site((kRecordings / dataset / "site.yaml").string()));
    std::ifstream file(kRecordings / dataset / "reference.json");
    const nlohmann::json reference = nlohmann::json::parse(file);
    Deployment d;
    d.noise.bearing_sigma_rad = bearing_sigma_rad;
    d.vehicles = site.vehicles;
    for (const SiteReceiver& r : site.receivers)
      d.receivers.push_back({.name = r.name, .vehicle = r.vehicle, .axis = {}});
    for (const SiteBeacon& b : site.beacons) {
      DeploymentBeacon beacon;
      beacon.name = b.name;
      for (std::size_t i = 0; i < 3; ++i)
        beacon.position_m[static_cast<int>(i)] = b.position_m[i].value_or(0.0);
      if (reference.contains("beacons"))
        for (const auto& known : reference["beacons"])
          if (known["id"].get<std::string>() == b.name)
            for (std::size_t i = 0; i < 3; ++i)
              beacon.position_m[static_cast<int>(i)] = known["position_m"][i].get<double>();
      d.beacons.push_back(beacon);
    }
    return d;
  }

  static Outcome locate(const Deployment& d, const std::string& run, const ReflectorsOptions& options = {}) {
    const MeasurementLog log = must(io::read_run((kRecordings / run).string(), names_of(d), d.timing,
                                                 {.read_truth = true, .read_poses = false}));
    std::map<double, Pose> truth;
    for (const TimedPose& t : log.truth) truth[t.time_s] = t.T_map_vehicle;
    Outcome outcome;
    Reflectors localizer(d, options);
    for (std::size_t i = 0, j = 0; i < log.bearings.size(); i = j) {
      while (j < log.bearings.size() && log.bearings[j].epoch == log.bearings[i].epoch) ++j;
      const Fix fix = localizer.locate({{}, std::span(log.bearings).subspan(i, j - i)});
      ++outcome.epochs;
      ++outcome.status[fix.status];
      if (!fix.ok()) continue;
      const Pose& at = truth.at(fix.time_s);
      Eigen::Vector3d e = fix.T_map_vehicle.translation_m - at.translation_m;
      e.z() = wrap_angle(fix.T_map_vehicle.heading_rad() - at.heading_rad());
      outcome.off_m.push_back(e.head<2>().norm());
      outcome.mean += e;
      outcome.heading2 += e.z() * e.z();
    }
    outcome.mean /= outcome.fixes();
    std::cout << run << ": " << outcome.fixes() << " of " << outcome.epochs << " fixes, off "
              << outcome.mean.transpose() << ", RMSE " << outcome.rmse_m() << " m, median "
              << outcome.quantile_m(0.5) << ", 95 % " << outcome.quantile_m(0.95) << ", heading RMSE "
              << std::sqrt(outcome.heading2 / outcome.fixes()) << "\n";
    for (const auto& [status, count] : outcome.status)
      std::cout << "  " << to_string(status) << " " << count << "\n";
    return outcome;
  }
};

// Limits are ten per cent beyond the figures of an independent robust triangulation of each epoch: mean of
// the fixes off the truth, and with their scatter the RMSE. The bearings' errors are constant at each stand,
// several of their stated sigmas, and contradict each other: where two poses leave one of the four bearings
// out equally well, there is no fix.
TEST_F(BearingRecordings, Roh) {
  struct Stand {
    const char* run;
    double mean_m, rmse_m, heading_rad;
    int fixes;  // at least: the others are ambiguous
  };
  for (const Stand& stand :
       {Stand{"roh-x1.5/x1.5_y1.5", 0.079, std::hypot(0.079, 0.026, 0.021), 0.0112, 200},
        Stand{"roh-x1.5/x1.5_y3.0", 0.086, std::hypot(0.086, 0.023, 0.038), 0.0157, 180},
        Stand{"roh-x1.5/x1.5_y4.5", 0.104, std::hypot(0.104, 0.058, 0.089), -0.0779, 160}}) {
    const Outcome outcome = locate(deployment("roh-x1.5", 0.01), stand.run);
    EXPECT_GE(outcome.fixes(), stand.fixes);
    EXPECT_EQ(
        outcome.fixes() +
            (outcome.status.contains(FixStatus::kAmbiguous) ? outcome.status.at(FixStatus::kAmbiguous) : 0),
        200);
    EXPECT_LT(outcome.mean.head<2>().norm(), 1.1 * stand.mean_m);
    EXPECT_LT(outcome.rmse_m(), 1.1 * stand.rmse_m);
    EXPECT_NEAR(outcome.mean.z(), stand.heading_rad, 0.1 * std::abs(stand.heading_rad));
  }
}

// The independent solution has 0.102 m from arrivals and bearings together, with landmarks off by 0.07 m from
// calibration; here they stand where they were surveyed, and there are no arrivals. Cameras see three or four
// landmarks within a narrow field: some epochs determine the position to no metre.
TEST_F(BearingRecordings, Mrclam) {
  const Outcome outcome = locate(deployment("mrclam1", 0.01), "mrclam1/driven");
  EXPECT_EQ(outcome.epochs, 1957);
  EXPECT_GE(outcome.fixes(), 1900);
  EXPECT_LT(outcome.rmse_m(), 0.102);
  EXPECT_LT(std::sqrt(outcome.heading2 / outcome.fixes()), 0.0282);
}

}  // namespace reflectors_recordings_test
}  // namespace octant
