// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/yaml/yaml_node.h"

#include <algorithm>
#include <optional>
#include <unordered_map>

#include <fmt/format.h>
#include <yaml.h>

#include "io/text/atomic_file.h"
#include "io/text/text.h"

namespace octant::io {

/// Values in the order in which they begin; their texts and children in one piece each.
struct YamlDocument {
  struct Item {
    YamlNode::Kind kind = YamlNode::Kind::kNull;
    bool odd = false;  ///< a scalar: not plain; a list or mapping: in brackets
    std::uint32_t line = 0, column = 0;
    std::uint32_t first = 0,
                  count = 0;  ///< range of texts or of children; keys and values of a mapping alternate
  };
  std::vector<Item> items;
  std::vector<std::uint32_t> children;
  std::string texts;
};

namespace {

constexpr int kMostDirectives = 100;  // libyaml compares each with all before it

/// Line up to the given one, and near it, that is indented with a tab; 0: no such line.
int tab_in_indentation(std::string_view text, int wrong_line) {
  constexpr int kNear = 3;
  int line = 1, found = 0;
  for (std::size_t begin = 0; begin < text.size() && line <= wrong_line; ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::size_t first = text.find_first_not_of(' ', begin);
    if (first < end && text[first] == '\t' && line + kNear >= wrong_line) found = line;
    begin = end + 1;
  }
  return found;
}

/// Line of a surplus directive (%...); 0: no such line.
int too_many_directives(std::string_view text) {
  int line = 1, count = 0;
  for (std::size_t begin = 0; begin < text.size(); ++line) {
    if (text[begin] == '%' && ++count > kMostDirectives) return line;
    begin = std::min(text.find('\n', begin), text.size()) + 1;
  }
  return 0;
}

bool is_null_word(std::string_view text) {
  return text.empty() || text == "~" || text == "null" || text == "Null" || text == "NULL";
}

/// An event, freed at the end of its scope.
struct YamlEvent {
  yaml_event_t is{};
  YamlEvent() = default;
  YamlEvent(const YamlEvent&) = delete;
  YamlEvent& operator=(const YamlEvent&) = delete;
  ~YamlEvent() { yaml_event_delete(&is); }
};

/// Builds a document event by event.
class YamlBuilder {
 public:
  YamlBuilder(std::string_view text, const std::string& file) : text_(text), file_(file) {
    if (yaml_parser_initialize(&parser_) == 0) throw std::bad_alloc();
    yaml_parser_set_encoding(&parser_, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char*>(text.data()), text.size());
  }
  YamlBuilder(const YamlBuilder&) = delete;
  YamlBuilder& operator=(const YamlBuilder&) = delete;
  ~YamlBuilder() { yaml_parser_delete(&parser_); }

  Result<YamlNode> build() {
    for (bool more = true; more;) {
      YamlEvent event;
      if (yaml_parser_parse(&parser_, &event.is) == 0) return fail(not_yaml());
      more = event.is.type != YAML_STREAM_END_EVENT;
      take(event.is);
      if (error_) return fail(*error_);
    }
    if (document_->items.empty() || document_->items.front().kind == YamlNode::Kind::kNull)
      return fail({.file = file_, .found = "the file is empty"});
    return YamlNode(document_, 0);
  }

 private:
  struct Anchor {
    std::uint32_t index = 0;
    std::size_t values = 0;  ///< number of values of an alias
    bool open = true;        ///< its end has not been read yet
  };
  struct Open {
    std::uint32_t index = 0;
    std::size_t values_before = 0;
    std::string anchor;
    std::vector<std::uint32_t> children;
  };

  void take(const yaml_event_t& event) {
    switch (event.type) {
      case YAML_DOCUMENT_START_EVENT: ++documents_; return;
      case YAML_ALIAS_EVENT: return alias(event);
      case YAML_SCALAR_EVENT: return scalar(event);
      case YAML_SEQUENCE_START_EVENT:
        return open(event, YamlNode::Kind::kSequence, event.data.sequence_start.anchor,
                    event.data.sequence_start.style == YAML_FLOW_SEQUENCE_STYLE);
      case YAML_MAPPING_START_EVENT:
        return open(event, YamlNode::Kind::kMap, event.data.mapping_start.anchor,
                    event.data.mapping_start.style == YAML_FLOW_MAPPING_STYLE);
      case YAML_SEQUENCE_END_EVENT:
      case YAML_MAPPING_END_EVENT: return close();
      default: return;
    }
  }

