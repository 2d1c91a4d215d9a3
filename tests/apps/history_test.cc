// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// octant history as a process: output, simultaneous writers, killed writers.
#include <chrono>
#include <thread>

#include <gmock/gmock.h>

#include "io/deployment/deployment_json.h"
#include "io/history/sql.h"
#include "models/simulator/random.h"
#include "models/support/utc_time.h"
#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace history_test {

using ::testing::HasSubstr;

constexpr std::int64_t kFirstVisit_s = 1735689600, kMonth_s = 30 * 86400;

/// A folder with the deployments of a hall that was calibrated once a month; B1 drifts by a millimetre a
/// month, and B2 was hit at the seventh.
class HistoryFolder : public ::testing::Test {
 protected:
  static Deployment deployment_of(int month) {
    Random draws(static_cast<std::uint64_t>(month));
    Deployment d;
    d.site = "hall";
    d.created = utc_text(kFirstVisit_s + kMonth_s * month);
    d.medium = {MediumModel::kCramer1993, 343.0, 18.0 + month % 5, 0.5, 101325.0};
    d.speed_offset_mps = 0.4 + 0.02 * draws.normal();
    d.speed_sigma_mps = 0.02;
    d.timing.delay_per.beacon = true;
    d.tolerance.beacon_m = 0.03;
    d.statistics.converged = true;
    const auto place = [&](double x_m, double y_m) {
      return Eigen::Vector3d(x_m + 5e-4 * draws.normal(), y_m + 5e-4 * draws.normal(), 2.5);
    };
    const Eigen::Matrix3d covariance = Eigen::Vector3d(2.5e-7, 2.5e-7, 0.0).asDiagonal();
    d.beacons.push_back({.name = "B0",
                         .position_m = {0, 0, 2.5},
                         .delay_s = 1e-4,
                         .delay_sigma_s = 1e-6,
                         .status = BeaconStatus::kControlPoint});
    d.beacons.push_back({.name = "B1",
                         .position_m = place(10 + 1e-3 * month, 0),
                         .covariance_m2 = covariance,
                         .delay_s = 1e-4,
                         .delay_sigma_s = 1e-6});
    d.beacons.push_back({.name = "B2",
                         .position_m = place(10, month >= 7 ? 8.04 : 8.0),
                         .covariance_m2 = covariance,
                         .delay_s = 1e-4,
                         .delay_sigma_s = 1e-6});
    d.vehicles.push_back({"robot", 0, 1});
    d.receivers.push_back(
        {.name = "r0", .vehicle = VehicleId(0), .position_m = {0.1, 0, 0.3}, .axis = std::nullopt});
    d.covariance.matrix.resize(0, 0);
    return d;
  }
  std::string file(int month) const {
    const std::string path = box / ("d" + std::to_string(month) + ".json");
    if (!std::filesystem::exists(path)) spit(path, io::deployment_to_json(deployment_of(month)));
    return path;
  }
  [[nodiscard]] Outcome history(std::vector<std::string> words) const {
    words.insert(words.begin(), "history");
    words.insert(words.end(), {"--db", db});
    return octant(words);
  }
  void add_months(int months) const {
    std::vector<std::string> words = {"add"};
    for (int m = 0; m < months; ++m) words.push_back(file(m));
    const Outcome added = history(words);
    ASSERT_EQ(added.exit, 0) << added.err;
  }
  [[nodiscard]] std::size_t visits() const { return history({"list", "--json"}).json().at("visits").size(); }

  TemporaryFolder box;
  std::string db = box / "site.octant.db";
};

