// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/history/: a store of tables and its statements. Only sqlite_store.cc uses SQLite, and only
// postgres_store.cc libpq.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "io/history/sql.h"
#include "models/support/result.h"

namespace octant::io {

/// Time for which a writer waits for others [s]. An addition needs milliseconds, so some hundred writers can
/// queue.
inline constexpr int kPatience_s = 30;

/// A prepared statement of a store. Values are bound from 1 (?1, ?2, ...) and read from 0, as SQLite counts.
class SqlStatement {
 public:
  virtual ~SqlStatement() = default;

  template <class Value>
  SqlStatement& bind(int at, const Value& value) {
    put(at, value);
    return *this;
  }
  SqlStatement& bind(int at, const std::optional<double>& number) {
    number ? put(at, *number) : put_null(at);
    return *this;
  }
  /// Binds all values, from 1.
  template <class... Values>
  SqlStatement& bind_all(const Values&... values) {
    int at = 0;
    (bind(++at, values), ...);
    return *this;
  }
  /// Steps to the next row; false at the end.
  [[nodiscard]] virtual Result<bool> next() = 0;
  /// Calls visit() at each row.
  template <class Visit>
  [[nodiscard]] Result<void> for_each(Visit&& visit) {
    for (;;) {
      const auto row = next();
      if (!row) return fail(row.error());
      if (!*row) return {};
      visit();
    }
  }
  /// Prepares the statement for new values.
  virtual void reset() = 0;

  [[nodiscard]] virtual std::string text(int column) const = 0;
  [[nodiscard]] virtual std::int64_t integer(int column) const = 0;
  [[nodiscard]] virtual double real(int column) const = 0;
  [[nodiscard]] virtual bool is_null(int column) const = 0;
  [[nodiscard]] std::optional<double> real_or_none(int column) const {
    return is_null(column) ? std::nullopt : std::optional<double>(real(column));
  }

 protected:
  virtual void put(int at, std::string_view text) = 0;
  virtual void put(int at, std::int64_t number) = 0;
  virtual void put(int at, double number) = 0;
  virtual void put_null(int at) = 0;
};

/// State of a store before it is used.
struct SqlSchema {
  std::int64_t version = 0;
  bool ours = false;   ///< a history wrote it
  bool empty = false;  ///< empty, and may be created
};

/// A database, by its path or connection string. Its callers contain the common parts of the dialects; it
/// contains the differences.
class SqlStore {
 public:
  virtual ~SqlStore() = default;
  [[nodiscard]] static Result<std::unique_ptr<SqlStore>> open(const std::string& path, bool create);
  /// Statements without rows, one or several.
  [[nodiscard]] virtual Result<void> run(const std::string& sql) = 0;
  [[nodiscard]] virtual Result<std::unique_ptr<SqlStatement>> prepare(std::string_view sql) = 0;
  /// Begins as the only writer at once, so that no other program reads data that this one is about to change.
  [[nodiscard]] virtual Result<void> begin() = 0;
  [[nodiscard]] virtual Result<SqlSchema> schema() = 0;
  [[nodiscard]] virtual Result<void> set_version(std::int64_t version) = 0;
  /// Type of a column with automatic numbers, from 1.
  [[nodiscard]] virtual std::string identity() const = 0;
  /// Undoes a failed addition: a store that was created for it is removed if it is empty.
  virtual void give_up() {}
  /// Confirms a complete addition. Error: the store was removed in the meantime.
  [[nodiscard]] virtual Result<void> keep() { return {}; }
  /// Name in messages, without passwords.
  [[nodiscard]] virtual std::string name() const = 0;
};

/// One SQLite file in write-ahead-log mode: readers never wait for a writer, and writers wait for each other
/// up to kPatience_s. The next program that opens the file rolls back or completes the work of a killed
/// process. If the disk is full, a newly created file is removed (give_up()). Errors: missing (unless it may
/// be created), not a database, a read-only place, locked by other programs.
[[nodiscard]] Result<std::unique_ptr<SqlStore>> open_sqlite(const std::string& path, bool create);
/// The tables of a PostgreSQL database, in the first schema of its search path; writers take turns by an
/// advisory lock. Errors: no connection; this Octant was built without.
[[nodiscard]] Result<std::unique_ptr<SqlStore>> open_postgres(const std::string& connection, bool create);
/// "postgresql://..." or "postgres://...".
[[nodiscard]] bool is_connection_string(std::string_view path);

/// Rolls back unless commit() succeeded.
class SqlTransaction {
 public:
  [[nodiscard]] static Result<SqlTransaction> begin(SqlStore& store);
  SqlTransaction(SqlTransaction&& other) noexcept;
  ~SqlTransaction();
  [[nodiscard]] Result<void> commit();

 private:
  explicit SqlTransaction(SqlStore& store) : store_(&store) {}
  SqlStore* store_;
};

/// Upgrades an empty or older history to the current tables, one version after the other, each in one
/// transaction. Errors: a newer history, a database of another program.
[[nodiscard]] Result<void> migrate(SqlStore& store);

}  // namespace octant::io
