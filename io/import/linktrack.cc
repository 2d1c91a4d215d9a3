// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/linktrack.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <numeric>

#include <fmt/format.h>

#include "io/import/mapping_words.h"
#include "io/text/open_file.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kProbe = std::size_t{1} << 16;  // bytes in which a log is recognised
constexpr std::size_t kLeastFrames = 2;
constexpr unsigned char kFrameBegin = 0x55;
constexpr double kLinkUnits = 1e3;             // in a metre and in a second
constexpr std::uint8_t kAnchor = 1, kTag = 2;  // roles

/// Offsets in a frame with a list of nodes.
struct NodeFrame {
  unsigned char kind;
  std::size_t time, count, nodes, node_size;
};
constexpr NodeFrame kNodeFrames[] = {{0x04, 102, 118, 119, 13}, {0x05, 6, 20, 21, 7}};
constexpr unsigned char kTagFrame = 0x01;
constexpr std::size_t kTagFrameSize = 128, kTagDistances = 22, kTagTime = 108, kTagAnchors = 8;

/// Little-endian numbers of a frame.
class FrameBytes {
 public:
  explicit FrameBytes(std::string_view bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint32_t number(std::size_t at, std::size_t size) const {
    std::uint32_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes_[at + i]);
    return value;
  }
  [[nodiscard]] std::uint8_t byte(std::size_t at) const { return static_cast<std::uint8_t>(bytes_[at]); }
  /// A signed length of 24 bits [m].
  [[nodiscard]] double length_m(std::size_t at) const {
    const auto value = static_cast<std::int32_t>(number(at, 3) << 8) / 256;
    return value / kLinkUnits;
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

/// The frame at the beginning of the bytes, if there is one with a valid sum; empty otherwise.
std::string_view frame_at(std::string_view bytes) {
  constexpr std::size_t kLeast = 12;
  if (bytes.size() < kLeast || static_cast<unsigned char>(bytes[0]) != kFrameBegin) return {};
  const auto kind = static_cast<unsigned char>(bytes[1]);
  const std::size_t size = kind == kTagFrame ? kTagFrameSize : FrameBytes(bytes).number(2, 2);
  if (kind > 0x10 || size < kLeast || size > bytes.size()) return {};
  const std::string_view frame = bytes.substr(0, size);
  const auto sum = std::accumulate(frame.begin(), frame.end() - 1, 0U, [](unsigned total, char c) {
    return total + static_cast<unsigned char>(c);
  });
  return static_cast<unsigned char>(frame.back()) == (sum & 0xFFU) ? frame : std::string_view();
}

/// Bytes of a file, also of one with their hexadecimal text.
std::string bytes_of(std::string_view data) {
  const auto is_text = [](char c) {
    return std::isxdigit(static_cast<unsigned char>(c)) != 0 ||
           std::isspace(static_cast<unsigned char>(c)) != 0;
  };
  if (!data.starts_with("55") || !std::ranges::all_of(data, is_text)) return std::string(data);
  std::string bytes;
  unsigned value = 0;
  bool half = false;
  for (const char c : data) {
    if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    const unsigned digit = std::isdigit(static_cast<unsigned char>(c)) != 0
                               ? static_cast<unsigned>(c - '0')
                               : static_cast<unsigned>((c | 0x20) - 'a') + 10;
    value = value << 4 | digit;
    if (half) bytes += static_cast<char>(value & 0xFFU);
    half = !half;
  }
  return bytes;
}

class LinktrackReader {
 public:
  LinktrackReader(const std::string& path, const VendorLogOptions& options) : options_(options) {
    log_.path = path;
  }

  Result<ImportedLog> read(std::string_view bytes) {
    std::size_t between = 0;
    while (!bytes.empty()) {
      const std::string_view frame = frame_at(bytes);
      if (frame.empty())
        ++between;
      else if (!read_frame(FrameBytes(frame)))
        ++other_frames_;
      bytes.remove_prefix(std::max<std::size_t>(1, frame.size()));
      if (too_many_names_)
        return fail({.file = log_.path,
                     .found = fmt::format("more than {} names", kMostImportedNames),
                     .expected = "as many as there may be at a site"});
    }
    if (between > 0)
      log_.warnings.push_back(
          fmt::format("{}: {} bytes that belong to no frame are left out", log_.path, between));
    if (other_frames_ > 0)
      log_.warnings.push_back(
          fmt::format("{}: {} frames without distances are left out", log_.path, other_frames_));
    remove_only_receiver(log_);
    return std::move(log_);
  }

 private:
  /// False for a frame without distances.
  bool read_frame(const FrameBytes& frame) {
    if (frame.byte(1) == kTagFrame) {
      const std::string tag = name_of(kTag, frame.byte(2));
      for (std::size_t i = 0; i < kTagAnchors; ++i)
        add(frame.number(kTagTime, 4) / kLinkUnits, fmt::format("A{}", i), tag,
            frame.length_m(kTagDistances + 3 * i));
      return true;
    }
    for (const NodeFrame& kind : kNodeFrames) {
      if (frame.byte(1) != kind.kind || frame.size() <= kind.nodes) continue;
      const std::size_t count = frame.byte(kind.count);
      if (kind.nodes + count * kind.node_size + 1 > frame.size()) return false;
      const std::uint8_t own_role = frame.byte(4);
      const std::string own = name_of(own_role, frame.byte(5));
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = kind.nodes + i * kind.node_size;
        const std::string other = name_of(frame.byte(at), frame.byte(at + 1));
        const bool is_beacon = frame.byte(at) == kAnchor || own_role != kAnchor;
        add(frame.number(kind.time, 4) / kLinkUnits, is_beacon ? other : own, is_beacon ? own : other,
            frame.length_m(at + 2));
      }
      return true;
    }
    return false;
  }

  static std::string name_of(std::uint8_t role, std::uint8_t id) {
    return fmt::format("{}{}", role == kAnchor ? "A" : role == kTag ? "T" : "N", id);
  }

  void add(double time_s, const std::string& beacon, const std::string& receiver, double distance_m) {
    if (is_ignored(options_.ignore, beacon)) return (void)++log_.ignored[beacon];
    if (!(distance_m > 0.0)) return (void)++log_.not_heard;
    ImportedArrival a;
    a.time_s = time_s;
    a.value = distance_m;
    a.is_distance = true;
    a.beacon = log_.names.number_of(beacon);
    a.receiver = log_.names.number_of(receiver);
    too_many_names_ = too_many_names_ || a.beacon < 0 || a.receiver < 0;
    log_.arrivals.push_back(a);
  }

  const VendorLogOptions& options_;
  ImportedLog log_;
  std::size_t other_frames_ = 0;
  bool too_many_names_ = false;
};

}  // namespace

bool is_linktrack_log(const std::string& path) {
  const auto map = MappedFile::open(path);
  if (!map) return false;
  const std::string bytes = bytes_of(map->text().substr(0, kProbe));
  std::size_t frames = 0;
  for (std::string_view rest = bytes; !rest.empty() && frames < kLeastFrames;) {
    const std::string_view frame = frame_at(rest);
    frames += static_cast<std::size_t>(!frame.empty());
    rest.remove_prefix(std::max<std::size_t>(1, frame.size()));
  }
  return frames >= kLeastFrames;
}

Result<ImportedLog> read_linktrack_log(const std::string& path, const VendorLogOptions& options) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  return LinktrackReader(path, options).read(bytes_of(map->text()));
}

}  // namespace octant::io