TEST_F(HistoryFolder, KeepsVisitsByDateWithWhoAndWhy) {
  const Outcome added =
      history({"add", file(3), file(1), "--operator", "Ada", "--note", "new bracket", "--json"});
  ASSERT_EQ(added.exit, 0) << added.err;
  EXPECT_EQ(added.json().at("added"), 2);
  const auto list = history({"list", "--json"}).json();
  ASSERT_EQ(list.at("visits").size(), 2u);
  const auto& first = list.at("visits").at(0);
  EXPECT_EQ(first.at("id"), 2);
  EXPECT_EQ(first.at("date"), utc_text(kFirstVisit_s + kMonth_s));
  EXPECT_EQ(first.at("operator"), "Ada");
  EXPECT_EQ(first.at("note"), "new bracket");
  EXPECT_EQ(first.at("kind"), "calibration");
  EXPECT_EQ(first.at("verdict"), "Good");
  const auto shown = history({"show", "2", "--json"}).json().at("visit");
  EXPECT_EQ(shown.at("document"), nlohmann::json::parse(slurp(file(1))));
  EXPECT_EQ(shown.at("beacons").size(), 3u);
  EXPECT_THAT(history({"list"}).out, HasSubstr("new bracket"));
  EXPECT_THAT(history({"show", "1"}).out, HasSubstr("B2"));
}

TEST_F(HistoryFolder, TheSameDeploymentTwiceIsOneVisit) {
  ASSERT_EQ(history({"add", file(1)}).exit, 0);
  // Equal content in another layout, under another name.
  spit(box / "copy.json", nlohmann::json::parse(slurp(file(1))).dump());
  const auto again = history({"add", box / "copy.json", file(1), "--json"}).json();
  EXPECT_EQ(again.at("added"), 0);
  EXPECT_EQ(again.at("visits").at(0).at("new"), false);
  EXPECT_EQ(visits(), 1u);
}

TEST_F(HistoryFolder, OneBadFileAddsNothing) {
  spit(box / "bad.json", R"({"status": "ok"})");
  const Outcome bad = history({"add", file(1), box / "bad.json"});
  EXPECT_EQ(bad.exit, 3);
  EXPECT_THAT(bad.err, HasSubstr("neither a deployment nor"));
  spit(box / "site.yaml", "octant_site: 1\n");
  EXPECT_THAT(history({"add", box / "site.yaml"}).err,
              HasSubstr("a site file; expected a deployment file, which octant calibrate makes"));
  EXPECT_FALSE(std::filesystem::exists(db));
}

TEST_F(HistoryFolder, RefusesWhatIsNotItsOwn) {
  EXPECT_EQ(history({"list"}).exit, 3);
  EXPECT_EQ(octant({"history"}).exit, 2);
  EXPECT_EQ(octant({"history", "forget"}).exit, 2);
  EXPECT_EQ(octant({"history", "add", file(1), "--db", file(1)}).exit, 2) << "the history over its own input";
  EXPECT_EQ(io::read_deployment(file(1)).has_value(), true);
  add_months(1);
  EXPECT_EQ(history({"export", "-o", db}).exit, 2);
  EXPECT_EQ(history({"export", "-o", box / "h.txt"}).exit, 2);
  std::filesystem::create_symlink(db, box / "link.csv");
  EXPECT_EQ(history({"export", "-o", box / "link.csv"}).exit, 2) << "through a link";
  EXPECT_EQ(history({"show", "9"}).exit, 3);
  EXPECT_EQ(history({"trend", "B9"}).exit, 3);
  EXPECT_EQ(history({"trend", "--site", "elsewhere"}).exit, 3);
  ASSERT_TRUE((*io::SqlStore::open(db, false))->run("PRAGMA user_version = 2"));
  const Outcome newer = history({"list"});
  EXPECT_EQ(newer.exit, 3);
  EXPECT_THAT(newer.err, HasSubstr("a newer octant wrote it"));
}

