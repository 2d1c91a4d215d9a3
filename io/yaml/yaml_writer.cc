// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_writer.h"

#include <algorithm>
#include <cctype>
#include <new>
#include <stdexcept>

#include <fmt/format.h>
#include <yaml.h>

#include "io/text/text.h"

namespace octant::io {

struct YamlWriter::Emitter {
  yaml_emitter_t emitter{};
  std::string out;

  static int append(void* to, unsigned char* bytes, std::size_t size) {
    static_cast<Emitter*>(to)->out.append(reinterpret_cast<const char*>(bytes), size);
    return 1;
  }
  /// @param made  what making the event returned; the emitter takes it over
  void emit(yaml_event_t& event, int made) {
    if (made == 0) throw std::bad_alloc();
    if (yaml_emitter_emit(&emitter, &event) == 0)
      throw std::logic_error(emitter.problem != nullptr ? emitter.problem : "libyaml writes no more");
  }
};

YamlWriter::YamlWriter() : emitter_(std::make_unique<Emitter>()) {
  Emitter& e = *emitter_;
  if (yaml_emitter_initialize(&e.emitter) == 0) throw std::bad_alloc();
  yaml_emitter_set_output(&e.emitter, &Emitter::append, &e);
  yaml_emitter_set_unicode(&e.emitter, 1);
  yaml_emitter_set_width(&e.emitter, -1);
  yaml_event_t event;
  e.emit(event, yaml_stream_start_event_initialize(&event, YAML_UTF8_ENCODING));
  e.emit(event, yaml_document_start_event_initialize(&event, nullptr, nullptr, nullptr, 1));
}

YamlWriter::~YamlWriter() { yaml_emitter_delete(&emitter_->emitter); }

void YamlWriter::text(std::string_view text, bool quoted) {
  yaml_event_t event;
  const auto* bytes = reinterpret_cast<const yaml_char_t*>(text.empty() ? "" : text.data());
  emitter_->emit(event,
                 yaml_scalar_event_initialize(
                     &event, nullptr, nullptr, const_cast<yaml_char_t*>(bytes), static_cast<int>(text.size()),
                     quoted ? 0 : 1, 1, quoted ? YAML_DOUBLE_QUOTED_SCALAR_STYLE : YAML_PLAIN_SCALAR_STYLE));
}

void YamlWriter::begin_list(bool flow) {
  yaml_event_t event;
  emitter_->emit(
      event, yaml_sequence_start_event_initialize(
                 &event, nullptr, nullptr, 1, flow ? YAML_FLOW_SEQUENCE_STYLE : YAML_BLOCK_SEQUENCE_STYLE));
}

void YamlWriter::end_list() {
  yaml_event_t event;
  emitter_->emit(event, yaml_sequence_end_event_initialize(&event));
}

void YamlWriter::begin_map(bool flow) {
  yaml_event_t event;
  emitter_->emit(
      event, yaml_mapping_start_event_initialize(&event, nullptr, nullptr, 1,
                                                 flow ? YAML_FLOW_MAPPING_STYLE : YAML_BLOCK_MAPPING_STYLE));
}

void YamlWriter::end_map() {
  yaml_event_t event;
  emitter_->emit(event, yaml_mapping_end_event_initialize(&event));
}

void YamlWriter::copy(const YamlNode& node) {
  if (node.is_sequence()) {
    begin_list(node.is_flow());
    for (std::size_t i = 0; i < node.size(); ++i) copy(node.item(i));
    return end_list();
  }
  if (node.is_map()) {
    begin_map(node.is_flow());
    for (std::size_t i = 0; i < node.size(); ++i) copy(node.key(i)), copy(node.value(i));
    return end_map();
  }
  text(node.is_scalar() ? node.scalar() : "null", node.is_quoted());
}

std::string YamlWriter::finish() {
  yaml_event_t event;
  emitter_->emit(event, yaml_document_end_event_initialize(&event, 1));
  emitter_->emit(event, yaml_stream_end_event_initialize(&event));
  return std::move(emitter_->out);
}

namespace {

bool is_plain_scalar(std::string_view text) {
  double value = 0.0;
  if (text.empty() || !std::isalpha(static_cast<unsigned char>(text[0])) ||
      parse_number(text, value) == NumberText::kNumber)
    return false;
  if (!std::ranges::all_of(
          text, [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.'; })) {
    return false;
  }
  constexpr std::string_view kWords[] = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  return std::ranges::find(kWords, lower_case(text)) == std::end(kWords);
}

/// Characters beyond ASCII that are line ends in YAML, or are not allowed (YAML 1.1, 5.1 and 5.4), with their
/// escapes in double quotes.
struct OddCharacter {
  std::string_view bytes, escape;
};
constexpr OddCharacter kOdd[] = {{"\xE2\x80\xA8", "\\u2028"},
                                 {"\xE2\x80\xA9", "\\u2029"},
                                 {"\xEF\xBB\xBF", "\\uFEFF"},
                                 {"\xEF\xBF\xBE", "\\uFFFE"},
                                 {"\xEF\xBF\xBF", "\\uFFFF"}};

/// Escape of the first character of a text, and its number of bytes; 0: no escape is needed.
std::size_t escape_odd(std::string_view text, std::string& out) {
  // C1 control characters, U+0080 to U+009F.
  if (text.size() >= 2 && text[0] == '\xC2' && static_cast<unsigned char>(text[1]) < 0xA0) {
    out += fmt::format("\\x{:02X}", static_cast<unsigned char>(text[1]));
    return 2;
  }
  for (const OddCharacter& odd : kOdd)
    if (text.starts_with(odd.bytes)) {
      out += odd.escape;
      return odd.bytes.size();
    }
  return 0;
}

}  // namespace

std::string yaml_text(std::string_view text) {
  if (is_plain_scalar(text)) return std::string(text);
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      out += fmt::format("\\x{:02X}", static_cast<unsigned char>(c));
    } else if (const std::size_t bytes = escape_odd(text.substr(i), out); bytes > 0) {
      i += bytes - 1;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

}  // namespace octant::io