  /// Begins a value; no value on error.
  YamlDocument::Item* begin(const yaml_event_t& event, YamlNode::Kind kind) {
    if (documents_ > 1) {
      bad(event.start_mark, "a second document", "one YAML document");
      return nullptr;
    }
    if (!count(1, event.start_mark)) return nullptr;
    const auto index = static_cast<std::uint32_t>(document_->items.size());
    if (!open_.empty()) open_.back().children.push_back(index);
    YamlDocument::Item& item = document_->items.emplace_back();
    item.kind = kind;
    item.line = static_cast<std::uint32_t>(event.start_mark.line) + 1;
    item.column = static_cast<std::uint32_t>(event.start_mark.column) + 1;
    return &item;
  }

  bool count(std::size_t values, const yaml_mark_t& where) {
    values_ += values;
    if (values_ <= kMostYamlValues) return true;
    bad(where, fmt::format("more than {} values", kMostYamlValues),
        "fewer; an alias counts as all that it stands for");
    return false;
  }

  void scalar(const yaml_event_t& event) {
    const auto& s = event.data.scalar;
    const std::string_view text(reinterpret_cast<const char*>(s.value), s.length);
    const bool plain = s.style == YAML_PLAIN_SCALAR_STYLE;
    YamlDocument::Item* item =
        begin(event, plain && is_null_word(text) ? YamlNode::Kind::kNull : YamlNode::Kind::kScalar);
    if (item == nullptr) return;
    item->odd = !plain;
    item->first = static_cast<std::uint32_t>(document_->texts.size());
    item->count = static_cast<std::uint32_t>(text.size());
    document_->texts += text;
    if (s.anchor != nullptr)
      anchors_[reinterpret_cast<const char*>(s.anchor)] = {
          static_cast<std::uint32_t>(document_->items.size() - 1), 1, false};
  }

  void open(const yaml_event_t& event, YamlNode::Kind kind, const yaml_char_t* anchor, bool flow) {
    if (open_.size() >= kDeepestYaml)
      return bad(event.start_mark, fmt::format("brackets or indentation {} levels deep", open_.size() + 1),
                 "a few");
    const std::size_t before = values_;
    YamlDocument::Item* item = begin(event, kind);
    if (item == nullptr) return;
    item->odd = flow;
    const auto index = static_cast<std::uint32_t>(document_->items.size() - 1);
    const std::string name = anchor != nullptr ? reinterpret_cast<const char*>(anchor) : "";
    if (!name.empty()) anchors_[name] = {index, 0, true};
    open_.push_back({index, before, name, {}});
  }

  void close() {
    Open& last = open_.back();
    YamlDocument::Item& item = document_->items[last.index];
    item.first = static_cast<std::uint32_t>(document_->children.size());
    item.count = static_cast<std::uint32_t>(last.children.size());
    document_->children.insert(document_->children.end(), last.children.begin(), last.children.end());
    if (const auto anchor = anchors_.find(last.anchor); anchor != anchors_.end())
      if (anchor->second.index == last.index)
        anchor->second = {last.index, values_ - last.values_before, false};
    open_.pop_back();
  }

  void alias(const yaml_event_t& event) {
    if (documents_ > 1) return bad(event.start_mark, "a second document", "one YAML document");
    const std::string name = reinterpret_cast<const char*>(event.data.alias.anchor);
    const auto anchor = anchors_.find(name);
    if (anchor == anchors_.end())
      return bad(event.start_mark, fmt::format("an alias of {}, which is not defined", in_quotes(name)),
                 "a name that an anchor (&name) gave before");
    if (anchor->second.open)
      return bad(event.start_mark, fmt::format("an alias of {} within it", in_quotes(name)),
                 "one outside of what it names");
    if (count(anchor->second.values, event.start_mark)) open_.back().children.push_back(anchor->second.index);
  }

  void bad(const yaml_mark_t& where, std::string found, std::string expected) {
    error_ = Error{.file = file_,
                   .line = static_cast<int>(where.line) + 1,
                   .column = static_cast<int>(where.column) + 1,
                   .found = std::move(found),
                   .expected = std::move(expected)};
  }

