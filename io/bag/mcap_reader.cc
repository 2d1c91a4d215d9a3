// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// MCAP, version 0 (mcap.dev/spec), read from the beginning to the end of its data section. An incomplete file
// of a killed recorder is read as far as possible.
#include <algorithm>
#include <cstring>
#include <memory>
#include <unordered_map>

#include <fmt/format.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include "io/bag/bag.h"
#include "io/bag/mcap_records.h"
#include "io/text/open_file.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

/// Reads the fields of a record from its beginning. Missing fields read as zero, and ok() is false from then
/// on.
class McapFields {
 public:
  explicit McapFields(std::string_view record) : left_(record) {}
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::string_view rest() const { return left_; }

  template <class T>
  T number() {
    if (left_.size() < sizeof(T)) return ok_ = false, T{};
    T value{};
    for (std::size_t i = sizeof(T); i-- > 0;)
      value = static_cast<T>((static_cast<std::uint64_t>(value) << 8) | static_cast<unsigned char>(left_[i]));
    left_.remove_prefix(sizeof(T));
    return value;
  }
  std::string_view bytes(std::uint64_t size) {
    if (left_.size() < size) return ok_ = false, std::string_view();
    const std::string_view out = left_.substr(0, size);
    left_.remove_prefix(size);
    return out;
  }
  std::string_view text() { return bytes(number<std::uint32_t>()); }

 private:
  std::string_view left_;
  bool ok_ = true;
};

/// Reads a record from the beginning of fields, which are not ok() if they end within it.
struct McapRecord {
  McapOp op;
  std::string_view content;
  explicit McapRecord(McapFields& fields)
      : op(static_cast<McapOp>(fields.number<std::uint8_t>())),
        content(fields.bytes(fields.number<std::uint64_t>())) {}
};

struct McapChannel {
  BagTopic topic;
  bool wanted = false;
};

/// Decompresses to at most `size` bytes. The buffer grows with the data, so a wrong size needs no memory.
bool unpack_lz4(std::string_view packed, std::size_t size, std::string& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) return false;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(
      context, &LZ4F_freeDecompressionContext);
  char block[1 << 16];
  while (!packed.empty()) {
    std::size_t made = sizeof(block), taken = packed.size();
    if (LZ4F_isError(LZ4F_decompress(context, block, &made, packed.data(), &taken, nullptr)) != 0)
      return false;
    if (made == 0 && taken == 0) return false;
    if (out.size() + made > size) return false;
    out.append(block, made);
    packed.remove_prefix(taken);
  }
  for (std::size_t made = sizeof(block), none = 0; out.size() < size; made = sizeof(block), none = 0) {
    if (LZ4F_isError(LZ4F_decompress(context, block, &made, nullptr, &none, nullptr)) != 0 || made == 0)
      break;
    if (out.size() + made > size) return false;
    out.append(block, made);
  }
  return out.size() == size;
}

bool unpack_zstd(std::string_view packed, std::size_t size, std::string& out) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (context == nullptr) return false;
  (void)ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, 27);
  char block[1 << 16];
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  for (;;) {
    ZSTD_outBuffer made{block, sizeof(block), 0};
    const std::size_t left = ZSTD_decompressStream(context.get(), &made, &in);
    if (ZSTD_isError(left) != 0 || out.size() + made.pos > size) return false;
    out.append(block, made.pos);
    if (in.pos == in.size && made.pos < made.size) return out.size() == size;
  }
}

class McapReader {
 public:
  McapReader(const std::string& path, const BagVisitor& visitor, BagSummary& summary)
      : path_(path), visitor_(visitor), summary_(summary) {}

  Result<void> read(std::string_view text) {
    if (!text.starts_with(kMcapMagic))
      return broken(0, "neither the first bytes of an MCAP file nor those of a database",
                    "a bag: .mcap, or .db3 as rosbag2 writes it");
    std::size_t at = kMcapMagic.size();
    while (!ended_) {
      McapFields fields(text.substr(at));
      const McapRecord next(fields);
      if (!fields.ok()) return cut_short(at);
      if (auto taken = record(next, at, false); !taken) return taken;
      at = text.size() - fields.rest().size();
    }
    return {};
  }

 private:
  tl::unexpected<Error> broken(std::size_t at, std::string found, std::string expected,
                               std::string advice = "") const {
    return fail({.file = path_,
                 .found = at == 0 ? std::move(found) : fmt::format("{}, at byte {}", found, at),
                 .expected = std::move(expected),
                 .advice = std::move(advice)});
  }

  Result<void> cut_short(std::size_t at) {
    summary_.warnings.push_back(
        fmt::format("{}: the file ends within its data, at byte {}: what stands before is taken", path_, at));
    return {};
  }

