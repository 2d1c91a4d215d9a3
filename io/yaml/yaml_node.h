// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: a YAML document in memory, built from libyaml's events within stated bounds.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "io/text/bounds.h"
#include "models/support/result.h"

namespace octant::io {

inline constexpr std::size_t kMostYamlValues = 1'000'000;  ///< an alias counts as all its values
inline constexpr std::size_t kDeepestYaml = 64;            ///< brackets and indentation

struct YamlDocument;

/// A value of a document, or an undefined value (default). It is cheap to copy and keeps the document alive.
/// Aliases are resolved.
class YamlNode {
 public:
  enum class Kind : std::uint8_t { kUndefined, kNull, kScalar, kSequence, kMap };

  YamlNode() = default;
  YamlNode(std::shared_ptr<const YamlDocument> document, std::uint32_t index)
      : document_(std::move(document)), index_(index) {}

  [[nodiscard]] Kind kind() const;
  [[nodiscard]] bool is_defined() const { return document_ != nullptr; }
  [[nodiscard]] bool is_null() const { return kind() == Kind::kNull; }  ///< empty, ~ or null
  [[nodiscard]] bool is_scalar() const { return kind() == Kind::kScalar; }
  [[nodiscard]] bool is_sequence() const { return kind() == Kind::kSequence; }
  [[nodiscard]] bool is_map() const { return kind() == Kind::kMap; }
  /// A scalar that was not written plainly: in quotes, or as a block of text.
  [[nodiscard]] bool is_quoted() const;
  /// A list or mapping in brackets.
  [[nodiscard]] bool is_flow() const;

  /// From 1; 0 for an undefined value.
  [[nodiscard]] int line() const;
  [[nodiscard]] int column() const;

  /// Text of a scalar, as long as the document lives; empty for others.
  [[nodiscard]] std::string_view scalar() const;
  /// Items of a list or keys of a mapping.
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] YamlNode item(std::size_t i) const;   ///< item of a list
  [[nodiscard]] YamlNode key(std::size_t i) const;    ///< key of a mapping
  [[nodiscard]] YamlNode value(std::size_t i) const;  ///< value of a mapping
  /// Value of the first such key, or item of an index; undefined if it is missing.
  [[nodiscard]] YamlNode operator[](std::string_view key) const;
  [[nodiscard]] YamlNode operator[](int index) const;

 private:
  [[nodiscard]] YamlNode child(std::size_t i) const;

  std::shared_ptr<const YamlDocument> document_;
  std::uint32_t index_ = 0;
};

/// One YAML document. Errors, with line and column: not UTF-8, not YAML, empty, more than one document,
/// larger, deeper or of more values than the bounds above, an alias within what it names.
[[nodiscard]] Result<YamlNode> parse_yaml(std::string_view text, const std::string& file);

/// Reads a YAML file of at most kLargestYaml. Errors: those of parse_yaml() and of read_file().
[[nodiscard]] Result<YamlNode> read_yaml(const std::string& path);

}  // namespace octant::io
