// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/history.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>

#include <nlohmann/json.hpp>

#include "io/deployment/deployment_json.h"
#include "io/history/sql.h"
#include "models/support/utc_time.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace history_test {

using test::expect_error;
using test::TemporaryFolder;

Deployment hall_of(int day, const std::string& site = "hall") {
  Deployment d;
  d.site = site;
  d.created = utc_text(1767312000 + 86400LL * day);
  d.medium = {MediumModel::kCramer1993, 343.0, 21.0, 0.5, 101325.0};
  d.speed_offset_mps = 0.25 + 0.01 * day;
  d.speed_sigma_mps = 0.02;
  d.validity_temperature_degC = {18.5, 21.5};
  d.program_version = "0.1.0";
  d.beacons.push_back({.name = "B0", .position_m = {1, 2, 3}, .status = BeaconStatus::kControlPoint});
  d.beacons.push_back({.name = "B1",
                       .position_m = {4, 5, 6 + 0.001 * day},
                       .covariance_m2 = 1e-6 * Eigen::Matrix3d::Identity(),
                       .delay_s = 1e-4,
                       .delay_sigma_s = 1e-6});
  d.vehicles.push_back({"robot", 0, 1});
  d.receivers.push_back(
      {.name = "r0", .vehicle = VehicleId(0), .position_m = {0.1, 0, 0.3}, .axis = std::nullopt});
  d.covariance.matrix.resize(0, 0);
  return d;
}

Visit visit_on(int day, const std::string& site = "hall") {
  auto visit = visit_of(deployment_to_json(hall_of(day, site)), "deployment.json");
  EXPECT_TRUE(visit) << visit.error().message();
  visit->verdict = "Good";
  visit->who = "Ada";
  return *visit;
}

constexpr const char* kVerification =
    R"({"status": "gate_failed", "kind": "verification", "site": "hall", "created": "2026-03-04T05:06:07Z", "deployment": {"path": "d.json", "digest": "ab12"},
"temperature_degC": [17, 19.5], "program": {"name": "octant", "version": "0.1.0"}, "matched": 40})";

TEST(Visit, OfADeploymentHasItsConditions) {
  const Visit v = visit_on(3);
  EXPECT_EQ(v.kind, VisitKind::kCalibration);
  EXPECT_EQ(v.site, "hall");
  EXPECT_EQ(utc_text(v.happened_s), "2026-01-05T00:00:00Z");
  EXPECT_EQ(v.temperature_degC.value()[1], 21.5);
  EXPECT_NEAR(v.speed.value().offset_mps, 0.28, 1e-12);
  EXPECT_EQ(v.beacons.at(1).sigma_m.z(), 1e-3);
  EXPECT_EQ(v.beacons.at(0).status, BeaconStatus::kControlPoint);
  EXPECT_EQ(v.digest.size(), 64u);
  EXPECT_EQ(v.digest, v.deployment_digest);
}

TEST(Visit, LayoutOfTheFileDoesNotMatterToItsDigest) {
  const std::string text = deployment_to_json(hall_of(3));
  EXPECT_EQ(visit_of(nlohmann::json::parse(text).dump(), "other.json")->digest, visit_on(3).digest);
}

TEST(Visit, OfAResult) {
  const auto v = visit_of(kVerification, "v.json");
  ASSERT_TRUE(v) << v.error().message();
  EXPECT_EQ(v->kind, VisitKind::kVerification);
  EXPECT_EQ(v->verdict, "gate_failed");
  EXPECT_EQ(v->deployment_digest, "ab12");
  EXPECT_EQ(v->temperature_degC.value()[0], 17.0);
}

TEST(Visit, SaysWhatIsWrong) {
  expect_error(visit_of(R"({"status": "ok"})", "r.json"), 0, "neither a deployment nor", "r.json");
  expect_error(visit_of("[1]", "r.json"), 0, "neither a deployment nor", "r.json");
  expect_error(visit_of("{", "r.json"), 1, "", "r.json");
  std::string altered = deployment_to_json(hall_of(1));
  altered.replace(altered.find("hall"), 4, "hull");
  EXPECT_FALSE(visit_of(altered, "d.json"));
  Deployment undated = hall_of(1);
  undated.created = "yesterday";
  expect_error(visit_of(deployment_to_json(undated), "d.json"), 5, "ISO 8601", "d.json");
  std::string other = kVerification;
  other.replace(other.find("verification\""), 12, "celebration");
  expect_error(visit_of(other, "r.json"), 1, "one of", "r.json");
}

