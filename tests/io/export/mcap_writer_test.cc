// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Against the specification (mcap.dev/spec), record by record, with a reader of its own.
#include "io/export/mcap_writer.h"

#include <zlib.h>

#include <set>

#include "io/bag/bag.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace mcap_writer_test {

std::uint64_t number(const std::string& text, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes; i-- > 0;) value = value << 8 | static_cast<unsigned char>(text.at(at + i));
  return value;
}
std::uint32_t crc_of(const std::string& text) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size()));
}

struct Record {
  int op = 0;
  std::size_t at = 0;
  std::string content;
  [[nodiscard]] std::uint64_t u(std::size_t begin, std::size_t bytes) const {
    return number(content, begin, bytes);
  }
  /// The text with its preceding length, and its end.
  [[nodiscard]] std::string text(std::size_t& begin) const {
    const std::size_t size = u(begin, 4);
    const std::string out = content.substr(begin + 4, size);
    begin += 4 + size;
    return out;
  }
};

std::vector<Record> records_of(const std::string& text, std::size_t begin, std::size_t end) {
  std::vector<Record> records;
  for (std::size_t at = begin; at < end;) {
    const std::size_t length = number(text, at + 1, 8);
    records.push_back({static_cast<unsigned char>(text.at(at)), at, text.substr(at + 9, length)});
    at += 9 + length;
    EXPECT_LE(at, end);
  }
  return records;
}

std::vector<Record> records_of(const std::string& file) {
  const std::string magic = "\x89MCAP0\r\n";
  EXPECT_TRUE(file.starts_with(magic) && file.ends_with(magic));
  return records_of(file, magic.size(), file.size() - magic.size());
}

std::vector<Record> of_kind(const std::vector<Record>& records, int op) {
  std::vector<Record> some;
  for (const Record& r : records)
    if (r.op == op) some.push_back(r);
  return some;
}

const McapSchema kRows{"octant.Row", "jsonschema", "{}"};

/// Messages of three topics, out of the order of time, enough for several chunks; metadata between them.
std::string some_file(std::size_t messages) {
  McapWriter out;
  for (std::size_t i = 0; i < messages; ++i) {
    const std::string topic = "/t" + std::to_string(i % 3);
    const auto channel = out.channel(topic, kRows, "json");
    out.message(channel, 1'000 + (i * 7919) % 1009,
                std::string(1 + i % 5000, static_cast<char>('a' + i % 26)));
    if (i == messages / 2) out.metadata("octant.run", {{"b", "2"}, {"a", "1"}});
  }
  return out.finish();
}

TEST(McapWriter, ChunksHoldWhatTheySay) {
  const auto records = records_of(some_file(1500));
  const auto chunks = of_kind(records, 6);
  EXPECT_GE(chunks.size(), 2U);
  std::set<std::uint64_t> channels_known;
  for (const Record& chunk : chunks) {
    std::size_t at = 28;
    EXPECT_EQ(chunk.text(at), "") << "not compressed";
    const std::uint64_t size = chunk.u(at, 8);
    EXPECT_EQ(chunk.u(16, 8), size);
    const std::string content = chunk.content.substr(at + 8);
    EXPECT_EQ(content.size(), size);
    EXPECT_EQ(chunk.u(24, 4), crc_of(content));
    std::uint64_t first = ~0ULL, last = 0;
    for (const Record& r : records_of(content, 0, content.size())) {
      if (r.op == 4) channels_known.insert(r.u(0, 2));
      if (r.op != 5) continue;
      EXPECT_TRUE(channels_known.contains(r.u(0, 2))) << "a channel stands before its messages";
      first = std::min(first, r.u(6, 8)), last = std::max(last, r.u(6, 8));
    }
    EXPECT_EQ(chunk.u(0, 8), first);
    EXPECT_EQ(chunk.u(8, 8), last);
  }
}

TEST(McapWriter, EveryMessageIsFoundByItsIndex) {
  const std::string file = some_file(1500);
  std::size_t found = 0;
  const Record* chunk = nullptr;
  const auto records = records_of(file);
  for (const Record& r : records) {
    if (r.op == 6) chunk = &r;
    if (r.op != 7) continue;
    ASSERT_NE(chunk, nullptr);
    const std::string content = chunk->content.substr(28 + 4 + 8);
    std::uint64_t before = 0;
    EXPECT_EQ(r.u(2, 4), r.content.size() - 6);
    for (std::size_t at = 6; at < r.content.size(); at += 16, ++found) {
      const std::uint64_t time_ns = r.u(at, 8), offset = r.u(at + 8, 8);
      EXPECT_GE(time_ns, before) << "in the order of time";
      before = time_ns;
      EXPECT_EQ(content.at(offset), 5) << "a message begins there";
      EXPECT_EQ(number(content, offset + 9, 2), r.u(0, 2)) << "of this channel";
      EXPECT_EQ(number(content, offset + 9 + 6, 8), time_ns);
    }
  }
  EXPECT_EQ(found, 1500U);
}

