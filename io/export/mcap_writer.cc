// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/export/mcap_writer.h"

#include <algorithm>

#include <zlib.h>

#include "io/bag/bag.h"
#include "io/bag/mcap_records.h"

namespace octant::io {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

template <class T>
void put_number(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF);
}
void put_text(std::string& out, std::string_view text) {
  put_number(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}
void put_record(std::string& out, McapOp op, std::string_view content) {
  put_number(out, static_cast<std::uint8_t>(op));
  put_number(out, static_cast<std::uint64_t>(content.size()));
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
  std::string header;
  // No profile: `ros2` would promise that all channels are CDR.
  put_text(header, "");
  put_text(header, "octant");
  put_record(file_, McapOp::kHeader, header);
}

std::string McapWriter::schema_record(std::size_t number) const {
  const McapSchema& s = schemas_[number];
  std::string out;
  put_number(out, static_cast<std::uint16_t>(number + 1));
  for (const std::string* text : {&s.name, &s.encoding, &s.text}) put_text(out, *text);
  return out;
}

std::string McapWriter::channel_record(std::size_t number) const {
  const Channel& c = channels_[number];
  std::string out;
  put_number(out, static_cast<std::uint16_t>(number));
  put_number(out, c.schema);
  put_text(out, c.topic);
  put_text(out, c.encoding);
  put_text(out, "");  // metadata: an empty map
  return out;
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
  auto index =
      std::find_if(index_.begin(), index_.end(), [&](const Index& i) { return i.channel == channel; });
  if (index == index_.end()) index = index_.insert(index_.end(), {channel, {}});
  index->entries.emplace_back(time_ns, chunk_.size());
  std::string record;
  record.reserve(22 + data.size());
  put_number(record, channel);
  put_number(record, channels_[channel].messages++);
  put_number(record, time_ns);
  put_number(record, time_ns);
  record += data;
  put_record(chunk_, McapOp::kMessage, record);
  chunk_span_.add(time_ns);
  span_.add(time_ns);
  ++messages_;
  if (chunk_.size() >= kChunkBytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  const std::uint64_t begin = file_.size();
  std::string content;
  put_number(content, chunk_span_.first_ns);
  put_number(content, chunk_span_.last_ns);
  put_number(content, static_cast<std::uint64_t>(chunk_.size()));
  put_number(content, checksum(chunk_));
  put_text(content, "");
  put_number(content, static_cast<std::uint64_t>(chunk_.size()));
  content += chunk_;
  put_record(file_, McapOp::kChunk, content);
  const std::uint64_t length = file_.size() - begin, indices = file_.size();
  std::string offsets;
  for (Index& index : index_) {
    std::sort(index.entries.begin(), index.entries.end());
    put_number(offsets, index.channel);
    put_number(offsets, static_cast<std::uint64_t>(file_.size()));
    std::string entries, record;
    for (const auto& [time_ns, offset] : index.entries) {
      put_number(entries, time_ns);
      put_number(entries, offset);
    }
    put_number(record, index.channel);
    put_text(record, entries);
    put_record(file_, McapOp::kMessageIndex, record);
  }
  std::string in_summary;
  put_number(in_summary, chunk_span_.first_ns);
  put_number(in_summary, chunk_span_.last_ns);
  put_number(in_summary, begin);
  put_number(in_summary, length);
  put_text(in_summary, offsets);
  put_number(in_summary, static_cast<std::uint64_t>(file_.size() - indices));
  put_text(in_summary, "");
  put_number(in_summary, static_cast<std::uint64_t>(chunk_.size()));
  put_number(in_summary, static_cast<std::uint64_t>(chunk_.size()));
  put_record(chunk_index_, McapOp::kChunkIndex, in_summary);
  ++chunks_;
  chunk_.clear();
  index_.clear();
  chunk_span_ = {};
}

void McapWriter::metadata(const std::string& name, const std::map<std::string, std::string>& values) {
  end_chunk();  // metadata do not stand in chunks
  std::string pairs, record, in_summary;
  for (const auto& [key, value] : values) {
    put_text(pairs, key);
    put_text(pairs, value);
  }
  put_text(record, name);
  put_text(record, pairs);
  put_number(in_summary, static_cast<std::uint64_t>(file_.size()));
  put_number(in_summary, static_cast<std::uint64_t>(record.size() + kMcapHead));
  put_text(in_summary, name);
  put_record(file_, McapOp::kMetadata, record);
  put_record(metadata_index_, McapOp::kMetadataIndex, in_summary);
  ++metadata_;
}

std::string McapWriter::statistics() const {
  std::string out, counts;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    put_number(counts, static_cast<std::uint16_t>(i));
    put_number(counts, static_cast<std::uint64_t>(channels_[i].messages));
  }
  put_number(out, messages_);
  put_number(out, static_cast<std::uint16_t>(schemas_.size()));
  put_number(out, static_cast<std::uint32_t>(channels_.size()));
  put_number(out, std::uint32_t{0});  // attachments
  put_number(out, metadata_);
  put_number(out, chunks_);
  put_number(out, span_.first_ns);
  put_number(out, span_.last_ns);
  put_text(out, counts);
  return out;
}

std::string McapWriter::finish() {
  end_chunk();
  std::string end;
  put_number(end, checksum(file_));
  put_record(file_, McapOp::kDataEnd, end);
  const std::uint64_t summary = file_.size();
  std::string offsets;
  const auto group = [&](McapOp op, const std::string& records) {
    if (records.empty()) return;
    std::string offset;
    put_number(offset, static_cast<std::uint8_t>(op));
    put_number(offset, static_cast<std::uint64_t>(file_.size()));
    put_number(offset, static_cast<std::uint64_t>(records.size()));
    put_record(offsets, McapOp::kSummaryOffset, offset);
    file_ += records;
  };
  std::string schemas, channels, counted;
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
  std::string footer;
  put_number(footer, summary);
  put_number(footer, summary_offsets);
  // The checksum takes in the footer's own head and its two offsets.
  std::string head;
  put_record(head, McapOp::kFooter, footer + std::string(4, '\0'));
  head.resize(head.size() - 4);
  put_number(footer, checksum(file_.substr(summary) + head));
  put_record(file_, McapOp::kFooter, footer);
  file_ += kMcapMagic;
  return std::move(file_);
}

}  // namespace octant::io
