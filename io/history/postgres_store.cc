// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/history/sql.h"

#ifdef OCTANT_POSTGRESQL

#include <charconv>
#include <vector>

#include <fmt/format.h>
#include <libpq-fe.h>

namespace octant::io {
namespace {

constexpr std::int64_t kWriterLock = 0x4F637461;  ///< "Octa": histories in one database share it

struct ConnectionCloser {
  void operator()(PGconn* c) const { PQfinish(c); }
};
struct ResultClearer {
  void operator()(PGresult* r) const { PQclear(r); }
};
using PqResult = std::unique_ptr<PGresult, ResultClearer>;

/// First line of the server's message.
std::string first_line_of_server(const char* words) {
  std::string text = words != nullptr ? words : "";
  return text.substr(0, text.find('\n'));
}

struct PqConnection {
  std::unique_ptr<PGconn, ConnectionCloser> handle;
  std::string label;

  [[nodiscard]] tl::unexpected<Error> failure(const PGresult* result) const {
    const char* state = result != nullptr ? PQresultErrorField(result, PG_DIAG_SQLSTATE) : nullptr;
    if (state != nullptr && std::string_view(state) == "55P03")
      return fail({.code = Errc::kOutput,
                   .file = label,
                   .found = fmt::format("locked by another program for more than {} s", kPatience_s),
                   .expected = "a history that others write to for moments only",
                   .advice = "end the program that holds it, and try again"});
    return fail({.code = Errc::kOutput,
                 .file = label,
                 .found = "the database says: " + first_line_of_server(PQerrorMessage(handle.get())),
                 .advice = "is the server up, and may this user make and write tables?"});
  }
  [[nodiscard]] Result<PqResult> exec(const std::string& sql) const {
    PqResult result(PQexec(handle.get(), sql.c_str()));
    const ExecStatusType status = PQresultStatus(result.get());
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK || status == PGRES_EMPTY_QUERY) return result;
    return failure(result.get());
  }
};

/// ?1 as SQLite writes it is $1 here. No statement of a history has a question mark in a text.
std::string numbered(std::string_view sql) {
  std::string text(sql);
  for (char& c : text)
    if (c == '?') c = '$';
  return text;
}

/// All rows of a statement, fetched when it is executed.
class PqStatement final : public SqlStatement {
 public:
  PqStatement(const PqConnection& connection, std::string_view sql)
      : connection_(connection), sql_(numbered(sql)) {}

  void put(int at, std::string_view text) override { value(at) = std::string(text); }
  void put(int at, std::int64_t number) override { value(at) = std::to_string(number); }
  void put(int at, double number) override { value(at) = fmt::format("{}", number); }
  void put_null(int at) override { value(at).reset(); }

  Result<bool> next() override {
    if (!result_) {
      std::vector<const char*> texts;
      for (const auto& v : values_) texts.push_back(v ? v->c_str() : nullptr);
      result_.reset(PQexecParams(connection_.handle.get(), sql_.c_str(), static_cast<int>(texts.size()),
                                 nullptr, texts.data(), nullptr, nullptr, 0));
      const ExecStatusType status = PQresultStatus(result_.get());
      if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) return connection_.failure(result_.get());
      row_ = -1;
    }
    return ++row_ < PQntuples(result_.get());
  }
  void reset() override {
    result_.reset();
    values_.clear();
  }

  std::string text(int column) const override {
    return {PQgetvalue(result_.get(), row_, column),
            static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
  }
  std::int64_t integer(int column) const override { return number<std::int64_t>(column); }
  double real(int column) const override { return number<double>(column); }
  bool is_null(int column) const override { return PQgetisnull(result_.get(), row_, column) != 0; }

 private:
  std::optional<std::string>& value(int at) {
    if (values_.size() < static_cast<std::size_t>(at)) values_.resize(static_cast<std::size_t>(at));
    return values_[static_cast<std::size_t>(at - 1)];
  }
  template <class Number>
  [[nodiscard]] Number number(int column) const {
    const char* first = PQgetvalue(result_.get(), row_, column);
    Number value{};
    std::from_chars(first, first + PQgetlength(result_.get(), row_, column), value);
    return value;
  }

  const PqConnection& connection_;
  std::string sql_;
  std::vector<std::optional<std::string>> values_;
  PqResult result_;
  int row_ = -1;
};

class PostgresStore final : public SqlStore {
 public:
  explicit PostgresStore(PqConnection connection) : connection_(std::move(connection)) {}

