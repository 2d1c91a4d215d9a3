// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/column_unit.h"

#include <cctype>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "io/text/text.h"

namespace octant::io {
namespace {

struct Unit {
  std::string_view name;      ///< lower case
  std::string_view quantity;  ///< the SI unit at the end of the target's name
  UnitConversion conversion;
  bool clear = true;  ///< recognised behind an underscore too; others are words or letters of other meaning
};

constexpr std::string_view kCounts = "counts";          // of a clock that the name does not state
constexpr double kRadioTick_s = 1.0 / (128 * 499.2e6);  // of the counters of UWB radios (DW1000, DW3000)

constexpr Unit kColumnUnits[] = {
    {"s", "s", {1.0}},
    {"sec", "s", {1.0}},
    {"secs", "s", {1.0}},
    {"seconds", "s", {1.0}},
    {"sek", "s", {1.0}},
    {"sekunden", "s", {1.0}},
    {"ms", "s", {1e-3}},
    {"msec", "s", {1e-3}},
    {"millis", "s", {1e-3}},
    {"milliseconds", "s", {1e-3}},
    {"millisekunden", "s", {1e-3}},
    {"us", "s", {1e-6}},
    {"\xC2\xB5s", "s", {1e-6}},  // micro sign
    {"\xCE\xBCs", "s", {1e-6}},  // Greek mu
    {"usec", "s", {1e-6}},
    {"usecs", "s", {1e-6}},
    {"micros", "s", {1e-6}},
    {"microseconds", "s", {1e-6}},
    {"mikrosekunden", "s", {1e-6}},
    {"ns", "s", {1e-9}},
    {"nsec", "s", {1e-9}},
    {"nsecs", "s", {1e-9}},
    {"nanosec", "s", {1e-9}},
    {"nanos", "s", {1e-9}},
    {"nanoseconds", "s", {1e-9}},
    {"ps", "s", {1e-12}},
    {"dtu", "s", {kRadioTick_s}},
    {"dwt", "s", {kRadioTick_s}},
    {"min", "s", {60.0}, false},
    {"h", "s", {3600.0}, false},
    {"ticks", kCounts, {1.0}},
    {"counts", kCounts, {1.0}},
    {"m", "m", {1.0}},
    {"metres", "m", {1.0}},
    {"meter", "m", {1.0}},
    {"metre", "m", {1.0}},
    {"meters", "m", {1.0}},
    {"dm", "m", {0.1}},
    {"cm", "m", {1e-2}},
    {"mm", "m", {1e-3}},
    {"km", "m", {1e3}},
    {"ft", "m", {0.3048}},
    {"feet", "m", {0.3048}},
    {"in", "m", {0.0254}, false},
    {"inch", "m", {0.0254}},
    {"yd", "m", {0.9144}},
    {"v", "v", {1.0}},
    {"mv", "v", {1e-3}},
    {"uv", "v", {1e-6}},
    {"degc", "degC", {1.0}},
    {"\xC2\xB0"
     "c",
     "degC",
     {1.0}},  // degree sign
    {"celsius", "degC", {1.0}},
    {"grad", "degC", {1.0}, false},
    {"c", "degC", {1.0}, false},
    {"degf", "degC", {5.0 / 9.0, -160.0 / 9.0}},
    {"\xC2\xB0"
     "f",
     "degC",
     {5.0 / 9.0, -160.0 / 9.0}},
    {"f", "degC", {5.0 / 9.0, -160.0 / 9.0}, false},
    {"kelvin", "degC", {1.0, -273.15}},
    {"k", "degC", {1.0, -273.15}, false},
};

const Unit* unit_named(std::string_view text) {
  const std::string name = lower_case(text);
  for (const Unit& unit : kColumnUnits)
    if (unit.name == name) return &unit;
  return nullptr;
}

/// Text in the brackets at the end of a name; empty without brackets.
std::string_view bracketed(std::string_view name) {
  for (const auto& [open, close] : {std::pair{'[', ']'}, {'(', ')'}, {'{', '}'}, {'<', '>'}}) {
    const std::size_t begin = name.rfind(open);
    if (name.ends_with(close) && begin != std::string_view::npos)
      return without_blanks(name.substr(begin + 1, name.size() - begin - 2));
  }
  return {};
}

/// The unit at the end of a name without brackets, and where it begins.
struct UnitAtEnd {
  const Unit* unit = nullptr;
  std::size_t begin = 0;
};

UnitAtEnd unit_at_end(std::string_view name) {
  const std::size_t at = name.find_last_of("_ ./-");
  const std::size_t begin = at == std::string_view::npos ? 0 : at + 1;
  UnitAtEnd found{unit_named(name.substr(begin)), begin};
  const bool in = at != std::string_view::npos && name.substr(0, at).ends_with(" in");  // "range in ft"
  if (found.unit != nullptr && (found.unit->clear || in) && (begin > 0 || name.size() > 1)) return found;
  // "timestampMs"
  std::size_t capital = name.size();
  while (capital > begin && std::islower(static_cast<unsigned char>(name[capital - 1])) != 0) --capital;
  if (capital < begin + 2 || capital == name.size() ||
      std::isupper(static_cast<unsigned char>(name[capital - 1])) == 0 ||
      std::islower(static_cast<unsigned char>(name[capital - 2])) == 0)
    return {};
  found = {unit_named(name.substr(capital - 1)), capital - 1};
  return found.unit != nullptr && found.unit->clear ? found : UnitAtEnd{};
}

/// The name without the origin of a time: "ms_of_day", "seconds since start".
std::string_view without_origin(std::string_view name) {
  for (const char* word : {"_of_day", " of day", "_since_", " since "})
    if (const std::size_t at = lower_case(name).find(word); at != std::string::npos && at > 0)
      return name.substr(0, at);
  return name;
}

std::string names_of_units(std::string_view quantity) {
  std::vector<std::string> names;
  for (const Unit& unit : kColumnUnits)
    if (unit.quantity == quantity) names.emplace_back(unit.name);
  return listed(names, 32);
}

}  // namespace

Result<UnitConversion> unit_of_column(std::string_view name, std::string_view target) {
  const std::string_view quantity = target.substr(target.rfind('_') + 1);
  const auto refuse = [&](std::string found) {
    return fail({.code = Errc::kBadInput,
                 .found = std::move(found),
                 .expected = fmt::format("a unit of {}: {}", target, names_of_units(quantity)),
                 .advice = fmt::format("state the factor: {}={}*FACTOR", target, name)});
  };
  const std::string_view brackets = bracketed(name);
  const Unit* unit = nullptr;
  if (!brackets.empty()) {
    unit = unit_named(brackets);
    if (unit == nullptr || unit->quantity == kCounts)
      return refuse(fmt::format("column {} states the unit {}", in_quotes(name), in_quotes(brackets)));
  } else {
    unit = unit_at_end(without_origin(name)).unit;
  }
  if (unit == nullptr) return UnitConversion{};
  if (unit->quantity == quantity) return unit->conversion;
  return refuse(fmt::format("column {} is in {}", in_quotes(name), in_quotes(unit->name)));
}

double factor_of_doubtful_unit(std::string_view name, std::string_view target) {
  const std::size_t at = name.find_last_of("_ ./-");
  const Unit* unit = at == std::string_view::npos || at == 0 ? nullptr : unit_named(name.substr(at + 1));
  const bool doubtful = unit != nullptr && !unit->clear && unit_at_end(name).unit == nullptr &&
                        unit->quantity == target.substr(target.rfind('_') + 1);
  return doubtful ? unit->conversion.factor : 1.0;
}

std::string_view without_unit(std::string_view name) {
  if (!bracketed(name).empty()) return without_blanks(name.substr(0, name.find_last_of("[({<")));
  if (const UnitAtEnd end = unit_at_end(name);
      end.unit != nullptr && end.begin > 0 && end.unit->quantity != kCounts) {
    name = without_blanks(name.substr(0, end.begin));
    while (!name.empty() && std::string_view("_ ./-").find(name.back()) != std::string_view::npos)
      name.remove_suffix(1);
    if (name.ends_with(" in")) name.remove_suffix(3);
  }
  return name;
}

bool is_unit(std::string_view text) {
  const std::string_view brackets = bracketed(text);
  return unit_named(brackets.empty() ? text : brackets) != nullptr;
}

}  // namespace octant::io
