// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/bag_log.h"

#include <cstring>

#include <lz4frame.h>
#include <zstd.h>

#include "io/bag/bag.h"
#include "io/bag/mcap_records.h"
#include "tests/io/bag/bag_support.h"

namespace octant::io::test {
namespace bag_log_test {

using ::testing::HasSubstr;

constexpr std::int64_t kStart_ns = 1'700'000'000'123'456'789;

/// Ranges to two beacons by two receivers, odometry along a curve, a motion capture's poses, one echo
/// sounder.
std::vector<RecordedMessage> drive() {
  std::vector<RecordedMessage> bag;
  for (int k = 0; k < 40; ++k) {
    const std::int64_t t = kStart_ns + k * 50'000'000LL;
    const Pose T = Pose::planar(0.1 * k, 0.02 * k * k, 0.05 * k);
    bag.push_back({"/uwb/front/A1", std::string(kRosRange), t + 2'000'000,
                   range_message(t, "anchor_A1", 2.5F + 0.01F * k)});
    bag.push_back({"/uwb/rear/A2", std::string(kRosRange), t + 2'500'000,
                   range_message(t + 500'000, "anchor_A2", 7.25F)});
    bag.push_back({"/odom", std::string(kRosOdometry), t, ros_odometry(t, "odom", "base_link", T)});
    bag.push_back({"/mocap", std::string(kRosPoseWithCovariance), t,
                   ros_pose_with_covariance(t, "map", T, PoseCovariance::Identity(3, 3))});
  }
  bag.push_back({"/sonar", std::string(kRosRange), kStart_ns, range_message(kStart_ns, "sonar", 1.0F)});
  return bag;
}

TopicMapping topics(const char* words) {
  const auto mapping = topics_from_words(words);
  EXPECT_TRUE(mapping) << mapping.error().message();
  return mapping.value_or(TopicMapping{});
}

constexpr const char* kTopics = "range=/uwb/{receiver}/{beacon},odometry=/odom,poses=/mocap";

void expect_the_drive(const ImportedLog& log) {
  ASSERT_EQ(log.arrivals.size(), 80U);
  EXPECT_EQ(log.arrivals[0].time_s, 1700000000.123456789);
  EXPECT_EQ(log.arrivals[0].value, 2.5);
  EXPECT_TRUE(log.arrivals[0].is_distance);
  EXPECT_EQ(log.names.all()[static_cast<std::size_t>(log.arrivals[1].beacon)], "A2");
  EXPECT_EQ(log.names.all()[static_cast<std::size_t>(log.arrivals[1].receiver)], "rear");
  ASSERT_EQ(log.odometry.size(), 40U);
  ASSERT_EQ(log.poses.size(), 40U);
  EXPECT_EQ(log.poses[3].T_map_vehicle.translation_m.x(), 0.1 * 3);
  EXPECT_NEAR(log.odometry[7].T_map_vehicle.heading_rad(), 0.35, 1e-15);
}

TEST(BagLog, ADatabaseAndAnMcapFileTellTheSame) {
  const TemporaryFolder box;
  write_database(box.path("drive_0.db3"), drive());
  box.write("drive.mcap", mcap_of(drive()));
  for (const char* name : {"drive_0.db3", "drive.mcap"}) {
    ASSERT_TRUE(is_bag(box.path(name)));
    const auto log = read_bag_log(box.path(name), topics(kTopics));
    ASSERT_TRUE(log) << name << log.error().message();
    expect_the_drive(*log);
    EXPECT_TRUE(log->warnings.empty());
  }
}

TEST(BagLog, AFolderOfSeveralFilesIsOneRecording) {
  const TemporaryFolder box;
  const auto all = drive();
  const auto half = all.begin() + 80;
  box.write("bag/bag_2.mcap", mcap_of({all.begin(), half}));
  write_database(box.path("bag/bag_10.db3"), {half, all.end()});
  const auto log = read_bag_log(box.path("bag"), topics(kTopics));
  ASSERT_TRUE(log) << log.error().message();
  expect_the_drive(*log);
}

/// The file with its chunk compressed. An MCAP as this writer makes it begins with header and one chunk.
std::string compressed(std::string file, const std::string& by, std::uint64_t said_size = 0) {
  const auto u64 = [&](std::size_t at) {
    std::uint64_t value = 0;
    std::memcpy(&value, file.data() + at, 8);
    return value;
  };
  const auto bytes = [](std::uint64_t value, std::size_t size) {
    return std::string(reinterpret_cast<const char*>(&value), size);
  };
  const std::size_t chunk = kMcapMagic.size() + kMcapHead + u64(kMcapMagic.size() + 1);
  EXPECT_EQ(file[chunk], static_cast<char>(McapOp::kChunk));
  const std::size_t content = chunk + kMcapHead, records = content + 8 + 8 + 8 + 4 + 4 + 8;
  const std::uint64_t size = u64(content + 16);
  std::string packed(size + 1024, '\0');
  packed.resize(by == "lz4"
                    ? LZ4F_compressFrame(packed.data(), packed.size(), file.data() + records, size, nullptr)
                    : ZSTD_compress(packed.data(), packed.size(), file.data() + records, size, 3));
  const std::string body = file.substr(content, 16) + bytes(said_size != 0 ? said_size : size, 8) +
                           file.substr(content + 24, 4) + bytes(by.size(), 4) + by + bytes(packed.size(), 8) +
                           packed;
  return file.substr(0, chunk) + std::string(1, static_cast<char>(McapOp::kChunk)) + bytes(body.size(), 8) +
         body + file.substr(content + u64(chunk + 1));
}

TEST(BagLog, CompressedChunksAreUnpacked) {
  const TemporaryFolder box;
  for (const std::string by : {"lz4", "zstd"}) {
    const std::string file = compressed(mcap_of(drive()), by);
    EXPECT_LT(file.size(), mcap_of(drive()).size());
    const auto log = read_bag_log(box.write(by + ".mcap", file), topics(kTopics));
    ASSERT_TRUE(log) << by << log.error().message();
    expect_the_drive(*log);
    // A size that is not true takes no memory and is refused.
    for (const std::uint64_t said : {std::uint64_t{1} << 60, std::uint64_t{100}, kLargestChunk})
      expect_error(
          read_bag_log(box.write("bad.mcap", compressed(mcap_of(drive()), by, said)), topics(kTopics)), 0,
          "a chunk that");
  }
}

TEST(BagLog, TransformsAndTheOtherByteOrder) {
  const TemporaryFolder box;
  CdrWriter tf;
  tf.value(std::uint32_t{2});
  for (const char* child : {"base_link", "gripper"}) {
    tf.value(std::int32_t{12});
    tf.value(std::uint32_t{500'000'000});
    tf.text("map");
    tf.text(child);
    for (const double v : {1.0, 2.0, 0.5, 0.0, 0.0, 0.6, 0.8}) tf.value(v);
  }
  const auto log = read_bag_log(
      box.write("tf.mcap", mcap_of({{"/tf", std::string(kRosTransforms), kStart_ns, tf.message()}})),
      topics("truth=/tf@map>base_link"));
  ASSERT_TRUE(log) << log.error().message();
  ASSERT_EQ(log->truth.size(), 1U);
  EXPECT_EQ(log->truth[0].time_s, 12.5);
  EXPECT_NEAR(log->truth[0].T_map_vehicle.heading_rad(), 2 * std::atan2(0.6, 0.8), 1e-15);
  // A range of 2.5 m, big-endian, as the standard encodes it.
  const unsigned char bytes[] = {0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 0,    0,    0, 0, 0,    2,    'A', 0,
                                 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x41, 0x20, 0, 0, 0x40, 0x20, 0,   0};
  const auto range = range_of({reinterpret_cast<const char*>(bytes), sizeof(bytes)});
  ASSERT_TRUE(range);
  EXPECT_EQ(range->stamp_s, 7.0);
  EXPECT_EQ(range->frame, "A");
  EXPECT_EQ(range->range_m, 2.5);
  EXPECT_TRUE(range->measured);
}

TEST(BagLog, WhatTopicsAreIsFoundOutWhereNobodySays) {
  const TemporaryFolder box;
  auto bag = drive();
  std::erase_if(bag, [](const RecordedMessage& m) { return m.topic == "/sonar"; });
  write_database(box.path("bag.db3"), bag);
  const auto mapping = topics_by_type(box.path("bag.db3"));
  ASSERT_TRUE(mapping) << mapping.error().message();
  const auto log = read_bag_log(box.path("bag.db3"), *mapping);
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_EQ(log->arrivals.size(), 80U);
  EXPECT_EQ(log->names.all()[0], "anchor_A1");
  EXPECT_EQ(log->odometry.size(), 40U);
  EXPECT_TRUE(log->poses.empty()) << "whether poses are measured nobody can tell from their type";
}

TEST(BagLog, ANeighboursBeaconsAndWhatWasNotMeasuredAreCounted) {
  const TemporaryFolder box;
  std::vector<RecordedMessage> bag = {
      {"/r", std::string(kRosRange), 1, range_message(1'000'000'000, "A1", 3.0F)},
      {"/r", std::string(kRosRange), 2, range_message(1'100'000'000, "N1", 4.0F)},
      {"/r", std::string(kRosRange), 3, range_message(1'200'000'000, "A1", INFINITY)},
      {"/r", std::string(kRosRange), 4, range_message(1'300'000'000, "A1", 31.0F)},
      {"/r", std::string(kRosRange), 5, range_message(950'000'000, "A2", 5.0F)},
      {"/r", std::string(kRosRange), 1'400'000'000, range_message(0, "A2", 5.0F)}};
  TopicMapping mapping = topics("range=/r@{beacon}");
  mapping.ignore = {"N1"};
  auto log = read_bag_log(box.write("a.mcap", mcap_of(bag)), mapping);
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_EQ(log->ignored.at("N1"), 1U);
  EXPECT_EQ(log->not_heard, 2U);
  const auto files = run_files(*log, "run", {});
  ASSERT_TRUE(files);
  EXPECT_EQ((*files)[0].content, "time_s,beacon,distance_m\n0.95,A2,5\n1,A1,3\n1.4,A2,5\n")
      << "in order; a message without a stamp has the time at which it was recorded";
  EXPECT_EQ(log->warnings.size(), 3U) << "of the neighbour, of what was not measured, of the order";
  const auto times = run_files(*log, "run", 300.0);
  ASSERT_TRUE(times);
  EXPECT_THAT((*times)[0].content, HasSubstr("\n1,A1,0.01\n"));
}

TEST(BagLog, FaultsAreNamed) {
  const TemporaryFolder box;
  const std::string good = mcap_of(drive());
  const auto fault = [&](const std::string& file, const char* words = kTopics) {
    const auto log = read_bag_log(box.write("bad.mcap", file), topics(words));
    return log ? std::string() : log.error().message();
  };
  EXPECT_THAT(fault(good, "odometry=/odometry"), HasSubstr("no topic /odometry"));
  EXPECT_THAT(fault(good, "odometry=/odometry"), HasSubstr("/odom (nav_msgs/msg/Odometry)"));
  EXPECT_THAT(fault(good, "odometry=/sonar"), HasSubstr("of type 'sensor_msgs/msg/Range' as poses"));
  EXPECT_THAT(fault(good, "range:A1=/odom"), HasSubstr("as ranges"));
  EXPECT_THAT(fault(good, "poses=/mocap@world>robot"), HasSubstr("has no pose of 'robot' in 'world'"));
  EXPECT_THAT(fault("no bag"), HasSubstr("neither the first bytes"));
  std::string damaged = good;
  damaged[200] = static_cast<char>(damaged[200] ^ 1);
  EXPECT_THAT(fault(damaged), HasSubstr("checksum"));
  // A truncated file: the rows before the end are used.
  const auto cut =
      read_bag_log(box.write("cut.mcap", good.substr(0, good.size() / 2)), topics("range=/*@{beacon}"));
  ASSERT_TRUE(cut) << cut.error().message();
  EXPECT_THAT(cut->warnings.back(), HasSubstr("the file ends within its data"));

  const auto message = [&](std::string type, std::string data) {
    return fault(mcap_of({{"/t", std::move(type), 1, std::move(data)}}), "poses=/t");
  };
  const std::string pose = ros_pose(1, "map", Pose::planar(1, 2, 3));
  EXPECT_EQ(message(std::string(kRosPose), pose), "");
  for (std::size_t size = 0; size < pose.size(); ++size)
    ASSERT_THAT(message(std::string(kRosPose), pose.substr(0, size)),
                HasSubstr("is no geometry_msgs/msg/PoseStamped"));
  // Four billion transforms in twelve bytes.
  EXPECT_THAT(message(std::string(kRosTransforms), std::string("\0\1\0\0\xFF\xFF\xFF\xFF\0\0\0\0", 12)),
              HasSubstr("message 1 of topic /t"));
  std::string odd = pose;
  odd[1] = 3;
  EXPECT_THAT(message(std::string(kRosPose), odd), HasSubstr("is no")) << "a parameter list";
}

TEST(BagLog, NamesAndTopicsAreBounded) {
  const TemporaryFolder box;
  std::vector<RecordedMessage> many;
  for (int k = 0; k <= 10'000; ++k)
    many.push_back({"/r", std::string(kRosRange), k, range_message(k, "A" + std::to_string(k), 1.0F)});
  expect_error(read_bag_log(box.write("names.mcap", mcap_of(many)), topics("range=/r@{beacon}")), 0,
               "more than 10000 names");
  for (int k = 0; k <= 10'000; ++k) many[static_cast<std::size_t>(k)].topic = "/r" + std::to_string(k);
  expect_error(read_bag_log(box.write("topics.mcap", mcap_of(many)), topics("range=/*@{beacon}")), 0,
               "more than 10000 topics");
}

TEST(BagLog, ADatabaseThatIsNoneOfRosIsRefused) {
  const TemporaryFolder box;
  const auto made = [&](const char* name, const char* sql) {
    sqlite3* db = nullptr;
    sqlite3_open(box.path(name).c_str(), &db);
    EXPECT_EQ(sqlite3_exec(db, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
    return box.path(name);
  };
  expect_error(read_bag_log(made("a.db3", "CREATE TABLE t(x)"), topics(kTopics)), 0,
               "without tables 'topics' and 'messages'");
  // A view that never ends, in place of a table.
  expect_error(
      read_bag_log(
          made("b.db3",
               "CREATE TABLE topics(id, name, type, serialization_format);CREATE VIEW messages AS WITH "
               "RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x+1 FROM n) SELECT x AS topic_id, x AS "
               "timestamp, x AS data FROM n"),
          topics(kTopics)),
      0, "without tables");
  write_database(box.path("c.db3"), drive());
  std::string torn = box.read("c.db3");
  for (std::size_t i = 5000; i < torn.size(); i += 3) torn[i] = static_cast<char>(i);
  EXPECT_FALSE(read_bag_log(box.write("d.db3", torn), topics(kTopics)));
}

}  // namespace bag_log_test
}  // namespace octant::io::test
