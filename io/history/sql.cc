// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/sql.h"

#include <iterator>
#include <utility>

#include <fmt/format.h>

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

namespace {

/// The k-th one upgrades version k to version k + 1. A released one never changes; later versions are
/// appended. SQLite and PostgreSQL accept both; {identity} is replaced by that of the store.
constexpr const char* kMigrations[] = {
    R"sql(
CREATE TABLE document (
  digest TEXT PRIMARY KEY,
  content TEXT NOT NULL
);
CREATE TABLE visit (
  id {identity},
  kind TEXT NOT NULL CHECK (kind IN ('calibration', 'monitoring', 'verification')),
  site TEXT NOT NULL,
  happened_s BIGINT NOT NULL,
  added_s BIGINT NOT NULL,
  digest TEXT NOT NULL UNIQUE REFERENCES document (digest),
  deployment_digest TEXT NOT NULL,
  coldest_degC DOUBLE PRECISION,
  warmest_degC DOUBLE PRECISION,
  speed_mps DOUBLE PRECISION,
  speed_sigma_mps DOUBLE PRECISION,
  speed_offset_mps DOUBLE PRECISION,
  speed_temperature_degC DOUBLE PRECISION,
  verdict TEXT NOT NULL,
  who TEXT NOT NULL,
  note TEXT NOT NULL,
  source TEXT NOT NULL,
  program TEXT NOT NULL
);
CREATE INDEX visit_by_date ON visit (site, happened_s);
CREATE TABLE beacon (
  visit_id BIGINT NOT NULL REFERENCES visit (id),
  place INTEGER NOT NULL,
  name TEXT NOT NULL,
  x_m DOUBLE PRECISION NOT NULL, y_m DOUBLE PRECISION NOT NULL, z_m DOUBLE PRECISION NOT NULL,
  sigma_x_m DOUBLE PRECISION NOT NULL, sigma_y_m DOUBLE PRECISION NOT NULL, sigma_z_m DOUBLE PRECISION NOT NULL,
  delay_s DOUBLE PRECISION NOT NULL,
  delay_sigma_s DOUBLE PRECISION NOT NULL,
  status TEXT NOT NULL,
  PRIMARY KEY (visit_id, place)
);
)sql"};
constexpr auto kVersion = static_cast<std::int64_t>(std::size(kMigrations));

Result<void> check_owner(const SqlSchema& schema, const std::string& name) {
  if (!schema.ours && !schema.empty)
    return fail({.file = name,
                 .found = "a database of another program",
                 .expected = "a history that octant made",
                 .advice = "name another file with --db"});
  if (schema.version > kVersion)
    return fail({.file = name,
                 .found = fmt::format("a history of version {}", schema.version),
                 .expected = fmt::format("version {} or older", kVersion),
                 .advice = "a newer octant wrote it: use that one"});
  return {};
}

std::string with_identity(std::string sql, const std::string& identity) {
  const std::string word = "{identity}";
  for (std::size_t at = sql.find(word); at != std::string::npos; at = sql.find(word, at))
    sql.replace(at, word.size(), identity);
  return sql;
}

}  // namespace

Result<void> migrate(SqlStore& store) {
  const auto found = store.schema();
  if (!found) return fail(found.error());
  if (auto ours = check_owner(*found, store.name()); !ours) return ours;
  if (found->version == kVersion) return {};
  auto transaction = SqlTransaction::begin(store);
  if (!transaction) return fail(transaction.error());
  // Another program may have upgraded it in the meantime.
  const auto now = store.schema();
  if (!now) return fail(now.error());
  if (auto ours = check_owner(*now, store.name()); !ours) return ours;
  for (std::int64_t v = now->version; v < kVersion; ++v)
    if (auto made = store.run(with_identity(kMigrations[v], store.identity())); !made) return made;
  if (auto marked = store.set_version(kVersion); !marked) return marked;
  return transaction->commit();
}

}  // namespace octant::io
