// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "io/history/sql.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace sql_test {

using test::expect_error;
using test::TemporaryFolder;

/// A database with one table, in a folder of its own.
struct Box {
  Box() : database(SqlStore::open(folder.path("a.db"), true).value()) {
    EXPECT_TRUE(database->run(
        "CREATE TABLE t (id INTEGER PRIMARY KEY, text TEXT, number BIGINT, real DOUBLE PRECISION)"));
  }
  Result<void> insert(std::int64_t id) {
    auto statement = database->prepare("INSERT INTO t (id) VALUES (?1)");
    if (!statement) return fail(statement.error());
    if (auto done = (*statement)->bind(1, id).next(); !done) return fail(done.error());
    return {};
  }
  [[nodiscard]] std::int64_t count() {
    auto rows = database->prepare("SELECT count(*) FROM t").value();
    EXPECT_TRUE(rows->next().value());
    return rows->integer(0);
  }
  TemporaryFolder folder;
  std::unique_ptr<SqlStore> database;
};

TEST(Sql, ValuesComeBackAsTheyWere) {
  Box box;
  EXPECT_TRUE(rc::check("texts, whole numbers, numbers, nothing", [&] {
    RC_ASSERT(box.database->run("DELETE FROM t").has_value());
    const std::string text =
        test::some_name(3) + *rc::gen::element<std::string>("", "'; DROP TABLE t; --", "?1");
    const auto number = *rc::gen::arbitrary<std::int64_t>();
    const std::optional<double> real = test::maybe(test::some_number());
    auto insert = box.database->prepare("INSERT INTO t (text, number, real) VALUES (?1, ?2, ?3)").value();
    RC_ASSERT(insert->bind(1, text).bind(2, number).bind(3, real).next().has_value());
    auto rows = box.database->prepare("SELECT text, number, real FROM t").value();
    RC_ASSERT(rows->next().value());
    RC_ASSERT(rows->text(0) == text);
    RC_ASSERT(rows->integer(1) == number);
    RC_ASSERT(rows->real_or_none(2) == real);
    RC_ASSERT(!rows->next().value());
  }));
}

TEST(Sql, NumbersAtTheirLimitsComeBackToTheLastBit) {
  Box box;
  auto insert = box.database->prepare("INSERT INTO t (real) VALUES (?1)").value();
  const std::vector<double> numbers = {
      0.0, -0.0, 5e-324, 1.7976931348623157e308, 0.1, std::numeric_limits<double>::infinity()};
  for (const double number : numbers) {
    EXPECT_TRUE(insert->bind(1, number).next());
    insert->reset();
  }
  auto rows = box.database->prepare("SELECT real FROM t ORDER BY id").value();
  for (const double number : numbers) {
    ASSERT_TRUE(rows->next().value());
    EXPECT_EQ(rows->real(0), number);
  }
}

TEST(Sql, AStatementThatIsResetForgetsWhatWasBound) {
  Box box;
  auto insert = box.database->prepare("INSERT INTO t (text, number) VALUES (?1, ?2)").value();
  EXPECT_TRUE(insert->bind(1, "a").bind(2, std::int64_t{7}).next());
  insert->reset();
  EXPECT_TRUE(insert->bind(2, std::int64_t{8}).next());
  auto rows = box.database->prepare("SELECT text FROM t WHERE number = 8 AND text IS NULL").value();
  EXPECT_TRUE(rows->next().value());
  EXPECT_EQ(rows->text(0), "") << "and nothing is an empty text";
}

TEST(Sql, WhatIsNotCommittedIsTakenBack) {
  Box box;
  {
    auto transaction = SqlTransaction::begin(*box.database).value();
    EXPECT_TRUE(box.insert(1));
    EXPECT_EQ(box.count(), 1) << "within it, it is there";
  }
  EXPECT_EQ(box.count(), 0);
  {
    auto transaction = SqlTransaction::begin(*box.database).value();
    EXPECT_TRUE(box.insert(1));
    EXPECT_TRUE(transaction.commit());
  }
  EXPECT_EQ(box.count(), 1);
}

TEST(Sql, ATransactionThatWasMovedIsTakenBackOnce) {
  Box box;
  {
    auto first = SqlTransaction::begin(*box.database).value();
    SqlTransaction second(std::move(first));
    EXPECT_TRUE(box.insert(1));
    EXPECT_TRUE(second.commit());
  }
  EXPECT_EQ(box.count(), 1) << "the empty one takes nothing back";
}

TEST(Sql, AnotherReaderSeesWhatIsCommittedAndNothingBefore) {
  Box box;
  auto other = SqlStore::open(box.folder.path("a.db"), false).value();
  const auto seen = [&] {
    auto rows = other->prepare("SELECT count(*) FROM t").value();
    EXPECT_TRUE(rows->next().value());
    return rows->integer(0);
  };
  auto transaction = SqlTransaction::begin(*box.database).value();
  EXPECT_TRUE(box.insert(1));
  EXPECT_EQ(seen(), 0) << "and nobody waits";
  EXPECT_TRUE(transaction.commit());
  EXPECT_EQ(seen(), 1);
}

TEST(Sql, FaultsAreNamedWithTheirFile) {
  Box box;
  expect_error(box.database->prepare("SELECT absent FROM t"), 0, "no such column", "a.db");
  expect_error(box.database->run("CREATE TABLE t (id INTEGER)"), 0, "already exists", "a.db");
  EXPECT_TRUE(box.insert(1));
  expect_error(box.insert(1), 0, "UNIQUE constraint failed", "a.db");
  EXPECT_EQ(box.database->name(), box.folder.path("a.db"));
}

TEST(SqliteStore, OpensWhatIsADatabaseAndNothingElse) {
  const TemporaryFolder folder;
  expect_error(SqlStore::open(folder.path("none.db"), false), 0, "there is no such file", "none.db");
  expect_error(SqlStore::open(folder.path(), true), 0, "a folder; expected a history file");
  expect_error(SqlStore::open(folder.path("no/such/place.db"), true), 0, "cannot be opened");
  const std::string text = folder.write("text.db", std::string(2000, 'x'));
  expect_error(SqlStore::open(text, true), 0, "no SQLite database", "text.db");
  EXPECT_EQ(folder.read("text.db"), std::string(2000, 'x')) << "and leaves it as it was";
}

TEST(SqliteStore, KnowsWhetherItIsEmptyOrOurs) {
  const TemporaryFolder folder;
  auto database = SqlStore::open(folder.path("a.db"), true).value();
  SqlSchema schema = database->schema().value();
  EXPECT_TRUE(schema.empty);
  EXPECT_FALSE(schema.ours);
  ASSERT_TRUE(database->run("CREATE TABLE other (id INTEGER)"));
  schema = database->schema().value();
  EXPECT_FALSE(schema.empty || schema.ours) << "another program's";
  ASSERT_TRUE(database->set_version(7));
  schema = database->schema().value();
  EXPECT_TRUE(schema.ours);
  EXPECT_EQ(schema.version, 7);
}

TEST(Sql, ConnectionStringsAreNoPaths) {
  EXPECT_TRUE(is_connection_string("postgresql://user@host/db"));
  EXPECT_TRUE(is_connection_string("postgres://host"));
  for (const char* path : {"site.db", "./postgresql://x", "postgresql:/x", "Postgresql://x", ""})
    EXPECT_FALSE(is_connection_string(path)) << path;
}

}  // namespace sql_test

namespace sql_test {

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

}  // namespace sql_test

}  // namespace octant::io
