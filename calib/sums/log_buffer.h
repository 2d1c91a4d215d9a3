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

/// Several numbers, as a matrix or an array has them.
template <class Value>
concept BufferNumbers = requires(Value& value) {
  value.data();
};

/// The fields of a record are listed once, in a function `exchange` that passes them to a writer or a reader:
/// buffer.exchange(record.a, record.b).
template <class Buffer, class Record>
void exchange_record(Buffer& buffer, Record& record) {
  exchange(buffer, record);
}

/// Numbers one behind the other, as ranks exchange them.
class BufferWriter {
 public:
  explicit BufferWriter(std::vector<double>& numbers) : numbers_(numbers) {}

  /// Numbers, counts, enumerators, all coefficients of matrices, lists of any length, records.
  template <class... Values>
  void exchange(const Values&... values) {
    (put(values), ...);
  }

 private:
  template <class Value>
  void put(const Value& value) {
    if constexpr (std::is_same_v<Value, std::int64_t>) {  // a double holds only integers of 53 bits
      const auto bits = static_cast<std::uint64_t>(value);
      numbers_.push_back(static_cast<double>(bits >> 32U));
      numbers_.push_back(static_cast<double>(bits & 0xFFFFFFFFU));
    } else if constexpr (std::is_arithmetic_v<Value> || std::is_enum_v<Value>) {
      numbers_.push_back(static_cast<double>(value));
    } else if constexpr (BufferNumbers<const Value>) {
      numbers_.insert(numbers_.end(), value.data(), value.data() + value.size());
    } else {
      exchange_record(*this, value);
    }
  }
  template <class Item>
  void put(const std::vector<Item>& list) {
    put(list.size());
    for (const Item& item : list) put(item);
  }

  std::vector<double>& numbers_;
};

class BufferReader {
 public:
  explicit BufferReader(const std::vector<double>& numbers) : numbers_(numbers) {}
  [[nodiscard]] bool ended() const { return at_ >= numbers_.size(); }

  /// Reads the fields that a writer exchanged.
  /// @param values  matrices of the same size as there
  template <class... Values>
  void exchange(Values&... values) {
    (get(values), ...);
  }

 private:
  [[nodiscard]] double next() { return numbers_.at(at_++); }
  template <class Value>
  void get(Value& value) {
    if constexpr (std::is_same_v<Value, std::int64_t>) {
      const auto high = static_cast<std::uint64_t>(next());
      value = static_cast<std::int64_t>((high << 32U) | static_cast<std::uint64_t>(next()));
    } else if constexpr (std::is_enum_v<Value>) {
      value = static_cast<Value>(static_cast<std::size_t>(next()));
    } else if constexpr (std::is_arithmetic_v<Value>) {
      value = static_cast<Value>(next());
    } else if constexpr (BufferNumbers<Value>) {
      for (auto* number = value.data(); number != value.data() + value.size(); ++number) get(*number);
    } else {
      exchange_record(*this, value);
    }
  }
  template <class Item>
  void get(std::vector<Item>& list) {
    std::size_t count = 0;
    for (get(count); count > 0; --count) get(list.emplace_back());
  }

  const std::vector<double>& numbers_;
  std::size_t at_ = 0;
};

}  // namespace octant::calib