  [[nodiscard]] Error not_yaml() const {
    if (parser_.error == YAML_MEMORY_ERROR) throw std::bad_alloc();
    TextPosition at{static_cast<int>(parser_.problem_mark.line) + 1,
                    static_cast<int>(parser_.problem_mark.column) + 1};
    if (parser_.error == YAML_READER_ERROR)  // it has no mark of what it could not take for a character
      at = position_of(text_, std::min(parser_.problem_offset, text_.size()));
    if (const int line = tab_in_indentation(text_, at.line); line > 0)
      return {.file = file_,
              .line = line,
              .column = 1,
              .found = "not YAML: a tab in the indentation",
              .expected = "blanks: YAML is not indented by tabs",
              .advice = "have the editor replace tabs by blanks"};
    const std::string context = parser_.context != nullptr ? fmt::format(" {}", parser_.context) : "";
    return {
        .file = file_,
        .line = at.line,
        .column = at.column,
        .found = fmt::format("not YAML: {}{}", parser_.problem != nullptr ? parser_.problem : "", context),
        .advice = "check indentation, brackets and quotes here and in the line above"};
  }

  std::string_view text_;
  const std::string& file_;
  yaml_parser_t parser_{};
  std::shared_ptr<YamlDocument> document_ = std::make_shared<YamlDocument>();
  std::vector<Open> open_;
  std::unordered_map<std::string, Anchor> anchors_;
  std::size_t values_ = 0;
  int documents_ = 0;
  std::optional<Error> error_;
};

}  // namespace

YamlNode::Kind YamlNode::kind() const { return document_ ? document_->items[index_].kind : Kind::kUndefined; }

bool YamlNode::is_quoted() const { return is_scalar() && document_->items[index_].odd; }

bool YamlNode::is_flow() const { return (is_sequence() || is_map()) && document_->items[index_].odd; }

int YamlNode::line() const { return document_ ? static_cast<int>(document_->items[index_].line) : 0; }

int YamlNode::column() const { return document_ ? static_cast<int>(document_->items[index_].column) : 0; }

std::string_view YamlNode::scalar() const {
  if (!is_scalar()) return {};
  const YamlDocument::Item& item = document_->items[index_];
  return std::string_view(document_->texts).substr(item.first, item.count);
}

std::size_t YamlNode::size() const {
  if (is_sequence()) return document_->items[index_].count;
  return is_map() ? document_->items[index_].count / 2 : 0;
}

YamlNode YamlNode::child(std::size_t i) const {
  return {document_, document_->children[document_->items[index_].first + i]};
}

YamlNode YamlNode::item(std::size_t i) const { return child(i); }
YamlNode YamlNode::key(std::size_t i) const { return child(2 * i); }
YamlNode YamlNode::value(std::size_t i) const { return child(2 * i + 1); }

YamlNode YamlNode::operator[](std::string_view key) const {
  for (std::size_t i = 0; is_map() && i < size(); ++i)
    if (this->key(i).is_scalar() && this->key(i).scalar() == key) return value(i);
  return {};
}

YamlNode YamlNode::operator[](int index) const {
  return is_sequence() && index >= 0 && static_cast<std::size_t>(index) < size()
             ? item(static_cast<std::size_t>(index))
             : YamlNode();
}

Result<YamlNode> parse_yaml(std::string_view text, const std::string& file) {
  if (text.size() > kLargestYaml) {
    return fail({.file = file,
                 .found = fmt::format("{} bytes", text.size()),
                 .expected = fmt::format("a YAML file of at most {} MB", kLargestYaml >> 20)});
  }
  if (auto ok = check_utf8(text, file); !ok) return fail(ok.error());
  if (const int line = too_many_directives(text); line > 0)
    return fail({.file = file, .line = line, .found = "hundreds of directives (%)", .expected = "a few"});
  return YamlBuilder(without_bom(text), file).build();
}

Result<YamlNode> read_yaml(const std::string& path) {
  return read_file(path, kLargestYaml).and_then([&path](const std::string& text) {
    return parse_yaml(text, path);
  });
}

}  // namespace octant::io