TEST(McapWriter, TheSummaryLeadsToEachChunkAndItsIndices) {
  const std::string file = some_file(1500);
  const auto records = records_of(file);
  const auto chunks = of_kind(records, 6), in_summary = of_kind(records, 8);
  ASSERT_EQ(in_summary.size(), chunks.size());
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const Record& index = in_summary[i];
    EXPECT_EQ(index.u(0, 8), chunks[i].u(0, 8));
    EXPECT_EQ(index.u(8, 8), chunks[i].u(8, 8));
    EXPECT_EQ(index.u(16, 8), chunks[i].at);
    EXPECT_EQ(index.u(24, 8), chunks[i].content.size() + 9);
    const std::size_t offsets = index.u(32, 4);
    std::size_t first = file.size();
    for (std::size_t at = 36; at < 36 + offsets; at += 10) {
      const std::size_t where = index.u(at + 2, 8);
      EXPECT_EQ(file.at(where), 7) << "a message index";
      EXPECT_EQ(number(file, where + 9, 2), index.u(at, 2));
      first = std::min(first, where);
    }
    EXPECT_EQ(first, chunks[i].at + 9 + chunks[i].content.size()) << "right behind the chunk";
  }
  const auto metadata = of_kind(records, 12), where = of_kind(records, 13);
  ASSERT_EQ(metadata.size(), 1U);
  EXPECT_EQ(where.at(0).u(0, 8), metadata[0].at);
  EXPECT_EQ(where.at(0).u(8, 8), metadata[0].content.size() + 9);
}

TEST(McapWriter, TheFooterLeadsToTheSummaryAndChecksIt) {
  const std::string file = some_file(100);
  const auto records = records_of(file);
  const Record &footer = records.back(), data_end = of_kind(records, 15).at(0);
  ASSERT_EQ(footer.op, 2);
  const std::size_t summary = footer.u(0, 8), offsets = footer.u(8, 8);
  EXPECT_EQ(summary, data_end.at + 9 + 4) << "right behind the data";
  EXPECT_EQ(data_end.u(0, 4), crc_of(file.substr(0, data_end.at)));
  // Checksum of the summary and the footer up to the checksum itself.
  EXPECT_EQ(footer.u(16, 4), crc_of(file.substr(summary, footer.at + 9 + 16 - summary)));
  for (const Record& r : records) {
    if (r.op != 14) continue;
    EXPECT_GE(r.at, offsets);
    const std::size_t begin = r.u(1, 8), length = r.u(9, 8);
    for (const Record& of : records_of(file, begin, begin + length))
      EXPECT_EQ(of.op, static_cast<int>(r.u(0, 1))) << "a group is of one kind";
  }
}

TEST(McapWriter, StatisticsCountWhatIsThere) {
  const auto records = records_of(some_file(1500));
  const Record s = of_kind(records, 11).at(0);
  EXPECT_EQ(s.u(0, 8), 1500U);
  EXPECT_EQ(s.u(8, 2), 1U) << "schemas";
  EXPECT_EQ(s.u(10, 4), 3U) << "channels";
  EXPECT_EQ(s.u(14, 4), 0U) << "attachments";
  EXPECT_EQ(s.u(18, 4), 1U) << "metadata";
  EXPECT_EQ(s.u(22, 4), of_kind(records, 6).size());
  EXPECT_EQ(s.u(26, 8), 1000U) << "1009 is prime: all remainders come";
  EXPECT_EQ(s.u(34, 8), 2008U);
  EXPECT_EQ(s.u(42, 4), 30U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(s.u(46 + 10 * i + 2, 8), 500U) << "messages of a channel";
}

TEST(McapWriter, AnEmptyFileIsAFile) {
  const auto records = records_of(McapWriter().finish());
  EXPECT_TRUE(of_kind(records, 6).empty());
  EXPECT_EQ(of_kind(records, 11).at(0).u(0, 8), 0U);
}

TEST(McapWriter, ATopicIsOneChannelHoweverOftenItIsAsked) {
  McapWriter out;
  EXPECT_EQ(out.channel("/a", kRows, "json"), 0);
  EXPECT_EQ(out.channel("/b", kRows, "json"), 1);
  EXPECT_EQ(out.channel("/a", kRows, "json"), 0);
  EXPECT_EQ(out.channel("/c", {"nav_msgs/msg/Odometry", "ros2msg", "#"}, "cdr"), 2);
  const auto records = records_of(out.finish());
  std::set<std::string> types;
  for (const Record& r : of_kind(records, 3)) {
    std::size_t at = 2;
    EXPECT_NE(r.u(0, 2), 0U) << "0 stands for no schema";
    types.insert(r.text(at));
  }
  EXPECT_EQ(types, (std::set<std::string>{"octant.Row", "nav_msgs/msg/Odometry"}));
}

/// The reader of bags makes the same messages of it.
TEST(McapWriter, ReadsBackMessageByMessage) {
  const test::TemporaryFolder folder;
  const std::string path = folder.write("a.mcap", some_file(1500));
  std::map<std::string, std::size_t> messages;
  std::map<std::string, std::string> metadata;
  const auto summary = read_bag(path, {.wants = [](const BagTopic& t) { return t.name != "/t1"; },
                                       .message =
                                           [&](const BagMessage& m) {
                                             EXPECT_EQ(m.topic.type, "octant.Row");
                                             EXPECT_EQ(m.topic.encoding, "json");
                                             messages[m.topic.name] += m.data.size();
                                             return Result<void>();
                                           },
                                       .metadata =
                                           [&](const std::string& name, const auto& values) {
                                             EXPECT_EQ(name, "octant.run");
                                             metadata = values;
                                           }});
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(summary->messages, 1000U) << "those that were wanted";
  std::map<std::string, std::size_t> expected;
  for (std::size_t i = 0; i < 1500; ++i)
    if (i % 3 != 1) expected["/t" + std::to_string(i % 3)] += 1 + i % 5000;
  EXPECT_EQ(messages, expected);
  EXPECT_EQ(metadata, (std::map<std::string, std::string>{{"a", "1"}, {"b", "2"}}));
}

}  // namespace mcap_writer_test
}  // namespace octant::io
