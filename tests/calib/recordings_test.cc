// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Public recordings, stored next to the repository, compared with an independent solution of each. Skipped if
// they are absent.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "io/run/run_folder.h"
#include "io/site/site_yaml.h"
#include "models/localizers/drive/tracker.h"
#include "models/localizers/least_squares/epoch_fix.h"
#include "survey/evaluate.h"
#include "tests/calib/calib_support.h"

namespace octant::test {
namespace recordings_test {

namespace fs = std::filesystem;
using calib::SolveStatus;

const fs::path kRecordings = fs::path(OCTANT_SOURCE_DIR) / ".." / "shared" / "datasets";

struct Recording {
  Site site;
  calib::Problem problem;
  calib::Solution solution;
  Deployment deployment;
};

class Recordings : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kRecordings)) GTEST_SKIP() << "no recordings beside the repository";
  }

  static Recording calibrate(const std::string& dataset, const std::string& run,
                             const std::string& site_file = "site.yaml") {
    return calibrate(must(io::read_site((kRecordings / dataset / site_file).string())),
                     {dataset + "/" + run});
  }
  static Recording calibrate(const Site& site, const std::vector<std::string>& runs) {
    Recording r;
    r.site = site;
    std::vector<MeasurementLog> logs;
    for (const std::string& run : runs)
      logs.push_back(must(io::read_run((kRecordings / run).string(), names_of(site), site.timing)));
    r.problem = must(calib::make_problem(r.site, std::move(logs)));
    r.solution = calib::solve(r.problem);
    if (r.solution.status == SolveStatus::kConverged)
      r.deployment = calib::make_deployment(r.problem, r.solution, {});
    return r;
  }

  static survey::Evaluation locate(const Recording& r, const std::string& run, bool bearings = true) {
    MeasurementLog log = must(io::read_run((kRecordings / run).string(), names_of(r.deployment),
                                           r.deployment.timing, {.read_truth = true, .read_poses = false}));
    if (!bearings) log.bearings.clear();
    const std::vector<Fix> fixes =
        log.has_epochs ? LeastSquaresLocalizer(r.deployment).locate(log) : track(log, r.deployment);
    return survey::evaluate(fixes, log.truth, log.truth_accuracy, r.deployment.motion,
                            r.deployment.tolerance);
  }

  /// Distances of the beacons from their survey, ascending; after a rigid motion in the plane where the frame
  /// is free.
  static std::vector<double> off_reference(const Recording& r, const std::string& dataset,
                                           bool align = false) {
    std::ifstream file(kRecordings / dataset / "reference.json");
    const nlohmann::json reference = nlohmann::json::parse(file);
    Eigen::Matrix3Xd found(3, 0), truth(3, 0);
    for (const auto& b : reference["beacons"]) {
      for (std::size_t i = 0; i < r.site.beacons.size(); ++i) {
        if (r.site.beacons[i].name != b["id"].get<std::string>() ||
            r.solution.beacon_status[i] == BeaconStatus::kUndetermined)
          continue;
        found.conservativeResize(3, found.cols() + 1);
        truth.conservativeResize(3, truth.cols() + 1);
        found.col(found.cols() - 1) = r.solution.state.beacon_p_map_m[i];
        for (int k = 0; k < 3; ++k)
          truth(k, truth.cols() - 1) = b["position_m"][static_cast<std::size_t>(k)].get<double>();
      }
    }
    if (align) {
      const Eigen::Matrix3d T = Eigen::umeyama(found.topRows(2), truth.topRows(2), false);
      for (Eigen::Index i = 0; i < found.cols(); ++i)
        found.col(i).head<2>() = (T * found.col(i).head<2>().homogeneous()).head<2>().eval();
    }
    std::vector<double> off;
    for (Eigen::Index i = 0; i < found.cols(); ++i) off.push_back((found.col(i) - truth.col(i)).norm());
    std::sort(off.begin(), off.end());
    return off;
  }
  static double median(const std::vector<double>& sorted) {
    return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
  }
  static double speed(const Recording& r) {
    return speed_mps(r.site.medium) + r.solution.state.speed_offset_mps[0];
  }
};

