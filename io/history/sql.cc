// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/sql.h"

#include <utility>

namespace octant::io {

bool is_connection_string(std::string_view path) {
  return path.rfind("postgresql://", 0) == 0 || path.rfind("postgres://", 0) == 0;
}

Result<SqlDatabase> SqlDatabase::open(const std::string& path, bool create) {
  auto store = is_connection_string(path) ? open_postgres(path, create) : open_sqlite(path, create);
  if (!store) return fail(store.error());
  return SqlDatabase(std::move(*store));
}

Result<SqlStatement> SqlDatabase::prepare(std::string_view sql) {
  auto rows = store_->prepare(sql);
  if (!rows) return fail(rows.error());
  return SqlStatement(std::move(*rows));
}

Result<SqlTransaction> SqlTransaction::begin(SqlDatabase& database) {
  if (auto begun = database.store().begin(); !begun) return fail(begun.error());
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
