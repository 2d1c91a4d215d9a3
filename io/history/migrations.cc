// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/migrations.h"

#include <iterator>

#include <fmt/format.h>

namespace octant::io {
namespace {

/// "Octa" in the file's head: tells a history from the databases of other programs.
constexpr std::int64_t kApplicationId = 0x4F637461;

/// The k-th makes version k + 1 of version k. Never changed once it was released; later versions are
/// appended. Types are those that PostgreSQL has too.
constexpr const char* kMigrations[] = {
    R"sql(
CREATE TABLE document (
  digest TEXT PRIMARY KEY,
  content TEXT NOT NULL
);
CREATE TABLE visit (
  id INTEGER PRIMARY KEY,
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

Result<void> check_owner(SqlDatabase& database, const std::string& path, std::int64_t version) {
  const auto owner = database.number("PRAGMA application_id");
  if (!owner) return fail(owner.error());
  const auto tables = database.number("SELECT count(*) FROM sqlite_master");
  if (!tables) return fail(tables.error());
  const bool empty = version == 0 && *tables == 0;
  if (*owner != kApplicationId && !empty)
    return fail({.file = path,
                 .found = "a database of another program",
                 .expected = "a history that octant made",
                 .advice = "name another file with --db"});
  if (version > kVersion)
    return fail({.file = path,
                 .found = fmt::format("a history of version {}", version),
                 .expected = fmt::format("version {} or older", kVersion),
                 .advice = "a newer octant wrote it: use that one"});
  return {};
}

}  // namespace

Result<void> migrate(SqlDatabase& database, const std::string& path) {
  const auto found = database.number("PRAGMA user_version");
  if (!found) return fail(found.error());
  if (auto ours = check_owner(database, path, *found); !ours) return ours;
  if (*found == kVersion) return {};
  auto transaction = SqlTransaction::begin(database);
  if (!transaction) return fail(transaction.error());
  // Another program may have done it while this one waited.
  const auto version = database.number("PRAGMA user_version");
  if (!version) return fail(version.error());
  for (std::int64_t v = *version; v < kVersion; ++v)
    if (auto made = database.run(kMigrations[v]); !made) return made;
  if (auto marked = database.run(
          fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kVersion));
      !marked)
    return marked;
  return transaction->commit();
}

}  // namespace octant::io
