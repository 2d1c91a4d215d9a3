// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Histories on a PostgreSQL server that the test starts. Skipped, with a message, without a server or if
// Octant was built without libpq.
#include <pwd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/history/history.h"
#include "io/history/sql.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace history_postgres_test {

using test::TemporaryFolder;

/// initdb and pg_ctl of the newest installed server; no value without one.
std::optional<std::filesystem::path> server_programs() {
  std::optional<std::filesystem::path> newest;
  std::error_code none;
  for (const auto& version : std::filesystem::directory_iterator("/usr/lib/postgresql", none))
    if (const auto bin = version.path() / "bin"; std::filesystem::exists(bin / "initdb"))
      if (!newest || bin > *newest) newest = bin;
  return newest;
}

/// A separate server on a socket in a separate folder. It does not run as root, so it then runs as another
/// user.
class Server {
 public:
  explicit Server(const std::filesystem::path& programs) : programs_(programs) {
    if (geteuid() == 0) {
      const passwd* other = getpwnam("postgres") != nullptr ? getpwnam("postgres") : getpwnam("nobody");
      user_ = other->pw_name;
      as_ = "runuser -u " + user_ + " -- ";
      if (chown(folder_.path("").c_str(), other->pw_uid, other->pw_gid) != 0) return;
    } else {
      user_ = getpwuid(geteuid())->pw_name;
    }
    const std::string data = folder_.path("data");
    runs_ = call("initdb", "-D '" + data + "' -A trust -E UTF8 --no-locale -N") &&
            call("pg_ctl", "-D '" + data + "' -w -t 60 -l '" + folder_.path("log") + "' -o \"-k '" +
                               folder_.path("") +
                               "' -c listen_addresses='' -c fsync=off -c max_connections=40\" start");
  }
  ~Server() {
    if (runs_) static_cast<void>(call("pg_ctl", "-D '" + folder_.path("data") + "' -m immediate stop"));
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] bool runs() const { return runs_; }
  [[nodiscard]] std::string database(const std::string& name) const {
    return "postgresql://" + user_ + "@/" + name + "?host=" + folder_.path("");
  }
  [[nodiscard]] bool make(const std::string& name) const {
    return call("createdb", "-h '" + folder_.path("") + "' " + name);
  }

 private:
  [[nodiscard]] bool call(const std::string& program, const std::string& words) const {
    const std::string line =
        "cd / && " + as_ + "'" + (programs_ / program).string() + "' " + words + " >/dev/null 2>&1";
    return std::system(line.c_str()) == 0;  // NOLINT(concurrency-mt-unsafe): a test by itself
  }

  std::filesystem::path programs_;
  TemporaryFolder folder_;
  std::string user_, as_;
  bool runs_ = false;
};

Visit visit_numbered(int number, const std::string& site = "hall") {
  Visit v;
  v.site = site;
  v.happened_s = 1767312000 + 86400LL * (number % 7);
  v.added_s = 1767312000;
  v.digest = "digest " + std::to_string(number);
  v.deployment_digest = v.digest;
  v.speed = VisitSpeed{345.1 + 0.1 * number, 0.02, 0.1 / 3.0, 21.0};
  v.verdict = "Good";
  v.who = "Ada; DROP TABLE visit";
  v.note = "a ladder \"hit\" B7? 'yes'";
  v.document = "{\"number\": " + std::to_string(number) + ", \"words\": \"\xC3\xBC $1 ?1\"}";
  for (int b = 0; b < 3; ++b)
    v.beacons.push_back({.name = "B" + std::to_string(b),
                         .position_m = {b + 1.0 / 3.0, 2.0, 1e-9 * number},
                         .sigma_m = {1e-3, 2e-3, 3e-3},
                         .delay_s = 1e-4 / 7.0,
                         .delay_sigma_s = 1e-6,
                         .status = b == 0 ? BeaconStatus::kControlPoint : BeaconStatus::kCalibrated});
  return v;
}

