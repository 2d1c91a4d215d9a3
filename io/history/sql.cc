// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/sql.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include <fmt/format.h>
#include <sqlite3.h>

namespace octant::io {
namespace {

using SqlClock = std::chrono::steady_clock;
/// How long a writer waits for others: an addition takes milliseconds, so that some hundred writers may stand
/// in line.
constexpr std::chrono::seconds kPatience{30};

tl::unexpected<Error> sql_failure(const std::string& path, int code, const std::string& words) {
  switch (code & 0xFF) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return fail({.code = Errc::kOutput,
                   .file = path,
                   .found = fmt::format("held by another program for more than {} s", kPatience.count()),
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

}  // namespace

struct SqlDatabase::Handle {
  sqlite3* db = nullptr;
  std::string path;
  ~Handle() { sqlite3_close_v2(db); }
};

struct SqlStatement::Handle {
  sqlite3_stmt* statement = nullptr;
  ~Handle() { sqlite3_finalize(statement); }
};

SqlDatabase::SqlDatabase(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
SqlDatabase::SqlDatabase(SqlDatabase&&) noexcept = default;
SqlDatabase& SqlDatabase::operator=(SqlDatabase&&) noexcept = default;
SqlDatabase::~SqlDatabase() = default;

tl::unexpected<Error> SqlDatabase::failure() const {
  return sql_failure(handle_->path, sqlite3_extended_errcode(handle_->db), sqlite3_errmsg(handle_->db));
}

Result<SqlDatabase> SqlDatabase::open(const std::string& path, bool create) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return fail({.file = path, .found = "a folder", .expected = "a history file, such as site.octant.db"});
  if (!create && !std::filesystem::exists(path, ignored))
    return fail({.file = path,
                 .found = "there is no such file",
                 .expected = "a history",
                 .advice = "octant history add DEPLOYMENT.json makes one; --db names it"});
  auto handle = std::make_unique<Handle>();
  handle->path = path;
  const int flags = SQLITE_OPEN_READWRITE | (create ? SQLITE_OPEN_CREATE : 0);
  if (const int code = sqlite3_open_v2(path.c_str(), &handle->db, flags, nullptr); code != SQLITE_OK)
    return sql_failure(path, code, handle->db != nullptr ? sqlite3_errmsg(handle->db) : "out of memory");
  sqlite3_extended_result_codes(handle->db, 1);
  sqlite3_busy_timeout(handle->db, static_cast<int>(std::chrono::milliseconds(kPatience).count()));
  SqlDatabase database(std::move(handle));
  // A change of the journal's mode does not wait for others by itself, nor does the recovery of what a killed
  // writer left.
  const bool can_write = sqlite3_db_readonly(database.handle_->db, "main") == 0;
  const auto until = SqlClock::now() + kPatience;
  auto ready = database.run(can_write ? "PRAGMA journal_mode = WAL" : "SELECT count(*) FROM sqlite_master");
  while (!ready && (sqlite3_errcode(database.handle_->db) & 0xFF) == SQLITE_BUSY && SqlClock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ready = database.run("PRAGMA journal_mode = WAL");
  }
  if (!ready) return fail(ready.error());
  // Every commit is on the disk before it is told: what was added stays, whatever happens to the machine.
  if (auto set = database.run("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON"); !set)
    return fail(set.error());
  return database;
}

Result<void> SqlDatabase::run(const std::string& sql) {
  if (sqlite3_exec(handle_->db, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return failure();
}

Result<SqlStatement> SqlDatabase::prepare(std::string_view sql) {
  auto handle = std::make_unique<SqlStatement::Handle>();
  if (sqlite3_prepare_v2(handle_->db, sql.data(), static_cast<int>(sql.size()), &handle->statement,
                         nullptr) != SQLITE_OK)
    return failure();
  return SqlStatement(std::move(handle), *this);
}

Result<std::int64_t> SqlDatabase::number(std::string_view sql) {
  auto statement = prepare(sql);
  if (!statement) return fail(statement.error());
  const auto row = statement->next();
  if (!row) return fail(row.error());
  return *row ? statement->integer(0) : 0;
}

std::int64_t SqlDatabase::last_id() const { return sqlite3_last_insert_rowid(handle_->db); }

SqlStatement::SqlStatement(std::unique_ptr<Handle> handle, SqlDatabase& database)
    : handle_(std::move(handle)), database_(&database) {}
SqlStatement::SqlStatement(SqlStatement&&) noexcept = default;
SqlStatement::~SqlStatement() = default;

SqlStatement& SqlStatement::bind(int at, std::string_view text) {
  sqlite3_bind_text64(handle_->statement, at, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  return *this;
}

SqlStatement& SqlStatement::bind(int at, std::int64_t number) {
  sqlite3_bind_int64(handle_->statement, at, number);
  return *this;
}

SqlStatement& SqlStatement::bind(int at, double number) {
  sqlite3_bind_double(handle_->statement, at, number);
  return *this;
}

SqlStatement& SqlStatement::bind(int at, const std::optional<double>& number) {
  number ? sqlite3_bind_double(handle_->statement, at, *number) : sqlite3_bind_null(handle_->statement, at);
  return *this;
}

Result<bool> SqlStatement::next() {
  const int code = sqlite3_step(handle_->statement);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return database_->failure();
}

void SqlStatement::reset() {
  sqlite3_reset(handle_->statement);
  sqlite3_clear_bindings(handle_->statement);
}

std::string SqlStatement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(handle_->statement, column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_->statement, column))};
}
std::int64_t SqlStatement::integer(int column) const {
  return sqlite3_column_int64(handle_->statement, column);
}
double SqlStatement::real(int column) const { return sqlite3_column_double(handle_->statement, column); }
std::optional<double> SqlStatement::real_or_none(int column) const {
  if (sqlite3_column_type(handle_->statement, column) == SQLITE_NULL) return std::nullopt;
  return real(column);
}

Result<SqlTransaction> SqlTransaction::begin(SqlDatabase& database) {
  if (auto begun = database.run("BEGIN IMMEDIATE"); !begun) return fail(begun.error());
  return SqlTransaction(database);
}
SqlTransaction::SqlTransaction(SqlTransaction&& other) noexcept
    : database_(std::exchange(other.database_, nullptr)) {}
SqlTransaction::~SqlTransaction() {
  if (database_ != nullptr) (void)database_->run("ROLLBACK");
}
Result<void> SqlTransaction::commit() {
  if (auto done = database_->run("COMMIT"); !done) return done;
  database_ = nullptr;
  return {};
}

}  // namespace octant::io