  Result<void> record(const McapRecord& found, std::size_t at, bool in_chunk) {
    McapFields fields(found.content);
    Result<void> taken;
    switch (found.op) {
      case McapOp::kSchema: schema(fields); break;
      case McapOp::kChannel: taken = channel(fields, at); break;
      case McapOp::kMessage: taken = message(fields, at); break;
      case McapOp::kChunk:
        if (in_chunk) return broken(at, "a chunk within a chunk", "messages");
        taken = chunk(fields, at);
        break;
      case McapOp::kMetadata: metadata(fields); break;
      case McapOp::kDataEnd:
      case McapOp::kFooter: ended_ = true; break;
      default: break;  // indices, attachments, and what later versions add
    }
    if (!taken) return taken;
    if (!fields.ok()) return broken(at, "a record that ends within its fields", "a whole one");
    return {};
  }

  void schema(McapFields& fields) {
    const auto id = fields.number<std::uint16_t>();
    const std::string_view name = fields.text();
    if (fields.ok() && id != 0 && name.size() <= kLongestTopic) schemas_[id] = std::string(name);
  }

  Result<void> channel(McapFields& fields, std::size_t at) {
    const auto id = fields.number<std::uint16_t>();
    const auto schema_id = fields.number<std::uint16_t>();
    const std::string_view name = fields.text(), encoding = fields.text();
    if (!fields.ok() || channels_.contains(id)) return {};
    if (name.size() > kLongestTopic || encoding.size() > kLongestTopic)
      return broken(at,
                    fmt::format("a topic whose name has {} bytes", std::max(name.size(), encoding.size())),
                    fmt::format("at most {}", kLongestTopic));
    if (channels_.size() >= kMostTopics)
      return broken(at, fmt::format("more than {} topics", kMostTopics), "a recording of a robot");
    const auto schema = schemas_.find(schema_id);
    McapChannel c{{std::string(name), schema == schemas_.end() ? "" : schema->second, std::string(encoding)}};
    c.wanted = visitor_.wants(c.topic);
    channels_.emplace(id, std::move(c));
    return {};
  }

  Result<void> message(McapFields& fields, std::size_t at) {
    const auto id = fields.number<std::uint16_t>();
    (void)fields.number<std::uint32_t>();
    const auto log_time_ns = fields.number<std::uint64_t>();
    (void)fields.number<std::uint64_t>();
    if (!fields.ok()) return {};
    const auto channel = channels_.find(id);
    if (channel == channels_.end())
      return broken(at, fmt::format("a message of channel {}, which is not defined before it", id),
                    "channels before their messages");
    if (!channel->second.wanted) return {};
    ++summary_.messages;
    return visitor_.message({channel->second.topic, static_cast<std::int64_t>(log_time_ns), fields.rest()});
  }

  Result<void> chunk(McapFields& fields, std::size_t at) {
    (void)fields.number<std::uint64_t>();
    (void)fields.number<std::uint64_t>();
    const auto size = fields.number<std::uint64_t>();
    const auto crc = fields.number<std::uint32_t>();
    const std::string_view compression = fields.text();
    const std::string_view packed = fields.bytes(fields.number<std::uint64_t>());
    if (!fields.ok()) return {};
    if (size > kLargestChunk)
      return broken(at, fmt::format("a chunk that unpacks to {} bytes", size),
                    fmt::format("at most {}", kLargestChunk));
    std::string_view records = packed;
    if (!compression.empty()) {
      unpacked_.clear();
      if (compression != "lz4" && compression != "zstd")
        return broken(at, fmt::format("a chunk compressed by {}", in_quotes(compression)), "lz4 or zstd");
      if (!(compression == "lz4" ? unpack_lz4 : unpack_zstd)(packed, size, unpacked_))
        return broken(at, fmt::format("a chunk that {} does not unpack to its {} bytes", compression, size),
                      "a whole one", "was the file damaged? `mcap recover` may save the rest");
      records = unpacked_;
    }
    if (records.size() != size)
      return broken(at, fmt::format("a chunk of {} bytes that says it has {}", records.size(), size),
                    "the same");
    if (crc != 0 && crc32_z(0, reinterpret_cast<const Bytef*>(records.data()), records.size()) != crc)
      return broken(at, "a chunk whose checksum is not that of its content", "the same",
                    "was the file damaged? `mcap recover` may save the rest");
    for (McapFields left(records); !left.rest().empty();) {
      const McapRecord next(left);
      if (!left.ok()) return broken(at, "a chunk that ends within a record", "whole ones");
      if (auto taken = record(next, at, true); !taken) return taken;
    }
    return {};
  }

  void metadata(McapFields& fields) {
    const std::string name(fields.text());
    McapFields pairs(fields.text());
    std::map<std::string, std::string> values;
    while (!pairs.rest().empty() && pairs.ok()) {
      const std::string key(pairs.text());
      values[key] = pairs.text();
    }
    if (fields.ok() && pairs.ok() && visitor_.metadata) visitor_.metadata(name, values);
  }

  const std::string& path_;
  const BagVisitor& visitor_;
  BagSummary& summary_;
  std::unordered_map<std::uint16_t, std::string> schemas_;
  std::unordered_map<std::uint16_t, McapChannel> channels_;
  std::string unpacked_;
  bool ended_ = false;
};

}  // namespace

Result<void> read_mcap(const std::string& path, const BagVisitor& visitor, BagSummary& summary) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  return McapReader(path, visitor, summary).read(map->text());
}

}  // namespace octant::io
