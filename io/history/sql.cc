// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/sql.h"

#include <utility>

namespace octant::io {

bool is_connection_string(std::string_view path) {
  return path.rfind("postgresql://", 0) == 0 || path.rfind("postgres://", 0) == 0;
}

Result<std::unique_ptr<SqlStore>> SqlStore::open(const std::string& path, bool create) {
  return is_connection_string(path) ? open_postgres(path, create) : open_sqlite(path, create);
}

Result<SqlTransaction> SqlTransaction::begin(SqlStore& store) {
  if (auto begun = store.begin(); !begun) return fail(begun.error());
  return SqlTransaction(store);
}
SqlTransaction::SqlTransaction(SqlTransaction&& other) noexcept
    : store_(std::exchange(other.store_, nullptr)) {}
SqlTransaction::~SqlTransaction() {
  if (store_ != nullptr) (void)store_->run("ROLLBACK");
}
Result<void> SqlTransaction::commit() {
  if (auto done = store_->run("COMMIT"); !done) return done;
  store_ = nullptr;
  return {};
}

}  // namespace octant::io