TEST(History, GivesBackWhatWasAdded) {
  const TemporaryFolder folder;
  const std::string path = folder.path("site.octant.db");
  {
    auto history = History::open(path, true);
    ASSERT_TRUE(history) << history.error().message();
    Visit late = visit_on(9), early = visit_on(2);
    early.note = "after the \"ladder\"; DROP TABLE visit";
    const auto added = history->add({late, early, *visit_of(kVerification, "v.json")});
    ASSERT_TRUE(added) << added.error().message();
    EXPECT_EQ(added->size(), 3u);
    EXPECT_TRUE((*added)[2].is_new);
  }
  auto history = History::open(path, false);
  const auto visits = history->list();
  ASSERT_TRUE(visits) << visits.error().message();
  ASSERT_EQ(visits->size(), 3u);
  EXPECT_EQ((*visits)[0].note, "after the \"ladder\"; DROP TABLE visit") << "by date, not by number";
  EXPECT_EQ((*visits)[0].who, "Ada");
  EXPECT_TRUE((*visits)[0].document.empty()) << "lists are short";
  EXPECT_FALSE((*visits)[2].speed);
  EXPECT_EQ(history->list({.site = "elsewhere", .kind = {}})->size(), 0u);
  EXPECT_EQ(history->list({.site = "", .kind = VisitKind::kVerification})->size(), 1u);
  const auto whole = history->get((*visits)[0].id);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->document, deployment_to_json(hall_of(2)));
  ASSERT_EQ(whole->beacons.size(), 2u);
  EXPECT_EQ(whole->beacons[1].position_m.z(), 6.002);
  EXPECT_EQ(whole->beacons[1].delay_sigma_s, 1e-6);
  EXPECT_EQ(whole->beacons[0].status, BeaconStatus::kControlPoint);
  EXPECT_EQ(whole->speed.value().sigma_mps, 0.02);
  const auto calibrations = history->calibrations("hall");
  ASSERT_EQ(calibrations->size(), 2u);
  EXPECT_EQ((*calibrations)[1].beacons.at(1).position_m.z(), 6.009);
  expect_error(history->get(77), 0, "no visit 77", "site.octant.db");
}

TEST(History, TheSameDocumentTwiceIsOneVisit) {
  const TemporaryFolder folder;
  auto history = History::open(folder.path("h.db"), true);
  const auto first = history->add({visit_on(1), visit_on(1)});
  ASSERT_TRUE(first) << first.error().message();
  EXPECT_TRUE((*first)[0].is_new);
  EXPECT_FALSE((*first)[1].is_new);
  EXPECT_EQ((*first)[0].id, (*first)[1].id);
  EXPECT_FALSE(history->add({visit_on(1)})->at(0).is_new);
  EXPECT_EQ(history->list()->size(), 1u);
}

TEST(History, RefusesWhatIsNotItsOwn) {
  const TemporaryFolder folder;
  expect_error(History::open(folder.path("none.db"), false), 0, "octant history add", "none.db");
  expect_error(History::open(folder.path(), true), 0, "a folder", "");
  expect_error(History::open(folder.write("text.db", std::string(5000, 'x')), true), 0, "no SQLite database",
               "text.db");
  {
    auto other = SqlStore::open(folder.path("other.db"), true);
    ASSERT_TRUE((*other)->run("CREATE TABLE bookmarks (id INTEGER)"));
  }
  expect_error(History::open(folder.path("other.db"), true), 0, "another program", "other.db");
  ASSERT_TRUE(History::open(folder.path("newer.db"), true));
  {
    auto newer = SqlStore::open(folder.path("newer.db"), false);
    ASSERT_TRUE((*newer)->run("PRAGMA user_version = 99"));
  }
  expect_error(History::open(folder.path("newer.db"), false), 0, "a history of version 99", "newer.db");
  expect_error(History::open(folder.path("no/such/folder/h.db"), true), 0, "folder", "h.db");
}

