// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// rosbag2's SQLite storage: a table of topics and one of messages.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <unordered_map>

#include <fmt/format.h>
#include <sqlite3.h>

#include "io/bag/bag.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

/// Steps of SQLite's virtual machine between two checks of the elapsed work.
constexpr int kStepsALook = 100'000;

/// Path as an SQLite URI: read-only, and without looking for a write-ahead log.
std::string uri_of(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri + "?mode=ro&immutable=1";
}

class BagDatabase {
 public:
  BagDatabase(const std::string& path, const BagVisitor& visitor, BagSummary& summary)
      : path_(path), visitor_(visitor), summary_(summary) {}
  BagDatabase(const BagDatabase&) = delete;
  BagDatabase& operator=(const BagDatabase&) = delete;
  ~BagDatabase() { sqlite3_close_v2(db_); }

  Result<void> read() {
    if (sqlite3_open_v2(uri_of(path_).c_str(), &db_, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr) !=
        SQLITE_OK)
      return failure();
    std::error_code ignored;
    if (std::filesystem::file_size(path_ + "-wal", ignored) > 0 && !ignored)
      summary_.warnings.push_back(path_ + "-wal: what the recorder did not write into the bag is left out");
    // The file comes from outside: no function or trigger that it defines may run, and sizes are limited.
    sqlite3_db_config(db_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(db_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(db_, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_db_config(db_, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    sqlite3_limit(db_, SQLITE_LIMIT_LENGTH, static_cast<int>(kLargestMessage));
    sqlite3_progress_handler(db_, kStepsALook, &BagDatabase::look, this);
    if (auto fit = check_tables(); !fit) return fit;
    if (auto topics = read_topics(); !topics) return topics;
    return read_messages();
  }

 private:
  using Rows = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

  /// Interrupts a query that runs for long between two rows: no bag needs one.
  static int look(void* self) { return ++static_cast<BagDatabase*>(self)->looks_ > 20'000 ? 1 : 0; }

  tl::unexpected<Error> failure() const {
    const int code = sqlite3_errcode(db_) & 0xFF;
    Error error{.file = path_, .expected = "a bag as rosbag2 writes it"};
    error.found = code == SQLITE_NOTADB                           ? "no SQLite database"
                  : code == SQLITE_CORRUPT                        ? "a damaged database"
                  : code == SQLITE_TOOBIG || code == SQLITE_NOMEM ? "a value of more than 64 MiB"
                  : code == SQLITE_INTERRUPT
                      ? "a query that does not end"
                      : fmt::format("the database says: {}", in_quotes(sqlite3_errmsg(db_)));
    if (code == SQLITE_CORRUPT) error.advice = "`sqlite3 FILE .recover` may save the rest";
    return fail(error);
  }

  Rows query(const char* sql) const {
    sqlite3_stmt* rows = nullptr;
    sqlite3_prepare_v2(db_, sql, -1, &rows, nullptr);
    return {rows, &sqlite3_finalize};
  }
  static std::string_view text(const Rows& rows, int column) {
    const auto* words = reinterpret_cast<const char*>(sqlite3_column_text(rows.get(), column));
    return words == nullptr
               ? std::string_view()
               : std::string_view(words, static_cast<std::size_t>(sqlite3_column_bytes(rows.get(), column)));
  }
  /// Returns true if there is a row; an error if the database is damaged.
  Result<bool> next(const Rows& rows) {
    looks_ = 0;
    const int code = rows == nullptr ? SQLITE_ERROR : sqlite3_step(rows.get());
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    return failure();
  }

  Result<void> check_tables() {
    const Rows rows =
        query("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')");
    const auto there = next(rows);
    if (!there) return fail(there.error());
    if (sqlite3_column_int(rows.get(), 0) == 2) return {};
    return fail({.file = path_,
                 .found = "a database without tables 'topics' and 'messages'",
                 .expected = "a bag as rosbag2 writes it"});
  }

  Result<void> read_topics() {
    const Rows rows = query("SELECT id, name, type, serialization_format FROM topics");
    for (;;) {
      const auto more = next(rows);
      if (!more) return fail(more.error());
      if (!*more) return {};
      BagTopic topic{std::string(text(rows, 1)), std::string(text(rows, 2)), std::string(text(rows, 3))};
      if (topics_.size() >= kMostTopics)
        return fail({.file = path_,
                     .found = fmt::format("more than {} topics", kMostTopics),
                     .expected = "a recording of a robot"});
      if (topic.name.size() > kLongestTopic || topic.type.size() > kLongestTopic)
        return fail({.file = path_,
                     .found = fmt::format("a topic whose name has {} bytes",
                                          std::max(topic.name.size(), topic.type.size())),
                     .expected = fmt::format("at most {}", kLongestTopic)});
      if (visitor_.wants(topic)) topics_.emplace(sqlite3_column_int64(rows.get(), 0), std::move(topic));
    }
  }

  Result<void> read_messages() {
    const Rows rows = query("SELECT topic_id, timestamp, data FROM messages");
    for (;;) {
      const auto more = next(rows);
      if (!more) return fail(more.error());
      if (!*more) return {};
      const auto topic = topics_.find(sqlite3_column_int64(rows.get(), 0));
      if (topic == topics_.end()) continue;
      ++summary_.messages;
      const auto* data = static_cast<const char*>(sqlite3_column_blob(rows.get(), 2));
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(rows.get(), 2));
      if (auto taken =
              visitor_.message({topic->second, sqlite3_column_int64(rows.get(), 1),
                                data == nullptr ? std::string_view() : std::string_view(data, size)});
          !taken)
        return taken;
    }
  }

  const std::string& path_;
  const BagVisitor& visitor_;
  BagSummary& summary_;
  sqlite3* db_ = nullptr;
  int looks_ = 0;
  std::unordered_map<std::int64_t, BagTopic> topics_;
};

}  // namespace

Result<void> read_bag_database(const std::string& path, const BagVisitor& visitor, BagSummary& summary) {
  return BagDatabase(path, visitor, summary).read();
}

}  // namespace octant::io
