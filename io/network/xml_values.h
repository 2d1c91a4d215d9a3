// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: typed access to an XML document, in the manner of yaml_reader.h. The first error is kept.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "io/text/text.h"
#include "models/support/result.h"

namespace octant::io {

/// Text of an XML document as UTF-8. Another encoding that the document declares is read as Latin-1: names
/// with other letters look different, but remain distinct.
[[nodiscard]] Result<std::string> xml_as_utf8(const std::string& bytes, const std::string& path);

/// Text of one XML document, and the first error found in it.
class XmlLog {
 public:
  XmlLog(std::string file, std::string_view text);

  /// Parses the text. A DOCTYPE, which may define entities and name other files, is refused, unless it only
  /// names `harmless_dtd`, which is not opened.
  void parse(pugi::xml_document& document, std::string_view harmless_dtd = "");
  void fail(const pugi::xml_node& node, std::string found, std::string expected, std::string advice = "");
  [[nodiscard]] int line(const pugi::xml_node& node) const;

  /// Attribute without surrounding blanks; empty where it is absent.
  [[nodiscard]] static std::string text(const pugi::xml_node& node, const char* attribute);
  /// A number; nullopt where the attribute is absent, or after an error.
  std::optional<double> number(const pugi::xml_node& node, const char* attribute,
                               NumberRange range = kAnyNumber);
  /// A number; its absence is an error.
  double required_number(const pugi::xml_node& node, const char* attribute);
  /// Numbers separated by blanks.
  std::vector<double> numbers(const pugi::xml_node& node, std::string_view values);

  std::optional<Error> error;

 private:
  [[nodiscard]] int line_at(std::ptrdiff_t offset) const;

  std::string file_;
  std::string_view text_;
  std::vector<std::ptrdiff_t> newlines_;
};

}  // namespace octant::io