TEST_F(HistoryFolder, TrendNamesWhatMovedAndWhatDrifts) {
  add_months(14);
  const auto trend = history({"trend", "--json"}).json();
  ASSERT_EQ(trend.at("status"), "ok");
  EXPECT_EQ(trend.at("calibrations"), 14);
  EXPECT_EQ(trend.at("limit_m"), 0.03) << "the site's tolerance";
  std::vector<std::string> alarmed;
  for (const auto& chart : trend.at("charts")) {
    const std::string name =
        chart.at("subject").get<std::string>() + "/" + chart.at("quantity").get<std::string>();
    if (!chart.at("alarms").empty()) alarmed.push_back(name);
    if (name == "B2/y_m") {
      ASSERT_EQ(chart.at("alarms").size(), 1u);
      EXPECT_NEAR(chart.at("alarms").at(0).at("size").get<double>(), 0.04, 0.003);
      EXPECT_EQ(chart.at("alarms").at(0).at("since"), utc_text(kFirstVisit_s + 7 * kMonth_s));
    }
  }
  EXPECT_THAT(alarmed, ::testing::Contains("B2/y_m"));
  EXPECT_THAT(alarmed, ::testing::Not(::testing::Contains("B2/x_m")));
  EXPECT_EQ(trend.at("next").at("due").at("subject"), "B1");
  EXPECT_EQ(trend.at("next").at("due").at("quantity"), "x_m");
  // A millimetre a month, 30 mm: some 30 months after the last.
  const double due_s =
      static_cast<double>(utc_seconds(trend.at("next").at("due").at("date").get<std::string>()).value());
  EXPECT_NEAR((due_s - kFirstVisit_s) / kMonth_s, 13 + 30, 6);
  EXPECT_EQ(trend.at("speed").size(), 14u);
  const Outcome text = history({"trend"});
  EXPECT_THAT(text.out, HasSubstr("B2 y changed by"));
  EXPECT_THAT(text.out, HasSubstr("recalibrate by"));
  const Outcome one = history({"trend", "B2"});
  EXPECT_EQ(one.exit, 0);
  EXPECT_THAT(one.out, HasSubstr("!"));
}

