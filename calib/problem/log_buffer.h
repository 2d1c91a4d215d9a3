// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace octant::calib {

/// A record that is written, or one of its kind that is read.
template <class Value, class Record>
concept BufferRecord = std::same_as<std::remove_cvref_t<Value>, Record>;

/// Numbers one behind the other, as ranks exchange them. What a record holds is listed once, in a function
/// that takes a writer or a reader and hands it all fields: buffer.exchange(record.a, record.b).
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
  /// Numbers, counts, enumerators, and all coefficients of matrices.
  template <class... Values>
  void exchange(const Values&... values) {
    (put_value(values), ...);
  }

 private:
  template <class Value>
  void put_value(const Value& value) {
    if constexpr (std::is_same_v<Value, std::int64_t>)
      put_integer(value);
    else if constexpr (std::is_arithmetic_v<Value> || std::is_enum_v<Value>)
      put(static_cast<double>(value));
    else
      numbers_.insert(numbers_.end(), value.data(), value.data() + value.size());
  }

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
  /// What a writer exchanged. @param values  matrices of the size that they had there
  template <class... Values>
  void exchange(Values&... values) {
    (get_value(values), ...);
  }

 private:
  template <class Value>
  void get_value(Value& value) {
    if constexpr (std::is_same_v<Value, std::int64_t>)
      value = integer();
    else if constexpr (std::is_enum_v<Value>)
      value = static_cast<Value>(count());
    else if constexpr (std::is_arithmetic_v<Value>)
      value = static_cast<Value>(get());
    else
      for (double* number = value.data(); number != value.data() + value.size(); ++number) *number = get();
  }

  const std::vector<double>& numbers_;
  std::size_t at_ = 0;
};

}  // namespace octant::calib
