// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/export/mcap_writer.h"

#include <algorithm>
#include <concepts>

#include <zlib.h>

#include "io/bag/bag.h"
#include "io/bag/mcap_records.h"

namespace octant::io {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

template <std::integral T>
void put(std::string& out, T number) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint64_t>(number) >> (8 * i) & 0xFF);
}
void put(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}
/// Consecutive fields: numbers little-endian with the width of their type, texts after their length.
template <class... Fields>
std::string fields(const Fields&... field) {
  std::string out;
  (put(out, field), ...);
  return out;
}
void put_record(std::string& out, McapOp op, std::string_view content) {
  out += fields(static_cast<std::uint8_t>(op), content.size());
  out += content;
}
std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

void McapWriter::Span::add(std::uint64_t time_ns) {
  first_ns = any ? std::min(first_ns, time_ns) : time_ns;
  last_ns = any ? std::max(last_ns, time_ns) : time_ns;
  any = true;
}

McapWriter::McapWriter() : file_(kMcapMagic) {
  // No profile: `ros2` would promise that all channels are CDR.
  put_record(file_, McapOp::kHeader, fields("", "octant"));
}

std::string McapWriter::schema_record(std::size_t number) const {
  const McapSchema& s = schemas_[number];
  return fields(static_cast<std::uint16_t>(number + 1), s.name, s.encoding, s.text);
}

std::string McapWriter::channel_record(std::size_t number) const {
  const Channel& c = channels_[number];
  // The last text is the metadata, an empty map.
  return fields(static_cast<std::uint16_t>(number), c.schema, c.topic, c.encoding, "");
}

std::uint16_t McapWriter::channel(const std::string& topic, const McapSchema& schema,
                                  const std::string& encoding) {
  const auto known = by_topic_.find(topic);
  if (known != by_topic_.end()) return known->second;
  auto [at, fresh] = by_schema_.try_emplace(schema.name, static_cast<std::uint16_t>(schemas_.size() + 1));
  if (fresh) {
    schemas_.push_back(schema);
    put_record(chunk_, McapOp::kSchema, schema_record(schemas_.size() - 1));
  }
  const auto id = static_cast<std::uint16_t>(channels_.size());
  channels_.push_back({at->second, topic, encoding});
  put_record(chunk_, McapOp::kChannel, channel_record(id));
  return by_topic_[topic] = id;
}

void McapWriter::message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data) {
  auto index = std::ranges::find(index_, channel, &Index::channel);
  if (index == index_.end()) index = index_.insert(index_.end(), {channel, {}});
  index->entries.emplace_back(time_ns, chunk_.size());
  put_record(chunk_, McapOp::kMessage,
             fields(channel, channels_[channel].messages++, time_ns, time_ns).append(data));
  chunk_span_.add(time_ns);
  span_.add(time_ns);
  ++messages_;
  if (chunk_.size() >= kChunkBytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  const std::uint64_t begin = file_.size();
  put_record(
      file_, McapOp::kChunk,
      fields(chunk_span_.first_ns, chunk_span_.last_ns, chunk_.size(), checksum(chunk_), "", chunk_.size())
          .append(chunk_));
  const std::uint64_t length = file_.size() - begin, indices = file_.size();
  std::string offsets;
  for (Index& index : index_) {
    std::ranges::sort(index.entries);
    offsets += fields(index.channel, file_.size());
    std::string entries;
    for (const auto& [time_ns, offset] : index.entries) entries += fields(time_ns, offset);
    put_record(file_, McapOp::kMessageIndex, fields(index.channel, entries));
  }
  put_record(chunk_index_, McapOp::kChunkIndex,
             fields(chunk_span_.first_ns, chunk_span_.last_ns, begin, length, offsets, file_.size() - indices,
                    "", chunk_.size(), chunk_.size()));
  ++chunks_;
  chunk_.clear();
  index_.clear();
  chunk_span_ = {};
}

void McapWriter::metadata(const std::string& name, const std::map<std::string, std::string>& values) {
  end_chunk();  // metadata do not stand in chunks
  std::string pairs;
  for (const auto& [key, value] : values) pairs += fields(key, value);
  const std::string record = fields(name, pairs);
  const std::uint64_t begin = file_.size();
  put_record(file_, McapOp::kMetadata, record);
  put_record(metadata_index_, McapOp::kMetadataIndex, fields(begin, record.size() + kMcapHead, name));
  ++metadata_;
}

std::string McapWriter::statistics() const {
  std::string counts;
  for (std::size_t i = 0; i < channels_.size(); ++i)
    counts += fields(static_cast<std::uint16_t>(i), static_cast<std::uint64_t>(channels_[i].messages));
  constexpr std::uint32_t kAttachments = 0;
  return fields(messages_, static_cast<std::uint16_t>(schemas_.size()),
                static_cast<std::uint32_t>(channels_.size()), kAttachments, metadata_, chunks_,
                span_.first_ns, span_.last_ns, counts);
}

std::string McapWriter::finish() {
  end_chunk();
  put_record(file_, McapOp::kDataEnd, fields(checksum(file_)));
  const std::uint64_t summary = file_.size();
  std::string offsets;
  const auto group = [&](McapOp op, const std::string& records) {
    if (records.empty()) return;
    put_record(offsets, McapOp::kSummaryOffset,
               fields(static_cast<std::uint8_t>(op), file_.size(), records.size()));
    file_ += records;
  };
  std::string schemas, channels, counted, head;
  for (std::size_t i = 0; i < schemas_.size(); ++i) put_record(schemas, McapOp::kSchema, schema_record(i));
  for (std::size_t i = 0; i < channels_.size(); ++i)
    put_record(channels, McapOp::kChannel, channel_record(i));
  put_record(counted, McapOp::kStatistics, statistics());
  group(McapOp::kSchema, schemas);
  group(McapOp::kChannel, channels);
  group(McapOp::kStatistics, counted);
  group(McapOp::kChunkIndex, chunk_index_);
  group(McapOp::kMetadataIndex, metadata_index_);
  const std::uint64_t summary_offsets = file_.size();
  file_ += offsets;
  std::string footer = fields(summary, summary_offsets);
  // The checksum includes the footer's own header and its two offsets.
  put_record(head, McapOp::kFooter, footer + std::string(4, '\0'));
  head.resize(head.size() - 4);
  put(footer, checksum(file_.substr(summary) + head));
  put_record(file_, McapOp::kFooter, footer);
  file_ += kMcapMagic;
  return std::move(file_);
}

}  // namespace octant::io