void expect_same(const Visit& a, const Visit& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.site, b.site);
  EXPECT_EQ(a.happened_s, b.happened_s);
  EXPECT_EQ(a.digest, b.digest);
  EXPECT_EQ(a.temperature_degC, b.temperature_degC);
  ASSERT_EQ(a.speed.has_value(), b.speed.has_value());
  if (a.speed) EXPECT_EQ(a.speed->speed_mps, b.speed->speed_mps) << "to the last bit";
  if (a.speed) EXPECT_EQ(a.speed->offset_mps, b.speed->offset_mps);
  EXPECT_EQ(a.who, b.who);
  EXPECT_EQ(a.note, b.note);
  EXPECT_EQ(a.document, b.document);
  ASSERT_EQ(a.beacons.size(), b.beacons.size());
  for (std::size_t i = 0; i < a.beacons.size(); ++i) {
    EXPECT_EQ(a.beacons[i].name, b.beacons[i].name);
    EXPECT_EQ(a.beacons[i].position_m, b.beacons[i].position_m);
    EXPECT_EQ(a.beacons[i].delay_s, b.beacons[i].delay_s);
    EXPECT_EQ(a.beacons[i].status, b.beacons[i].status);
  }
}

/// One server for all tests of this file.
class PostgresHistory : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (const auto programs = server_programs()) server_ = std::make_unique<Server>(*programs);
  }
  static void TearDownTestSuite() { server_.reset(); }
  void SetUp() override {
    const auto without = History::open("postgresql://nobody@/none?host=/nowhere", false);
    ASSERT_FALSE(without);
    if (without.error().message().find("OCTANT_POSTGRESQL") != std::string::npos)
      GTEST_SKIP() << "built without libpq (-DOCTANT_POSTGRESQL=ON)";
    if (!server_) GTEST_SKIP() << "no server in /usr/lib/postgresql (package postgresql)";
    ASSERT_TRUE(server_->runs());
    name_ = "octant" + std::to_string(++databases_);
    ASSERT_TRUE(server_->make(name_));
  }
  [[nodiscard]] std::string database() const { return server_->database(name_); }

  static inline std::unique_ptr<Server> server_;
  static inline int databases_ = 0;
  std::string name_;
};

TEST_F(PostgresHistory, ListsWhatAFileLists) {
  const TemporaryFolder folder;
  std::vector<Visit> visits;
  for (int i = 0; i < 12; ++i) visits.push_back(visit_numbered(i, i % 3 == 0 ? "barn" : "hall"));
  visits[5].kind = VisitKind::kMonitoring;
  visits[5].speed.reset();
  visits[5].beacons.clear();
  visits[6].temperature_degC = {17.25, 19.5};
  auto file = History::open(folder.path("h.db"), true), server = History::open(database(), true);
  ASSERT_TRUE(file && server) << (server ? "" : server.error().message());
  for (auto* history : {&*file, &*server}) {
    const auto added = history->add(visits);
    ASSERT_TRUE(added) << added.error().message();
    EXPECT_TRUE(added->back().is_new);
    EXPECT_FALSE(history->add({visits[3]})->front().is_new);
  }
  for (const VisitFilter& filter : {VisitFilter{}, VisitFilter{"barn", {}},
                                    VisitFilter{"", VisitKind::kMonitoring}, VisitFilter{"attic", {}}}) {
    const auto a = file->list(filter), b = server->list(filter);
    ASSERT_TRUE(a && b);
    ASSERT_EQ(a->size(), b->size());
    for (std::size_t i = 0; i < a->size(); ++i) {
      EXPECT_EQ((*a)[i].id, (*b)[i].id);
      expect_same((*a)[i], (*b)[i]);
      expect_same(*file->get((*a)[i].id), *server->get((*b)[i].id));
    }
  }
  const auto a = file->calibrations("hall"), b = server->calibrations("hall");
  ASSERT_EQ(a->size(), b->size());
  for (std::size_t i = 0; i < a->size(); ++i) expect_same((*a)[i], (*b)[i]);
  EXPECT_FALSE(server->get(77));
}

TEST_F(PostgresHistory, IsNotMadeByReading) {
  const auto none = History::open(database(), false);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("without a history"), std::string::npos);
}

