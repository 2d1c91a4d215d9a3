// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bags as ROS 2 records them, made here.

#include <cstdint>
#include <string>
#include <vector>

#include <sqlite3.h>

#include "io/bag/cdr.h"
#include "io/bag/ros_messages.h"
#include "io/export/mcap_writer.h"
#include "tests/io/io_support.h"

namespace octant::io::test {

struct RecordedMessage {
  std::string topic, type;
  std::int64_t time_ns = 0;
  std::string data;
};

/// sensor_msgs/msg/Range, field by field as its definition lists them.
inline std::string range_message(std::int64_t stamp_ns, const std::string& frame, float range_m,
                                 float least_m = 0.0F, float most_m = 30.0F) {
  CdrWriter out;
  out.value(static_cast<std::int32_t>(stamp_ns / 1'000'000'000));
  out.value(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000));
  out.text(frame);
  out.value(std::uint8_t{0});
  for (const float number : {0.1F, least_m, most_m, range_m}) out.value(number);
  return out.message();
}

inline void write_database(const std::string& path, const std::vector<RecordedMessage>& messages) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  const auto run = [db](const std::string& sql) {
    ASSERT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
  };
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
      "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
      "data BLOB NOT NULL);BEGIN");
  std::vector<std::string> topics;
  for (const RecordedMessage& m : messages) {
    auto at = std::find(topics.begin(), topics.end(), m.topic);
    if (at == topics.end()) {
      topics.push_back(m.topic);
      at = topics.end() - 1;
      run("INSERT INTO topics VALUES(" + std::to_string(topics.size()) + ",'" + m.topic + "','" + m.type +
          "','cdr','')");
    }
    sqlite3_stmt* insert = nullptr;
    sqlite3_prepare_v2(db, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", -1, &insert,
                       nullptr);
    sqlite3_bind_int64(insert, 1, at - topics.begin() + 1);
    sqlite3_bind_int64(insert, 2, m.time_ns);
    sqlite3_bind_blob(insert, 3, m.data.data(), static_cast<int>(m.data.size()), SQLITE_STATIC);
    EXPECT_EQ(sqlite3_step(insert), SQLITE_DONE);
    sqlite3_finalize(insert);
  }
  run("COMMIT");
  sqlite3_close(db);
}

inline std::string mcap_of(const std::vector<RecordedMessage>& messages) {
  McapWriter out;
  for (const RecordedMessage& m : messages)
    out.message(out.channel(m.topic, {m.type, "ros2msg", "# a definition"}, "cdr"),
                static_cast<std::uint64_t>(m.time_ns), m.data);
  return out.finish();
}

}  // namespace octant::io::test
