// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace octant::fuzz {

/// Choices from the input of a fuzzer, a byte or two each; after its end, always the first one.
class Bytes {
 public:
  explicit Bytes(std::string_view input) : rest_(input) {}

  [[nodiscard]] bool empty() const { return rest_.empty(); }
  unsigned byte() {
    if (rest_.empty()) return 0;
    const auto value = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return value;
  }
  std::size_t below(std::size_t n) { return byte() % n; }
  /// One of eight, by its lowest bits.
  bool sometimes() { return byte() % 8 == 1; }
  /// -1..1
  double part() { return static_cast<double>(static_cast<signed char>(byte())) / 128; }
  template <class T, std::size_t N>
  T one_of(const std::array<T, N>& values) {
    return values[below(N)];
  }

 private:
  std::string_view rest_;
};

}  // namespace octant::fuzz
