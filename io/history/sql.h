// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/history/: a database file and its statements. SQLite shows in sql.cc alone.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "models/support/result.h"

namespace octant::io {

class SqlStatement;

/// One SQLite database file in write-ahead-log mode: readers never wait for a writer, writers wait for each
/// other for up to kPatience. What a process leaves when it dies is taken back or carried through by whoever
/// opens the file next.
class SqlDatabase {
 public:
  /// Errors: missing (unless it may be created), no database, no place to write, held by others for longer
  /// than kPatience.
  [[nodiscard]] static Result<SqlDatabase> open(const std::string& path, bool create);
  SqlDatabase(SqlDatabase&&) noexcept;
  SqlDatabase& operator=(SqlDatabase&&) noexcept;
  ~SqlDatabase();

  /// Statements without rows, one or several.
  [[nodiscard]] Result<void> run(const std::string& sql);
  [[nodiscard]] Result<SqlStatement> prepare(std::string_view sql);
  /// The one number that a query gives.
  [[nodiscard]] Result<std::int64_t> number(std::string_view sql);
  [[nodiscard]] std::int64_t last_id() const;

 private:
  friend class SqlStatement;
  struct Handle;
  explicit SqlDatabase(std::unique_ptr<Handle> handle);
  [[nodiscard]] tl::unexpected<Error> failure() const;
  std::unique_ptr<Handle> handle_;
};

/// A prepared statement. Values are bound from 1 and read from 0, as SQLite counts them.
class SqlStatement {
 public:
  SqlStatement(SqlStatement&&) noexcept;
  ~SqlStatement();

  SqlStatement& bind(int at, std::string_view text);
  SqlStatement& bind(int at, std::int64_t number);
  SqlStatement& bind(int at, double number);
  SqlStatement& bind(int at, const std::optional<double>& number);
  /// The next row; false: there is none.
  [[nodiscard]] Result<bool> next();
  /// To be bound and run once more.
  void reset();

  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::optional<double> real_or_none(int column) const;

 private:
  friend class SqlDatabase;
  struct Handle;
  SqlStatement(std::unique_ptr<Handle> handle, SqlDatabase& database);
  std::unique_ptr<Handle> handle_;
  SqlDatabase* database_;
};

/// Begins at once as a writer and takes everything back unless commit() went through.
class SqlTransaction {
 public:
  [[nodiscard]] static Result<SqlTransaction> begin(SqlDatabase& database);
  SqlTransaction(SqlTransaction&& other) noexcept;
  ~SqlTransaction();
  [[nodiscard]] Result<void> commit();

 private:
  explicit SqlTransaction(SqlDatabase& database) : database_(&database) {}
  SqlDatabase* database_;
};

}  // namespace octant::io