TEST_F(HistoryFolder, ExportsAllOfIt) {
  add_months(2);
  ASSERT_EQ(history({"export", "-o", box / "h.csv"}).exit, 0);
  const std::string csv = slurp(box / "h.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 3);
  ASSERT_EQ(history({"export", "-o", box / "h.json"}).exit, 0);
  const auto json = nlohmann::json::parse(slurp(box / "h.json"));
  EXPECT_EQ(json.at("visits").at(1).at("document"), nlohmann::json::parse(slurp(file(1))));
  EXPECT_EQ(history({"export", "-o", "-"}).out, csv);
}

TEST_F(HistoryFolder, EightProgramsAtOnceLoseNothing) {
  constexpr int kWriters = 8, kEach = 6;
  for (int m = 0; m < kWriters * kEach; ++m) (void)file(m);
  std::vector<int> failed(kWriters, 0);
  std::vector<std::thread> writers;
  for (int w = 0; w < kWriters; ++w)
    writers.emplace_back([&, w] {
      for (int i = 0; i < kEach; ++i)
        failed[static_cast<std::size_t>(w)] += history({"add", file(w * kEach + i)}).exit != 0;
    });
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(std::count(failed.begin(), failed.end(), 0), kWriters);
  EXPECT_EQ(visits(), static_cast<std::size_t>(kWriters * kEach));
}

class KilledWriters : public HistoryFolder {
 protected:
  void expect_a_readable_history_after(int kills) {
    ASSERT_EQ(history({"add", file(0)}).exit, 0);
    const auto began = std::chrono::steady_clock::now();
    ASSERT_EQ(history({"add", file(1)}).exit, 0);
    const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    Random draws(1);
    std::size_t told = 2;
    for (int i = 0; i < kills; ++i)
      told += octant_killed({"history", "add", file(2 + i), "--db", db}, draws.uniform(0.0, 1.3 * whole_s));
    auto database = io::SqlStore::open(db, false);
    ASSERT_TRUE(database) << database.error().message();
    auto check = (*database)->prepare("PRAGMA integrity_check");
    ASSERT_TRUE(check && (*check)->next());
    EXPECT_EQ((*check)->text(0), "ok");
    // All confirmed additions are there; one that was killed between commit and its end may be there too.
    const std::size_t found = visits();
    EXPECT_GE(found, told);
    EXPECT_LE(found, told + static_cast<std::size_t>(kills));
    auto beacons = (*database)->prepare("SELECT count(*) FROM beacon");
    ASSERT_TRUE(beacons && (*beacons)->next());
    EXPECT_EQ((*beacons)->integer(0), static_cast<std::int64_t>(3 * found)) << "whole or not at all";
    EXPECT_EQ(history({"add", file(2 + kills)}).exit, 0) << "and it goes on";
  }
};

TEST_F(KilledWriters, LeaveAReadableHistory) { expect_a_readable_history_after(30); }
TEST_F(KilledWriters, DISABLED_TwoHundredLeaveAReadableHistory) { expect_a_readable_history_after(200); }

TEST_F(HallFolder, VerificationsGoIntoTheHistory) {
  ASSERT_EQ(calibrate().exit, 0);
  const Outcome verified = octant({"verify", out("d.json"), hall("heldout"), "--json"});
  ASSERT_EQ(verified.exit, 0) << verified.err;
  spit(out("v.json"), verified.out);
  const Outcome added =
      octant({"history", "add", out("d.json"), out("v.json"), "--db", out("h.db"), "--json"});
  ASSERT_EQ(added.exit, 0) << added.err;
  const auto visits = octant({"history", "list", "--db", out("h.db"), "--json"}).json().at("visits");
  ASSERT_EQ(visits.size(), 2u);
  for (const auto& v : visits) EXPECT_EQ(v.at("site"), "hall");
  EXPECT_EQ(visits.at(0).at("deployment_digest"), visits.at(1).at("deployment_digest"));
  EXPECT_EQ(visits.at(1).at("kind"), "verification");
}

TEST_F(HallFolder, LocalizeSaysWhereTheDeploymentDoesNotHold) {
  ASSERT_EQ(calibrate().exit, 0);
  const Outcome silent = octant({"localize", out("d.json"), hall("heldout"), "-o", out("f.tum"), "--json"});
  EXPECT_EQ(silent.json().at("assumed_temperature_degC"), 21.0);
  EXPECT_TRUE(silent.json().at("warnings").empty());
  EXPECT_THAT(silent.err, HasSubstr("no temperature is stated"));
  spit(hall("heldout/run.yaml"), slurp(hall("heldout/run.yaml")) + "\ntemperature_degC: 33.0\n");
  auto deployment = *io::read_deployment(out("d.json"));
  deployment.validity_area_m = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
  ASSERT_TRUE(io::write_deployment(out("small.json"), deployment));
  const Outcome outside =
      octant({"localize", out("small.json"), hall("heldout"), "-o", out("f.tum"), "--json"});
  EXPECT_EQ(outside.exit, 0) << outside.err;
  EXPECT_TRUE(outside.json().at("assumed_temperature_degC").is_null());
  const std::string warnings = outside.json().at("warnings").dump();
  EXPECT_THAT(warnings, HasSubstr("33.0 degC is far outside"));
  EXPECT_THAT(warnings, HasSubstr("outside the calibrated area"));
}

TEST_F(HallFolder, ACalibrationThatIsTooOldSaysSo) {
  spit(hall("site.yaml"), slurp(hall("site.yaml")) + "\nvalidity: {months: 12}\n");
  ASSERT_EQ(calibrate().exit, 0);
  const Outcome fresh = octant({"verify", out("d.json"), hall("heldout"), "--json"});
  EXPECT_EQ(fresh.json().at("calibration").at("overdue"), false);
  auto deployment = *io::read_deployment(out("d.json"));
  EXPECT_EQ(deployment.validity_period.months, 12.0);
  deployment.created = "2020-01-01T00:00:00Z";
  ASSERT_TRUE(io::write_deployment(out("old.json"), deployment));
  EXPECT_EQ(nlohmann::json::parse(slurp(out("old.json"))).at("validity").at("until"), "2020-12-31T06:43:12Z");
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"localize", out("old.json"), hall("heldout"), "-o", out("f.tum"), "--json"},
           {"verify", out("old.json"), hall("heldout"), "--json"},
           {"monitor", out("old.json"), hall("heldout"), "--json"}}) {
    const auto json = octant(words).json();
    EXPECT_EQ(json.at("calibration").at("due"), "2020-12-31T06:43:12Z") << words[0];
    EXPECT_EQ(json.at("calibration").at("overdue"), true) << words[0];
    EXPECT_THAT(json.at("warnings").dump(), HasSubstr("a recalibration is due since 2020-12-31")) << words[0];
  }
  const Outcome text = octant({"verify", out("old.json"), hall("heldout")});
  EXPECT_THAT(text.out, HasSubstr("recalibrate      by 2020-12-31 (12 months after the calibration"));
}

}  // namespace history_test
}  // namespace octant::test
