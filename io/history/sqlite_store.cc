// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include <fmt/format.h>
#include <sqlite3.h>

#include "io/history/sql.h"

namespace octant::io {
namespace {

using SqlClock = std::chrono::steady_clock;
constexpr std::chrono::seconds kPatience{kPatience_s};
/// "Octa" in the header of the file distinguishes a history from the databases of other programs.
constexpr std::int64_t kApplicationId = 0x4F637461;
constexpr std::uintmax_t kPage = 4096;  ///< bytes of a page of a file that is created here

tl::unexpected<Error> sql_failure(const std::string& path, int code, const std::string& words) {
  switch (code & 0xFF) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return fail({.code = Errc::kOutput,
                   .file = path,
                   .found = fmt::format("locked by another program for more than {} s", kPatience.count()),
                   .expected = "a history that others write to for moments only",
                   .advice = "end the program that holds it, and try again"});
    case SQLITE_NOTADB:
      return fail({.file = path,
                   .found = "no SQLite database",
                   .expected = "a history, which octant history add makes"});
    case SQLITE_CORRUPT:
      return fail({.file = path,
                   .found = "a damaged database: " + words,
                   .expected = "a history as octant wrote it",
                   .advice = "take the last copy of it; `sqlite3 FILE .recover` may save the rest"});
    case SQLITE_CANTOPEN:
      return fail({.file = path,
                   .found = "cannot be opened: " + words,
                   .expected = "a file in a folder that can be written (SQLite keeps its log beside it)"});
    case SQLITE_READONLY:
    case SQLITE_FULL:
    case SQLITE_IOERR:
      return fail({.code = Errc::kOutput,
                   .file = path,
                   .found = "not written: " + words,
                   .advice = "is there space, and the right to write here?"});
    default: return fail({.file = path, .found = "the database says: " + words});
  }
}

class SqliteStatement final : public SqlStatement {
 public:
  SqliteStatement(sqlite3_stmt* statement, sqlite3* db, const std::string& path)
      : statement_(statement), db_(db), path_(path) {}
  ~SqliteStatement() override { sqlite3_finalize(statement_); }
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  void put(int at, std::string_view text) override {
    sqlite3_bind_text64(statement_, at, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  }
  void put(int at, std::int64_t number) override { sqlite3_bind_int64(statement_, at, number); }
  void put(int at, double number) override { sqlite3_bind_double(statement_, at, number); }
  void put_null(int at) override { sqlite3_bind_null(statement_, at); }
  Result<bool> next() override {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    return sql_failure(path_, sqlite3_extended_errcode(db_), sqlite3_errmsg(db_));
  }
  void reset() override {
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
  }
  std::string text(int column) const override {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    if (bytes == nullptr) return {};
    return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
  }
  std::int64_t integer(int column) const override { return sqlite3_column_int64(statement_, column); }
  double real(int column) const override { return sqlite3_column_double(statement_, column); }
  bool is_null(int column) const override { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }

 private:
  sqlite3_stmt* statement_;
  sqlite3* db_;
  const std::string& path_;
};

class SqliteStore final : public SqlStore {
 public:
  /// @param made  the file is new
  SqliteStore(sqlite3* db, std::string path, bool made) : db_(db), path_(std::move(path)), made_(made) {}
  ~SqliteStore() override {
    if (made_ && given_up_) remove_unless_used();
    sqlite3_close_v2(db_);
  }
  SqliteStore(const SqliteStore&) = delete;
  SqliteStore& operator=(const SqliteStore&) = delete;