// Limits below are those that the independent solution states, or ten per cent beyond its figures.

TEST_F(Recordings, Plaza1) {
  const Recording r = calibrate("plaza1", "surveyed");
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  EXPECT_NEAR(speed(r), 2.8016e8, 0.004 * 2.8016e8);
  const auto off = off_reference(r, "plaza1");
  EXPECT_LT(off.back(), 0.24);
  EXPECT_LT(median(off), 0.18);
  EXPECT_LT(locate(r, "plaza1/driven").position_rmse_m, 0.245);
}

TEST_F(Recordings, Plaza1FromOdometryAlone) {
  Site site = must(io::read_site((kRecordings / "plaza1/site.yaml").string()));
  for (SiteBeacon& b : site.beacons)
    b.position_m[0] = b.position_m[1] = b.sigma_m[0] = b.sigma_m[1] = std::nullopt;
  const Recording r = calibrate(site, {"plaza1/driven"});
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  EXPECT_LT(off_reference(r, "plaza1", true).back(), 0.5);
  EXPECT_THAT(r.solution.datum.description, testing::HasSubstr("inner constraints"));
}

TEST_F(Recordings, Garpos) {
  const Recording r = calibrate("garpos-1903", "surveyed");
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  EXPECT_NEAR(speed(r), 1488.804, 1.0);
  EXPECT_LT(r.solution.statistics.rms_s, 1.05e-4);
  EXPECT_LT(off_reference(r, "garpos-1903").back(), 0.44);
}

TEST_F(Recordings, LiasFast) {
  const Recording r = calibrate("lias-fast", "surveyed");
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  EXPECT_LT(median(off_reference(r, "lias-fast")), 0.10);
  EXPECT_LT(locate(r, "lias-fast/driven").position_rmse_m, 0.031);
  // Errors of a position and a pair: a program that ignores them reports too small sigmas.
  EXPECT_THAT(r.solution.warnings, testing::Contains(testing::HasSubstr("errors are correlated")));
}

TEST_F(Recordings, LiasStatic) {
  const Recording r = calibrate("lias-static-0814", "static");
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  std::ifstream file(kRecordings / "lias-static-0814/reference.json");
  const nlohmann::json reference = nlohmann::json::parse(file);
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d truth(reference["receivers"][i]["position_m"][0].get<double>(),
                                reference["receivers"][i]["position_m"][1].get<double>());
    EXPECT_LT((r.solution.state.receiver_p_vehicle_m[i].head<2>() - truth).norm(), 0.05);
  }
  EXPECT_LT(locate(r, "lias-static-0814/fix").position_rmse_m, 0.0245);
}

TEST_F(Recordings, Dechorate) {
  const Recording r = calibrate("dechorate", "static");
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  EXPECT_NEAR(speed(r), 346.46, 0.005 * 346.46);
  EXPECT_LT(off_reference(r, "dechorate").back(), 0.13);
}

TEST_F(Recordings, Labyrinth) {
  const Recording r = calibrate("labyrinth", "surveyed");
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  EXPECT_LT(off_reference(r, "labyrinth").back(), 0.237);
  EXPECT_LT(locate(r, "labyrinth/driven").position_rmse_m, 0.142);
}

TEST_F(Recordings, Mrclam) {
  const Recording r = calibrate("mrclam1", "surveyed", "site-all-landmarks.yaml");
  ASSERT_EQ(r.solution.status, SolveStatus::kConverged) << r.solution.message;
  EXPECT_LT(off_reference(r, "mrclam1").back(), 0.127);
  for (std::size_t b = 0; b < r.site.beacons.size(); ++b)
    if (r.site.beacons[b].name == "L2") EXPECT_EQ(r.solution.beacon_status[b], BeaconStatus::kUndetermined);
  EXPECT_LT(locate(r, "mrclam1/driven").position_rmse_m, 0.112);
}

