// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/kit_lines.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kMostFields = 4096;                                      // of a line
constexpr double kMillimetres = 1e3, kCentimetres = 1e2, kMilliseconds = 1e3;  // in a metre, in a second

bool is_hexadecimal(char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; }

bool is_address(std::string_view text) {
  return text.size() >= 4 && text.size() <= 16 && std::ranges::all_of(text, is_hexadecimal);
}

bool hexadecimal_number(std::string_view text, std::uint32_t& value) {
  const auto [stop, status] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return !text.empty() && status == std::errc() && stop == text.data() + text.size();
}

/// AN0,1151,5.00,8.00,2.25,6.44,AN1,...
void read_lec(std::string_view payload, KitLine& line) {
  const auto fields = fields_at(payload, ',');
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!fields[i].starts_with("AN")) continue;
    double number = 0.0;
    bool whole = i + 5 < fields.size() && is_address(fields[i + 1]);
    for (std::size_t k = 2; whole && k <= 5; ++k) whole = logged_number(fields[i + k], number);
    if (!whole) {
      ++line.garbled;
      continue;
    }
    line.ranges.push_back({std::string(fields[i + 1]), "", number});
    i += 5;
  }
}

/// 1151[5.00,8.00,2.25]=6.48 0CA8[...]=... le_us=2576 est[...]
void read_les(std::string_view payload, KitLine& line) {
  for (const std::string_view word : fields_at(payload, ' ')) {
    const std::size_t open = word.find('['), equals = word.find("]=");
    if (open == std::string_view::npos || word.starts_with("est[")) continue;
    double distance_m = 0.0;
    if (equals == std::string_view::npos || !is_address(word.substr(0, open)) ||
        !logged_number(word.substr(equals + 2), distance_m)) {
      ++line.garbled;
    } else {
      line.ranges.push_back({std::string(word.substr(0, open)), "", distance_m});
    }
  }
}

std::optional<KitLine> trek_line(std::string_view line, std::string_view kind) {
  constexpr std::size_t kTrekAnchors = 4, kWords = 10;
  KitLine out;
  out.begin = line.find(kind);
  if (out.begin == std::string_view::npos) return std::nullopt;
  const auto words = fields_at(line.substr(out.begin), ' ');
  std::uint32_t mask = 0, time_ms = 0;
  if (words.size() < kWords || !hexadecimal_number(words[1], mask) || !hexadecimal_number(words[8], time_ms))
    return std::nullopt;
  const std::size_t colon = words[9].find(':');
  if (colon == std::string_view::npos || colon < 2) return std::nullopt;
  for (std::size_t i = 0; i < kTrekAnchors; ++i) {
    std::uint32_t range_mm = 0;
    if (!hexadecimal_number(words[2 + i], range_mm)) return std::nullopt;
    if ((mask >> i & 1U) != 0U)
      out.ranges.push_back(
          {fmt::format("{}", i), std::string(words[9].substr(1, colon - 1)), range_mm / kMillimetres});
  }
  if (kind == "mc ") out.time_s = time_ms / kMilliseconds;
  return out;
}

/// A number, or a text that is one.
double number_in(const nlohmann::json& value) {
  double number = 0.0;
  if (value.is_number()) return value.get<double>();
  return value.is_string() && logged_number(value.get_ref<const std::string&>(), number) ? number : 0.0;
}

std::string name_in(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.is_number_integer() ? fmt::format("{}", value.get<std::int64_t>()) : "";
}

void read_makerfabs_json(const nlohmann::json& object, KitLine& line) {
  std::string tag;
  for (const char* key : {"tag", "id"})
    if (tag.empty() && object.contains(key)) tag = name_in(object[key]);
  for (const char* key : {"t_ms", "time_ms", "millis"})
    if (object.contains(key) && object[key].is_number())
      line.time_s = object[key].get<double>() / kMilliseconds;
  if (object.contains("links") && object["links"].is_array())
    for (const auto& link : object["links"]) {
      const bool whole = link.is_object() && link.contains("A") && link.contains("R");
      if (whole && !name_in(link["A"]).empty())
        line.ranges.push_back({name_in(link["A"]), tag, number_in(link["R"])});
      else
        ++line.garbled;
    }
  if (object.contains("range") && object["range"].is_array())
    for (std::size_t i = 0; i < object["range"].size(); ++i)
      line.ranges.push_back({fmt::format("{}", i), tag, number_in(object["range"][i]) / kCentimetres});
}

/// The text in the brackets behind a key; empty if there is none.
std::string_view listed_behind(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  if (at == std::string_view::npos) return {};
  const std::size_t end = text.find(')', at);
  return end == std::string_view::npos ? std::string_view()
                                       : text.substr(at + key.size(), end - at - key.size());
}