/// Children that write at once, each its own visits one by one; the number of those that failed.
int write_side_by_side(const std::string& path, int processes, int each) {
  for (int p = 0; p < processes; ++p) {
    if (fork() != 0) continue;
    // Every child opens the file itself, some of them while it is being made.
    auto history = History::open(path, true);
    bool fine = history.has_value();
    for (int i = 0; fine && i < each; ++i) fine = history->add({visit_on(1 + p * each + i)}).has_value();
    _exit(fine ? 0 : 1);
  }
  int failed = 0, status = 0;
  while (wait(&status) > 0) failed += !(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  return failed;
}

TEST(History, EightWritersAtOnceLoseNothing) {
  const TemporaryFolder folder;
  const std::string path = folder.path("h.db");
  EXPECT_EQ(write_side_by_side(path, 8, 25), 0);
  auto history = History::open(path, false);
  EXPECT_EQ(history->list()->size(), 200u);
  EXPECT_EQ(history->calibrations("hall")->at(199).beacons.size(), 2u);
}

/// A reader during the creation of the file sees either no content or all.
TEST(History, IsNeverAnothersWhileItIsMade) {
  const TemporaryFolder folder;
  for (int round = 0; round < 30; ++round) {
    const std::string path = folder.path("h" + std::to_string(round) + ".db");
    auto looking = SqlStore::open(path, true);
    ASSERT_TRUE(looking);
    const pid_t maker = fork();
    ASSERT_GE(maker, 0);
    if (maker == 0) _exit(History::open(path, true) ? 0 : 1);
    for (bool made = false; !made;) {
      const auto schema = (*looking)->schema();
      ASSERT_TRUE(schema) << schema.error().message();
      ASSERT_TRUE(schema->ours || schema->empty) << "round " << round;
      made = schema->ours;
    }
    int status = 1;
    waitpid(maker, &status, 0);
    ASSERT_EQ(status, 0);
  }
}

TEST(History, AnAdditionIsWholeOrNothing) {
  const TemporaryFolder folder;
  auto history = History::open(folder.path("h.db"), true);
  Visit broken = visit_on(2);
  broken.beacons[1].position_m.x() = NAN;  // SQLite keeps NaN as NULL, which the table does not take
  EXPECT_FALSE(history->add({visit_on(1), broken}));
  EXPECT_EQ(history->list()->size(), 0u);
  EXPECT_TRUE(history->add({visit_on(1)})) << "and the next goes through";
}

/// As a full disk does, for what this process writes.
class NoFileBeyond {
 public:
  explicit NoFileBeyond(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~NoFileBeyond() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  NoFileBeyond(const NoFileBeyond&) = delete;
  NoFileBeyond& operator=(const NoFileBeyond&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(History, AFullDiskLeavesNoneThatWasMadeInVain) {
  const TemporaryFolder folder;
  const std::string path = folder.path("h.db");
  int failures = 0;
  for (rlim_t room = 512; room < 200'000; room *= 2) {
    bool added = false;
    {
      const NoFileBeyond full(room);
      auto history = History::open(path, true);
      added = history && history->add({visit_on(1)}).has_value();
    }
    failures += added ? 0 : 1;
    EXPECT_EQ(folder.files(), added ? 1u : 0u) << room;
    std::filesystem::remove(path);
  }
  EXPECT_GE(failures, 5);
}

TEST(History, AFullDiskLeavesWhatWasThere) {
  const TemporaryFolder folder;
  const std::string path = folder.path("h.db");
  ASSERT_TRUE(History::open(path, true)->add({visit_on(1)}));
  {
    const NoFileBeyond full(std::filesystem::file_size(path));
    auto history = History::open(path, true);
    EXPECT_FALSE(history && history->add({visit_on(2), visit_on(3), visit_on(4), visit_on(5), visit_on(6)}));
  }
  EXPECT_EQ(History::open(path, false)->list()->size(), 1u);
}

TEST(History, SaysThatItsFileWasRemovedMeanwhile) {
  const TemporaryFolder folder;
  auto history = History::open(folder.path("h.db"), true);
  std::filesystem::remove(folder.path("h.db"));
  expect_error(history->add({visit_on(1)}), 0, "removed", "h.db");
}

}  // namespace history_test
}  // namespace octant::io