TEST_F(Recordings, ADelayThatTheDataDoNotSupportLeavesTheBeacons) {
  Site site = must(io::read_site((kRecordings / "plaza1/site.yaml").string()));
  const Recording with = calibrate(site, {"plaza1/surveyed"});
  site.timing.delay_per = {};
  site.timing.delay_sigma_s = 0.0;
  const Recording without = calibrate(site, {"plaza1/surveyed"});
  for (std::size_t b = 0; b < 4; ++b)
    EXPECT_LT((with.solution.state.beacon_p_map_m[b] - without.solution.state.beacon_p_map_m[b]).norm(), 0.2);
}

/// A table of measurements over taped distances: the pair's delay, scale and attenuation, as one beacon and
/// measured poses.
TEST_F(Recordings, HyuStatic) {
  std::ifstream table(kRecordings / "hyu-static" / "static_los.csv");
  if (!table) GTEST_SKIP() << "no hyu-static beside the repository";
  Site site;
  site.motion = Motion::kPlanar;
  site.medium.model = MediumModel::kConstant;
  site.medium.speed_mps = 299792458.0;
  site.speed_sigma_mps = 3e7;
  site.timing.delay_per.site = true;
  site.timing.delay_sigma_s = 2e-9;
  site.noise.tof_sigma_s = 2e-10;
  site.noise.amplitude_relative_sigma = 0.42;  // the scatter stated there, 3.67 dB
  site.attenuation = AttenuationPrior{.amplitude_1m_v = {2e-4, 2e-4},
                                      .absorption_np_per_m = {0.0, 0.1},
                                      .rise_time_s = {0.0, 0.0},
                                      .threshold_v = 0.0};
  site.beacons.push_back(beacon("B", {0, 0, 0}, 0.0));
  add_receivers(site, {Eigen::Vector3d::Zero()});
  MeasurementLog log;
  log.vehicle = VehicleId(std::size_t{0});
  log.has_epochs = true;
  log.pose_accuracy = {.position_sigma_m = 0.0, .heading_sigma_rad = 0.0};
  std::string line, last;
  std::getline(table, line);
  double time_s = 0.0;
  while (std::getline(table, line)) {
    double field[6] = {};
    for (std::size_t i = 0, at = 0; i < 6; ++i, at = line.find(',', at) + 1)
      field[i] = std::stod(line.substr(at));
    const std::string place = line.substr(0, line.find(',', line.find(',') + 1));
    time_s += place == last ? 1e-3 : 10.0;
    if (place != last) log.poses.push_back({time_s, Pose::planar(field[0], 0.0, 0.0)});
    last = place;
    Arrival a;
    a.time_s = log.poses.back().time_s;
    a.tof_s = field[2];
    a.amplitude_v = field[5];
    a.beacon = BeaconId(std::size_t{0});
    a.receiver = ReceiverId(std::size_t{0});
    a.vehicle = log.vehicle;
    a.epoch = static_cast<std::int64_t>(log.poses.size());
    log.arrivals.push_back(a);
  }
  ASSERT_GT(log.arrivals.size(), 30000U);
  const calib::Problem problem = must(calib::make_problem(site, {log}));
  const calib::Solution solution = calib::solve(problem);
  ASSERT_EQ(solution.status, SolveStatus::kConverged) << solution.message;
  // range = s distance + o with s 1.00407, o 0.0999 m, and A = 1.5553e-4 V, a = -0.02790 Np/m. Octant's is a
  // least-squares fit of the measurements within four sigmas, the reference a robust one of all: tolerance of
  // a tenth of the residual sigma (0.05 m) in the offset, and that over 60 m in the scale.
  const double speed_mps = 299792458.0 + solution.state.speed_offset_mps[0];
  EXPECT_NEAR(299792458.0 / speed_mps, 1.00407, 0.001);
  EXPECT_NEAR(299792458.0 * solution.state.site_delay_s, 0.0999, 0.03);
  EXPECT_NEAR(solution.state.attenuation->amplitude_1m_v, 1.5553e-4, 0.05 * 1.5553e-4);
  EXPECT_NEAR(solution.state.attenuation->absorption_np_per_m, -0.02790, 0.002);
}

}  // namespace recordings_test
}  // namespace octant::test