void read_makerfabs_command(std::string_view payload, KitLine& line) {
  const std::size_t tid = payload.find("tid:");
  const std::string_view after = tid == std::string_view::npos ? "" : payload.substr(tid + 4);
  const std::string tag(without_blanks(after.substr(0, after.find(','))));
  const auto ranges = fields_at(listed_behind(payload, "range:("), ','),
             names = fields_at(listed_behind(payload, "ancid:("), ',');
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    double range_cm = 0.0;
    const bool named = names.size() == ranges.size();
    if (named && names[i].starts_with('-')) continue;
    if (logged_number(ranges[i], range_cm))
      line.ranges.push_back(
          {named ? std::string(names[i]) : fmt::format("{}", i), tag, range_cm / kCentimetres});
    else
      ++line.garbled;
  }
}

/// `from: 1782  Range: 2.35 m  RX power: -72.30 dBm`
bool read_makerfabs_serial(std::string_view line, KitLine& out) {
  constexpr std::string_view kFrom = "from:", kRange = "Range:";
  const std::size_t from = line.find(kFrom), range = line.find(kRange);
  if (from == std::string_view::npos || range == std::string_view::npos || range < from) return false;
  out.begin = from;
  const std::string_view name = without_blanks(line.substr(from + kFrom.size(), range - from - kFrom.size()));
  std::string_view value = without_blanks(line.substr(range + kRange.size()));
  value = value.substr(0, value.find_first_of(" \tm"));
  double range_m = 0.0;
  if (!name.empty() && logged_number(value, range_m))
    out.ranges.push_back({std::string(name), "", range_m});
  else
    ++out.garbled;
  return true;
}

/// The number before a unit, from the right end of a text; its begin.
std::size_t number_before(std::string_view text, double& value) {
  const std::string_view trimmed = without_blanks(text);
  std::size_t begin = trimmed.size();
  while (begin > 0 &&
         (std::isdigit(static_cast<unsigned char>(trimmed[begin - 1])) != 0 || trimmed[begin - 1] == '.'))
    --begin;
  if (!logged_number(trimmed.substr(begin), value)) return std::string_view::npos;
  return static_cast<std::size_t>(trimmed.data() - text.data()) + begin;
}

}  // namespace

std::vector<std::string_view> fields_at(std::string_view line, char delimiter) {
  std::vector<std::string_view> fields;
  while (fields.size() < kMostFields) {
    const std::size_t end = line.find(delimiter);
    fields.push_back(without_blanks(line.substr(0, end)));
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  return fields;
}

bool logged_number(std::string_view text, double& value) {
  return parse_number(text, value) == NumberText::kNumber && std::isfinite(value);
}

std::optional<KitLine> dwm1001_line(std::string_view line) {
  KitLine out;
  if (const std::size_t lec = line.find("DIST,"); lec != std::string_view::npos) {
    out.begin = lec;
    read_lec(line.substr(lec), out);
    return out;
  }
  const std::size_t group = line.find("]=");
  const std::size_t open = group == std::string_view::npos ? group : line.rfind('[', group);
  if (open == std::string_view::npos) return std::nullopt;
  out.begin = open;
  while (out.begin > 0 && is_hexadecimal(line[out.begin - 1])) --out.begin;
  read_les(line.substr(out.begin), out);
  return out;
}

std::optional<KitLine> trek1000_line(std::string_view line) { return trek_line(line, "mc "); }
std::optional<KitLine> trek1000_raw_line(std::string_view line) { return trek_line(line, "mr "); }

std::optional<KitLine> makerfabs_line(std::string_view line) {
  KitLine out;
  if (const std::size_t command = line.find("AT+RANGE="); command != std::string_view::npos) {
    out.begin = command;
    read_makerfabs_command(line.substr(command), out);
    return out;
  }
  if (read_makerfabs_serial(line, out)) return out;
  out.begin = line.find('{');
  if (out.begin == std::string_view::npos ||
      (line.find("\"links\"") == std::string_view::npos && line.find("\"range\"") == std::string_view::npos))
    return std::nullopt;
  const auto object = nlohmann::json::parse(line.substr(out.begin), nullptr, false);
  if (object.is_object()) {
    read_makerfabs_json(object, out);
  } else {
    ++out.garbled;  // two lines that were written at the same time, or the end of one is missing
  }
  return out;
}

std::optional<KitLine> pozyx_line(std::string_view line) {
  const std::size_t mm = line.find("mm"), ms = line.substr(0, mm).rfind("ms");
  double distance_mm = 0.0, time_ms = 0.0;
  if (mm == std::string_view::npos || ms == std::string_view::npos ||
      number_before(line.substr(0, mm), distance_mm) == std::string_view::npos)
    return std::nullopt;
  KitLine out;
  out.begin = number_before(line.substr(0, ms), time_ms);
  if (out.begin == std::string_view::npos) return std::nullopt;
  out.time_s = time_ms / kMilliseconds;
  std::string name = "anchor";
  if (const std::size_t address = line.find("0x"); address != std::string_view::npos) {
    std::size_t end = address + 2;
    while (end < line.size() && is_hexadecimal(line[end])) ++end;
    name = line.substr(address, end - address);
    out.begin = std::min(out.begin, address);
  }
  out.ranges.push_back({name, "", distance_mm / kMillimetres});
  return out;
}

}  // namespace octant::io
