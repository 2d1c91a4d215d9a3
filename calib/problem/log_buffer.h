// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace octant::calib {

/// Numbers one behind the other, as ranks exchange them.
class BufferWriter {
 public:
  explicit BufferWriter(std::vector<double>& numbers) : numbers_(numbers) {}
  void put(double number) { numbers_.push_back(number); }
  void put_count(std::size_t count) { numbers_.push_back(static_cast<double>(count)); }
  /// Any integer; a double holds only those of 53 bits.
  void put_integer(std::int64_t integer) {
    const auto bits = static_cast<std::uint64_t>(integer);
    put(static_cast<double>(bits >> 32U));
    put(static_cast<double>(bits & 0xFFFFFFFFU));
  }

 private:
  std::vector<double>& numbers_;
};

class BufferReader {
 public:
  explicit BufferReader(const std::vector<double>& numbers) : numbers_(numbers) {}
  [[nodiscard]] bool ended() const { return at_ >= numbers_.size(); }
  double get() { return numbers_.at(at_++); }
  std::size_t count() { return static_cast<std::size_t>(get()); }
  std::int64_t integer() {
    const auto high = static_cast<std::uint64_t>(get());
    return static_cast<std::int64_t>((high << 32U) | static_cast<std::uint64_t>(get()));
  }

 private:
  const std::vector<double>& numbers_;
  std::size_t at_ = 0;
};

}  // namespace octant::calib
