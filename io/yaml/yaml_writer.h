// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: writing a YAML document value by value, by libyaml.

#include <memory>
#include <string>
#include <string_view>

#include "io/yaml/yaml_node.h"

namespace octant::io {

/// One document. Lists and mappings are begun and ended; a mapping's keys and values alternate.
class YamlWriter {
 public:
  YamlWriter();
  YamlWriter(const YamlWriter&) = delete;
  YamlWriter& operator=(const YamlWriter&) = delete;
  ~YamlWriter();

  /// @param quoted  in quotes even where it could stand plainly
  void text(std::string_view text, bool quoted = false);
  void begin_list(bool flow);
  void end_list();
  void begin_map(bool flow);
  void end_map();
  /// A value with all below it, in brackets and quotes where it was written so; aliases as what they name.
  void copy(const YamlNode& node);
  /// Ends the document.
  [[nodiscard]] std::string finish();

 private:
  struct Emitter;
  std::unique_ptr<Emitter> emitter_;
};

/// A name as a YAML scalar: plain if every YAML reader interprets it as a text, otherwise in double quotes
/// ("no", "1e5", "a: b").
[[nodiscard]] std::string yaml_text(std::string_view text);

}  // namespace octant::io
