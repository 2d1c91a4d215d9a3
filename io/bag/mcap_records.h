// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/bag/: constants of the reader and the writer of MCAP.

#include <cstddef>
#include <cstdint>

namespace octant::io {

enum class McapOp : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kMetadata = 12,
  kMetadataIndex = 13,
  kSummaryOffset = 14,
  kDataEnd = 15
};
/// Bytes before a record's content: its kind and its length.
inline constexpr std::size_t kMcapHead = 9;

}  // namespace octant::io
