// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/network/xml_values.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace octant::io {

Result<std::string> xml_as_utf8(const std::string& bytes, const std::string& path) {
  const std::string_view declaration = std::string_view(bytes).substr(0, bytes.find("?>"));
  const auto utf8 = check_utf8(bytes, path);
  if (utf8) return bytes;
  if (!declaration.starts_with("<?xml") || declaration.find("encoding") == std::string_view::npos ||
      declaration.find("utf-8") != std::string_view::npos ||
      declaration.find("UTF-8") != std::string_view::npos)
    return octant::fail(utf8.error());
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xC0 | (byte >> 6));
      text += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return text;
}

XmlLog::XmlLog(std::string file, std::string_view text) : file_(std::move(file)), text_(text) {
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n') newlines_.push_back(static_cast<std::ptrdiff_t>(i));
}

int XmlLog::line_at(std::ptrdiff_t offset) const {
  return 1 + static_cast<int>(std::ranges::lower_bound(newlines_, offset) - newlines_.begin());
}

int XmlLog::line(const pugi::xml_node& node) const { return line_at(node.offset_debug()); }

void XmlLog::fail(const pugi::xml_node& node, std::string found, std::string expected, std::string advice) {
  if (error) return;
  error = Error{.file = file_,
                .line = line(node),
                .found = std::move(found),
                .expected = std::move(expected),
                .advice = std::move(advice)};
}

void XmlLog::parse(pugi::xml_document& document, std::string_view harmless_dtd) {
  const pugi::xml_parse_result result = document.load_buffer(
      text_.data(), text_.size(), pugi::parse_default | pugi::parse_doctype, pugi::encoding_utf8);
  const auto is_harmless = [&](std::string_view doctype) {
    return !harmless_dtd.empty() && doctype.find('[') == std::string_view::npos &&
           (doctype.ends_with(fmt::format("\"{}\"", harmless_dtd)) ||
            doctype.ends_with(fmt::format("'{}'", harmless_dtd)));
  };
  for (const pugi::xml_node& node : document.children())
    if (node.type() == pugi::node_doctype && !is_harmless(without_blanks(node.value())))
      fail(node, "a DOCTYPE", "XML without DOCTYPE and entities", "delete the DOCTYPE");
  if (!result && !error)
    error = Error{.file = file_,
                  .line = line_at(result.offset),
                  .found = fmt::format("invalid XML ({})", result.description()),
                  .expected = "a gama-local document"};
}

std::string XmlLog::text(const pugi::xml_node& node, const char* attribute) {
  return std::string(without_blanks(node.attribute(attribute).value()));
}

std::optional<double> XmlLog::number(const pugi::xml_node& node, const char* attribute, NumberRange range) {
  if (!node.attribute(attribute)) return std::nullopt;
  double value = 0.0;
  const std::string word = text(node, attribute);
  if (parse_number(word, value) == NumberText::kNumber && std::isfinite(value) && range.contains(value))
    return value;
  fail(node, fmt::format("{}={} of <{}>", attribute, in_quotes(word), node.name()), range.words);
  return std::nullopt;
}

double XmlLog::required_number(const pugi::xml_node& node, const char* attribute) {
  if (!node.attribute(attribute))
    fail(node, fmt::format("<{}> without {}", node.name(), attribute), "a number");
  return number(node, attribute).value_or(0.0);
}

std::vector<double> XmlLog::numbers(const pugi::xml_node& node, std::string_view values) {
  std::vector<double> all;
  constexpr std::string_view kBlanks = " \t\r\n";
  for (std::size_t begin = values.find_first_not_of(kBlanks); begin != std::string_view::npos && !error;) {
    const std::size_t end = std::min(values.find_first_of(kBlanks, begin), values.size());
    const std::string_view word = values.substr(begin, end - begin);
    double value = 0.0;
    if (parse_number(word, value) != NumberText::kNumber || !std::isfinite(value))
      fail(node, fmt::format("{} in <{}>", in_quotes(word), node.name()), "numbers");
    all.push_back(value);
    begin = values.find_first_not_of(kBlanks, end);
  }
  return all;
}

}  // namespace octant::io
