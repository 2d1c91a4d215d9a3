// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: an MCAP file in memory.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace octant::io {

struct McapSchema {
  std::string name, encoding, text;  ///< "nav_msgs/msg/Odometry", "ros2msg" or "jsonschema", the definition
};

/// Writes MCAP, version 0: uncompressed chunks of about a megabyte, which every reader supports; an index of
/// the messages after each chunk; a summary with schemas, channels, statistics and the index of chunks;
/// checksums of chunks, data section and summary.
class McapWriter {
 public:
  McapWriter();
  /// Number of a topic; the same number for the same topic. At most 65,535 of them.
  std::uint16_t channel(const std::string& topic, const McapSchema& schema, const std::string& encoding);
  void message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data);
  void metadata(const std::string& name, const std::map<std::string, std::string>& values);
  /// Finishes the file and returns its content; afterwards no message may be added.
  [[nodiscard]] std::string finish();

 private:
  struct Index {
    std::uint16_t channel;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> entries;  ///< time, offset within the chunk
  };
  struct Channel {
    std::uint16_t schema = 0;
    std::string topic, encoding;
    std::uint32_t messages = 0;
  };
  struct Span {
    std::uint64_t first_ns = 0, last_ns = 0;
    bool any = false;
    void add(std::uint64_t time_ns);
  };

  [[nodiscard]] std::string schema_record(std::size_t number) const;
  [[nodiscard]] std::string channel_record(std::size_t number) const;
  [[nodiscard]] std::string statistics() const;
  void end_chunk();

  std::string file_, chunk_, chunk_index_, metadata_index_;
  std::vector<McapSchema> schemas_;
  std::vector<Channel> channels_;
  std::map<std::string, std::uint16_t> by_topic_;
  std::map<std::string, std::uint16_t> by_schema_;
  std::vector<Index> index_;
  Span chunk_span_, span_;
  std::uint32_t chunks_ = 0, metadata_ = 0;
  std::uint64_t messages_ = 0;
};

}  // namespace octant::io
