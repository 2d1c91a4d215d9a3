// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: messages of recordings of publish-subscribe systems.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "models/support/result.h"

namespace octant::io {

inline constexpr std::size_t kMostTopics = 10'000;
inline constexpr std::size_t kLongestTopic = 1024;                     ///< bytes of a name or type
inline constexpr std::size_t kLargestChunk = std::size_t{256} << 20;   ///< bytes, uncompressed
inline constexpr std::size_t kLargestMessage = std::size_t{64} << 20;  ///< bytes of a row of a database

struct BagTopic {
  std::string name;
  std::string type;      ///< "sensor_msgs/msg/Range"; empty: the bag does not say
  std::string encoding;  ///< encoding of its messages: "cdr", "json"
};

struct BagMessage {
  const BagTopic& topic;
  std::int64_t log_time_ns = 0;  ///< when it was recorded
  std::string_view data;         ///< valid until the next message
};

/// Receives the topics and messages of a bag.
struct BagVisitor {
  /// Returns true if the messages of a topic are wanted; called once for each topic.
  std::function<bool(const BagTopic&)> wants;
  /// Processes one message. An error stops the reader.
  std::function<Result<void>(const BagMessage&)> message;
  /// Metadata by its name (MCAP); may be empty.
  std::function<void(const std::string& name, const std::map<std::string, std::string>&)> metadata;
};

/// Statistics of a bag.
struct BagSummary {
  std::size_t messages = 0;  ///< messages of wanted topics
  std::vector<std::string> warnings;
};

/// Reads a bag in any storage: an MCAP file, a database of rosbag2 (.db3), or a folder of rosbag2 with one or
/// several of them, in the order of their numbers. Errors: kBadInput with the file and its fault; a
/// compressed database, with the command that decompresses it.
[[nodiscard]] Result<BagSummary> read_bag(const std::string& path, const BagVisitor& visitor);
/// Returns true if a path looks like a bag, by the content of the file or by the files of the folder.
[[nodiscard]] bool is_bag(const std::string& path);

// The two kinds of storage; each adds to a summary.
[[nodiscard]] Result<void> read_mcap(const std::string& path, const BagVisitor& visitor, BagSummary& summary);
[[nodiscard]] Result<void> read_bag_database(const std::string& path, const BagVisitor& visitor,
                                             BagSummary& summary);

/// Eight bytes at both ends of an MCAP file.
inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

}  // namespace octant::io