  Result<void> run(const std::string& sql) override {
    if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
    return failure();
  }
  Result<std::unique_ptr<SqlStatement>> prepare(std::string_view sql) override {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(db_, sql.data(), static_cast<int>(sql.size()), &statement, nullptr) != SQLITE_OK)
      return failure();
    return std::make_unique<SqliteStatement>(statement, db_, path_);
  }
  Result<void> begin() override { return run("BEGIN IMMEDIATE"); }
  Result<SqlSchema> schema() override {
    // The order matters. Another program may create all of it, in one transaction, between any two of these
    // statements; a reader who sees its tables or its version then also sees its owner.
    const auto tables = number("SELECT count(*) FROM sqlite_master");
    if (!tables) return fail(tables.error());
    const auto version = number("PRAGMA user_version");
    if (!version) return fail(version.error());
    const auto owner = number("PRAGMA application_id");
    if (!owner) return fail(owner.error());
    return SqlSchema{*version, *owner == kApplicationId, *version == 0 && *tables == 0};
  }
  Result<void> set_version(std::int64_t version) override {
    return run(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, version));
  }
  void give_up() override { given_up_ = true; }
  Result<void> keep() override {
    given_up_ = false;
    made_ = false;
    std::error_code ignored;
    if (std::filesystem::exists(path_, ignored)) return {};
    return fail({.code = Errc::kOutput,
                 .file = path_,
                 .found = "not written: somebody removed the file while it was written to",
                 .advice = "add it once more"});
  }
  std::string identity() const override { return "INTEGER PRIMARY KEY"; }
  std::string name() const override { return path_; }

 private:
  [[nodiscard]] tl::unexpected<Error> failure() const {
    return sql_failure(path_, sqlite3_extended_errcode(db_), sqlite3_errmsg(db_));
  }
  Result<std::int64_t> number(std::string_view sql) {
    auto rows = prepare(sql);
    if (!rows) return fail(rows.error());
    const auto row = (*rows)->next();
    if (!row) return fail(row.error());
    return *row ? (*rows)->integer(0) : 0;
  }

  /// As the only writer if possible, because another program may have added to the file in the meantime. A
  /// waiting program finds in keep() that the file was removed.
  void remove_unless_used() {
    const bool alone = begin().has_value();
    const auto tables = number("SELECT count(*) FROM sqlite_master");
    const auto rows = tables && *tables > 0 ? number("SELECT count(*) FROM visit") : tables;
    std::error_code ignored;
    const auto bytes = [&](const char* part) {
      const auto size = std::filesystem::file_size(path_ + part, ignored);
      return ignored ? 0 : size;
    };
    // If a full disk prevents reading, a file of one page contains no table.
    const bool unused = rows ? *rows == 0 : bytes("") <= kPage && bytes("-wal") == 0;
    for (const char* part : {"-wal", "-shm", "-journal", ""})
      if (unused) std::filesystem::remove(path_ + part, ignored);
    if (alone) (void)run("ROLLBACK");
  }

  sqlite3* db_;
  std::string path_;
  bool made_, given_up_ = false;
};

}  // namespace

Result<std::unique_ptr<SqlStore>> open_sqlite(const std::string& path, bool create) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return fail({.file = path, .found = "a folder", .expected = "a history file, such as site.octant.db"});
  if (!create && !std::filesystem::exists(path, ignored))
    return fail({.file = path,
                 .found = "there is no such file",
                 .expected = "a history",
                 .advice = "octant history add DEPLOYMENT.json makes one; --db names it"});
  const bool made = !std::filesystem::exists(path, ignored);
  sqlite3* db = nullptr;
  const int flags = SQLITE_OPEN_READWRITE | (create ? SQLITE_OPEN_CREATE : 0);
  const int code = sqlite3_open_v2(path.c_str(), &db, flags, nullptr);
  auto store = std::make_unique<SqliteStore>(db, path, made);  // closes it, whatever comes
  if (code != SQLITE_OK) return sql_failure(path, code, db != nullptr ? sqlite3_errmsg(db) : "out of memory");
  sqlite3_extended_result_codes(db, 1);
  sqlite3_busy_timeout(db, static_cast<int>(std::chrono::milliseconds(kPatience).count()));
  // A change of the journal mode does not wait for other programs, nor does the recovery after a killed
  // writer.
  const bool can_write = sqlite3_db_readonly(db, "main") == 0;
  const auto until = SqlClock::now() + kPatience;
  auto ready = store->run(can_write ? "PRAGMA journal_mode = WAL" : "SELECT count(*) FROM sqlite_master");
  while (!ready && (sqlite3_errcode(db) & 0xFF) == SQLITE_BUSY && SqlClock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ready = store->run("PRAGMA journal_mode = WAL");
  }
  if (!ready) {
    store->give_up();
    return fail(ready.error());
  }
  // Each commit is on the disk before the call returns, so that a power failure loses no addition.
  if (auto set = store->run("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON"); !set)
    return fail(set.error());
  return store;
}

}  // namespace octant::io
