// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: the encoding of ROS 2 messages (OMG CDR, DDS-XTYPES 1.3 section 7.4), plain only.

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

namespace octant::io {

/// Reads values from the beginning of an encoded message. Missing values read as zero, and ok() is false from
/// then on: a decoder is a list of fields that checks once at the end.
class CdrReader {
 public:
  /// The first four bytes say how the rest is encoded: CDR or plain CDR2, either byte order.
  explicit CdrReader(std::string_view message);

  [[nodiscard]] bool ok() const { return ok_; }

  template <class T>
  requires std::integral<T> || std::floating_point<T> T value() {
    align(sizeof(T));
    T out{};
    if (!ok_ || body_.size() - at_ < sizeof(T)) return ok_ = false, T{};
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, body_.data() + at_, sizeof(T));
    if (swap_)
      for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    std::memcpy(&out, bytes, sizeof(T));
    at_ += sizeof(T);
    return out;
  }
  /// A text without its closing NUL.
  std::string_view text();
  /// Length of a sequence whose items need at least the given number of bytes each; not ok if fewer are left.
  std::uint32_t count(std::size_t least_bytes);

 private:
  void align(std::size_t size);

  std::string_view body_;
  std::size_t at_ = 0, most_aligned_ = 8;
  bool swap_ = false, ok_ = true;
};

/// Writes a message, little-endian CDR.
class CdrWriter {
 public:
  CdrWriter() : out_(std::string_view("\0\1\0\0", 4)) {}

  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void value(T number) {
    while ((out_.size() - 4) % sizeof(T) != 0) out_ += '\0';
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, &number, sizeof(T));
    if constexpr (std::endian::native == std::endian::big)
      for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    out_.append(reinterpret_cast<const char*>(bytes), sizeof(T));
  }
  void text(std::string_view words) {
    value(static_cast<std::uint32_t>(words.size() + 1));
    out_ += words;
    out_ += '\0';
  }
  [[nodiscard]] const std::string& message() const { return out_; }

 private:
  std::string out_;
};

}  // namespace octant::io
