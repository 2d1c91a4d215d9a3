// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/cdr.h"

#include <algorithm>

namespace octant::io {

CdrReader::CdrReader(std::string_view message) {
  const auto byte = [&](std::size_t i) {
    return i < message.size() ? static_cast<unsigned char>(message[i]) : 0xFFu;
  };
  // Representation identifiers: 0 CDR_BE, 1 CDR_LE, 6 PLAIN_CDR2_BE, 7 PLAIN_CDR2_LE.
  const unsigned kind = byte(1);
  ok_ = message.size() >= 4 && byte(0) == 0 && (kind <= 1 || kind == 6 || kind == 7);
  if (!ok_) return;
  if (kind >= 6) most_aligned_ = 4;
  const bool little = kind % 2 == 1;
  swap_ = little != (std::endian::native == std::endian::little);
  body_ = message.substr(4);
}

void CdrReader::align(std::size_t size) {
  const std::size_t to = std::min(size, most_aligned_);
  const std::size_t pad = (to - at_ % to) % to;
  if (body_.size() - at_ < pad) {
    ok_ = false;
  } else {
    at_ += pad;
  }
}

std::string_view CdrReader::text() {
  const auto length = value<std::uint32_t>();
  if (!ok_ || body_.size() - at_ < length) return ok_ = false, std::string_view();
  const std::string_view words = body_.substr(at_, length);
  at_ += length;
  return words.substr(0, words.find('\0'));
}

std::uint32_t CdrReader::count(std::size_t least_bytes) {
  const auto items = value<std::uint32_t>();
  if (ok_ && items <= (body_.size() - at_) / least_bytes) return items;
  ok_ = false;
  return 0;
}

}  // namespace octant::io