  Result<void> run(const std::string& sql) override {
    if (auto done = connection_.exec(sql); !done) return fail(done.error());
    return {};
  }
  Result<std::unique_ptr<SqlStatement>> prepare(std::string_view sql) override {
    return std::make_unique<PqStatement>(connection_, sql);
  }
  Result<void> begin() override {
    if (auto begun = run("BEGIN"); !begun) return begun;
    // Released at the end of the transaction in any case.
    auto locked = run(fmt::format("SELECT pg_advisory_xact_lock({})", kWriterLock));
    if (!locked) (void)run("ROLLBACK");
    return locked;
  }
  Result<SqlSchema> schema() override {
    // One statement, which sees the tables of one moment. With two statements, another program may create all
    // tables between them, and our own tables would look like those of another program.
    PqStatement tables(connection_,
                       "SELECT count(*) FILTER (WHERE tablename = 'octant_history'), "
                       "count(*) FILTER (WHERE tablename IN ('document', 'visit', 'beacon')) "
                       "FROM pg_tables WHERE schemaname = current_schema()");
    const auto row = tables.next();
    if (!row) return fail(row.error());
    if (tables.integer(0) == 0) return SqlSchema{0, false, tables.integer(1) == 0};
    PqStatement version(connection_, "SELECT max(version) FROM octant_history");
    const auto found = version.next();
    if (!found) return fail(found.error());
    return SqlSchema{version.integer(0), true, false};
  }
  Result<void> set_version(std::int64_t version) override {
    return run(
        fmt::format("CREATE TABLE IF NOT EXISTS octant_history (version BIGINT NOT NULL); "
                    "DELETE FROM octant_history; INSERT INTO octant_history VALUES ({})",
                    version));
  }
  std::string identity() const override { return "BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY"; }
  std::string name() const override { return connection_.label; }

 private:
  PqConnection connection_;
};

}  // namespace

Result<std::unique_ptr<SqlStore>> open_postgres(const std::string& words, bool create) {
  PqConnection connection;
  connection.handle.reset(PQconnectdb(words.c_str()));
  PGconn* c = connection.handle.get();
  const char* database = c != nullptr ? PQdb(c) : nullptr;
  const char* host = c != nullptr ? PQhost(c) : nullptr;
  connection.label =
      fmt::format("postgresql://{}/{}", host != nullptr ? host : "", database != nullptr ? database : "");
  if (PQstatus(c) != CONNECTION_OK)
    return fail({.file = connection.label,
                 .found = "no connection: " + first_line_of_server(PQerrorMessage(c)),
                 .expected = "a PostgreSQL server that answers, such as postgresql://user@host/database"});
  PQsetClientEncoding(c, "UTF8");
  PQsetNoticeProcessor(
      c, [](void*, const char*) {}, nullptr);
  if (auto set = connection.exec(fmt::format("SET lock_timeout = '{}s'", kPatience_s)); !set)
    return fail(set.error());
  auto store = std::make_unique<PostgresStore>(std::move(connection));
  const auto schema = store->schema();
  if (!schema) return fail(schema.error());
  if (!create && schema->empty)
    return fail({.file = store->name(),
                 .found = "a database without a history",
                 .expected = "one that octant history add has made",
                 .advice = "octant history add DEPLOYMENT.json makes one; --db names it"});
  return store;
}

}  // namespace octant::io

#else

namespace octant::io {

Result<std::unique_ptr<SqlStore>> open_postgres(const std::string&, bool) {
  return fail({.found = "a history on a PostgreSQL server",
               .expected = "an Octant built with -DOCTANT_POSTGRESQL=ON",
               .advice = "name a file with --db; this octant keeps histories in SQLite files"});
}

}  // namespace octant::io

#endif
