// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: names to numbers, as fast as a file is read.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

namespace octant::io {

/// A table of names, open addressing at most a quarter full; looked up by their first and last eight bytes
/// and their length. Views into the names: they must outlive it.
class NameIndex {
 public:
  NameIndex() = default;
  explicit NameIndex(const std::vector<std::string_view>& names);

  /// Place of the name in the list; -1 if it is not there. Of equal names the first one.
  [[nodiscard]] std::int32_t find(std::string_view name) const {
    if (entries_.empty()) return -1;
    const Key key = key_of(name);
    for (std::size_t i = slot_of(key, name.size());; i = (i + 1) & mask_) {
      const Entry& entry = entries_[i];
      if (entry.number < 0) return -1;
      if (entry.key.first == key.first && entry.key.last == key.last && entry.name.size() == name.size() &&
          (name.size() <= 16 || entry.name == name)) {
        return entry.number;
      }
    }
  }

 private:
  struct Key {
    std::uint64_t first = 0, last = 0;  // they overlap in names of less than sixteen bytes
  };
  struct Entry {
    Key key;
    std::string_view name;
    std::int32_t number = -1;
  };
  static Key key_of(std::string_view name) {
    // Two loads that overlap, so that names of nearly the same length take the same way through here.
    Key key;
    const char* end = name.data() + name.size();
    if (name.size() >= 8) {
      std::memcpy(&key.first, name.data(), 8);
      std::memcpy(&key.last, end - 8, 8);
    } else if (name.size() >= 4) {
      std::memcpy(&key.first, name.data(), 4);
      std::memcpy(&key.last, end - 4, 4);
    } else if (name.size() >= 2) {
      std::memcpy(&key.first, name.data(), 2);
      std::memcpy(&key.last, end - 2, 2);
    } else if (!name.empty()) {
      key.first = static_cast<unsigned char>(name[0]);
    }
    return key;
  }
  [[nodiscard]] std::size_t slot_of(const Key& key, std::size_t size) const {
    const std::uint64_t mixed = (key.first ^ std::rotl(key.last, 29) ^ size) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(mixed >> 32) & mask_;
  }

  std::vector<Entry> entries_;
  std::size_t mask_ = 0;
};

}  // namespace octant::io
