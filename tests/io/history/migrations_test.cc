// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/migrations.h"

#include "tests/io/io_support.h"

namespace octant::io {
namespace {

using test::expect_error;
using test::TemporaryFolder;

std::vector<std::string> tables_of(SqlStore& database) {
  std::vector<std::string> names;
  auto rows = database.prepare("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name").value();
  while (rows->next().value()) names.push_back(rows->text(0));
  return names;
}

TEST(Migrations, AnEmptyDatabaseBecomesAHistory) {
  const TemporaryFolder folder;
  auto database = SqlStore::open(folder.path("a.db"), true).value();
  ASSERT_TRUE(migrate(*database));
  EXPECT_THAT(tables_of(*database), testing::ElementsAre("beacon", "document", "visit"));
  const SqlSchema schema = database->schema().value();
  EXPECT_TRUE(schema.ours);
  EXPECT_EQ(schema.version, 1);
}

TEST(Migrations, WhatIsOfTodayStaysAsItIs) {
  const TemporaryFolder folder;
  auto database = SqlStore::open(folder.path("a.db"), true).value();
  ASSERT_TRUE(migrate(*database));
  ASSERT_TRUE(database->run("INSERT INTO document (digest, content) VALUES ('d', 'c')"));
  ASSERT_TRUE(migrate(*database));
  auto again = SqlStore::open(folder.path("a.db"), false).value();
  ASSERT_TRUE(migrate(*again));
  auto rows = again->prepare("SELECT content FROM document").value();
  ASSERT_TRUE(rows->next().value());
  EXPECT_EQ(rows->text(0), "c");
}

TEST(Migrations, ANewerHistoryIsRefused) {
  const TemporaryFolder folder;
  auto database = SqlStore::open(folder.path("a.db"), true).value();
  ASSERT_TRUE(migrate(*database));
  ASSERT_TRUE(database->set_version(2));
  expect_error(migrate(*database), 0, "a history of version 2; expected version 1 or older", "a.db");
  EXPECT_EQ(database->schema()->version, 2) << "and left alone";
}

TEST(Migrations, AnotherProgramsDatabaseIsRefusedAndLeftAlone) {
  const TemporaryFolder folder;
  auto database = SqlStore::open(folder.path("a.db"), true).value();
  ASSERT_TRUE(database->run("CREATE TABLE contacts (name TEXT)"));
  expect_error(migrate(*database), 0, "a database of another program", "a.db");
  EXPECT_THAT(tables_of(*database), testing::ElementsAre("contacts"));
}

TEST(Migrations, AreWholeOrNotAtAll) {
  const TemporaryFolder folder;
  auto database = SqlStore::open(folder.path("a.db"), true).value();
  // One of the tables is there already: the statement before it must not stay.
  ASSERT_TRUE(database->set_version(0));
  ASSERT_TRUE(database->run("CREATE TABLE visit (id INTEGER)"));
  EXPECT_FALSE(migrate(*database));
  EXPECT_THAT(tables_of(*database), testing::ElementsAre("visit"));
  EXPECT_EQ(database->schema()->version, 0);
}

TEST(Migrations, TheTablesKeepWhatBelongsTogether) {
  const TemporaryFolder folder;
  auto database = SqlStore::open(folder.path("a.db"), true).value();
  ASSERT_TRUE(migrate(*database));
  const auto visit = [&](const std::string& kind, const std::string& digest) {
    return database->run(
        "INSERT INTO visit (kind, site, happened_s, added_s, digest, deployment_digest, verdict, who, note, "
        "source, "
        "program) VALUES ('" +
        kind + "', 's', 1, 2, '" + digest + "', 'd', 'v', 'w', 'n', 's', 'p')");
  };
  ASSERT_TRUE(database->run("INSERT INTO document (digest, content) VALUES ('d', 'c'), ('e', 'c')"));
  EXPECT_TRUE(visit("calibration", "d"));
  EXPECT_FALSE(visit("calibration", "d")) << "a document is one visit";
  EXPECT_FALSE(visit("calibration", "none")) << "and there is one";
  EXPECT_FALSE(visit("celebration", "e"));
  EXPECT_FALSE(database->run("INSERT INTO beacon VALUES (99, 0, 'B', 0, 0, 0, 0, 0, 0, 0, 0, 's')"))
      << "beacons are of a visit";
}

}  // namespace
}  // namespace octant::io
