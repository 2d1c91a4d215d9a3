// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_writer.h"

#include <new>
#include <stdexcept>

#include <yaml.h>

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

}  // namespace octant::io