TEST_F(PostgresHistory, ANewerOneIsRefusedAndOneOfAnotherProgramToo) {
  ASSERT_TRUE(History::open(database(), true));
  ASSERT_TRUE((*SqlStore::open(database(), true))->run("UPDATE octant_history SET version = 99"));
  auto newer = History::open(database(), true);
  ASSERT_FALSE(newer);
  EXPECT_NE(newer.error().message().find("version 99"), std::string::npos);
  ASSERT_TRUE(server_->make(name_ + "other"));
  const std::string other = server_->database(name_ + "other");
  ASSERT_TRUE((*SqlStore::open(other, true))->run("CREATE TABLE visit (patient TEXT)"));
  auto foreign = History::open(other, true);
  ASSERT_FALSE(foreign);
  EXPECT_NE(foreign.error().message().find("another program"), std::string::npos);
}

TEST_F(PostgresHistory, AFailedAdditionLeavesNothing) {
  auto history = History::open(database(), true);
  Visit broken = visit_numbered(2);
  broken.beacons[2].name = std::string("\xFF", 1);  // no UTF-8: the server refuses it
  ASSERT_FALSE(history->add({visit_numbered(1), broken}));
  EXPECT_EQ(history->list()->size(), 0u);
  ASSERT_TRUE(history->add({visit_numbered(1)}));
  EXPECT_EQ(history->list()->size(), 1u);
}

/// A reader during the creation of the tables sees either no table or all.
TEST_F(PostgresHistory, IsNeverAnothersWhileItIsMade) {
  auto looking = SqlStore::open(database(), true);
  ASSERT_TRUE(looking);
  for (int round = 0; round < 15; ++round) {
    const pid_t maker = fork();
    ASSERT_GE(maker, 0);
    if (maker == 0) _exit(History::open(database(), true) ? 0 : 1);
    for (bool made = false; !made;) {
      const auto schema = (*looking)->schema();
      ASSERT_TRUE(schema) << schema.error().message();
      ASSERT_TRUE(schema->ours || schema->empty) << "round " << round;
      made = schema->ours || waitpid(maker, nullptr, WNOHANG) == maker;
    }
    waitpid(maker, nullptr, 0);
    ASSERT_TRUE((*looking)->run("DROP TABLE beacon, visit, document, octant_history"));
  }
}

/// All make the tables at once, too.
TEST_F(PostgresHistory, EightWritersLoseNothing) {
  constexpr int kWriters = 8, kEach = 25;
  std::vector<pid_t> writers;
  for (int w = 0; w < kWriters; ++w) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      bool well = true;
      auto history = History::open(database(), true);
      // Every fifth visit is the same for all.
      for (int i = 0; history && i < kEach; ++i)
        well = well && history->add({visit_numbered(i % 5 == 0 ? i : 1000 * (w + 1) + i)}).has_value();
      if (!history) std::fprintf(stderr, "writer %d: %s\n", w, history.error().message().c_str());
      _exit(history && well ? 0 : 1);
    }
    writers.push_back(child);
  }
  for (const pid_t writer : writers) {
    int status = 1;
    waitpid(writer, &status, 0);
    EXPECT_EQ(status, 0);
  }
  auto history = History::open(database(), false);
  const auto visits = history->list();
  ASSERT_TRUE(visits);
  EXPECT_EQ(visits->size(), static_cast<std::size_t>(kWriters * 20 + 5));
  for (const Visit& v : *visits) EXPECT_EQ(history->get(v.id)->beacons.size(), 3u);
}

TEST_F(PostgresHistory, AServerThatDoesNotAnswerIsNamedWithoutItsPassword) {
  const auto none = History::open("postgresql://ada:secret@/none?host=/nowhere", true);
  ASSERT_FALSE(none);
  const std::string said = none.error().message();
  EXPECT_NE(said.find("no connection"), std::string::npos) << said;
  EXPECT_EQ(said.find("secret"), std::string::npos) << said;
}

}  // namespace history_postgres_test
}  // namespace octant::io
