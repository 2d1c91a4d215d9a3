// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/column_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <vector>

#include "io/table/column_unit.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

using Words = std::span<const std::string_view>;

constexpr std::string_view kTimeWords[] = {
    "time",   "timestamp", "stamp",       "ts",      "t",       "tstamp", "datetime",
    "date",   "zeit",      "zeitstempel", "datum",   "uhrzeit", "clock",  "millis",
    "micros", "ticks",     "tick",        "seconds", "secs",    "day",    "sekunden"};
constexpr std::string_view kDistanceWords[] = {"distance", "dist",       "range",   "ranging",     "r",
                                               "d",        "rng",        "abstand", "entfernung",  "distanz",
                                               "strecke",  "reichweite", "laenge",  "l\xC3\xA4nge"};
constexpr std::string_view kTofWords[] = {
    "tof", "toa", "laufzeit", "flugzeit", "signallaufzeit", "timeofflight", "flighttime", "traveltime"};
constexpr std::string_view kBeaconWords[] = {
    "anchor",   "beacon",      "anker",     "bake",     "basis",  "base", "node",   "knoten",
    "station",  "transmitter", "sender",    "source",   "src",    "tx",   "aid",    "bid",
    "anchorid", "beaconid",    "responder", "landmark", "sensor", "peer", "remote", "dest",
    "target",   "address",     "addr",      "an",       "uwb",    "frame"};
constexpr std::string_view kLetterWords[] = {"a", "b", "n", "s", "p"};  // with a number: "A1"
constexpr std::string_view kReceiverWords[] = {"receiver",         "tag",        "tagid",  "rx",
                                               "empf\xC3\xA4nger", "empfaenger", "mobile", "hedgehog",
                                               "initiator",        "antenna",    "antenne"};
constexpr std::string_view kVehicleWords[] = {"vehicle", "robot",  "fahrzeug", "roboter",
                                              "drone",   "drohne", "rover",    "agv"};
constexpr std::string_view kEpochWords[] = {"epoch",      "stop",       "halt",     "stopp",
                                            "haltepunkt", "standpunkt", "messpunkt"};
constexpr std::string_view kTemperatureWords[] = {"temperature", "temp", "temperatur"};
/// Words of other quantities, or of the quality of a measurement.
constexpr std::string_view kOtherWords[] = {
    "error",     "err",        "fehler",  "std",      "stddev",  "sigma", "var",   "rssi",
    "rss",       "rxpower",    "fppower", "power",    "quality", "qf",    "q",     "qual",
    "snr",       "los",        "nlos",    "cir",      "gt",      "true",  "truth", "ref",
    "reference", "wahr",       "soll",    "velocity", "speed",   "vel",   "x",     "y",
    "z",         "pos",        "est",     "valid",    "count",   "seq",   "state", "status",
    "residual",  "confidence", "num",     "number",   "offset",  "bias",  "phase", "angle"};
/// Words around a name that do not belong to it.
constexpr std::string_view kAroundWords[] = {"to",    "from", "zu",  "zur",      "zum",
                                             "von",   "raw",  "roh", "measured", "gemessen",
                                             "value", "wert", "in",  "of",       "m"};

bool is_in(Words words, std::string_view word) { return std::ranges::find(words, word) != words.end(); }

/// A word of a name: letters or digits that follow each other.
struct Word {
  std::string text;  ///< lower case
  std::size_t begin, end;
};

enum class Kind { kNone, kLower, kUpper, kDigit };

Kind letter_kind(char c) {
  const auto byte = static_cast<unsigned char>(c);
  if (std::isdigit(byte) != 0) return Kind::kDigit;
  if (std::isupper(byte) != 0) return Kind::kUpper;
  return std::islower(byte) != 0 || byte >= 0x80 ? Kind::kLower : Kind::kNone;
}

std::vector<Word> words_of(std::string_view name) {
  std::vector<Word> words;
  for (std::size_t i = 0; i < name.size();) {
    const Kind first = letter_kind(name[i]);
    std::size_t end = i + 1;
    if (first == Kind::kNone) {
      i = end;
      continue;
    }
    for (; end < name.size(); ++end) {
      const Kind before = letter_kind(name[end - 1]), now = letter_kind(name[end]);
      if (now != before && !(before == Kind::kUpper && now == Kind::kLower)) break;
    }
    words.push_back({lower_case(name.substr(i, end - i)), i, end});
    i = end;
  }
  return words;
}

/// "time of flight" and similar pairs as one word.
void join_pairs(std::vector<Word>& words) {
  const auto joins = [](std::string_view a, std::string_view b) {
    return (b == "flight" && (a == "time" || a == "of")) || (b == "of" && a == "time") ||
           (a == "flight" && b == "time") || (a == "travel" && b == "time") ||
           (a == "timeof" && b == "flight");
  };
  for (std::size_t i = 0; i + 1 < words.size();) {
    if (!joins(words[i].text, words[i + 1].text)) {
      ++i;
      continue;
    }
    words[i].text += words[i + 1].text;
    words[i].end = words[i + 1].end;
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  }
}

/// The name of a beacon that is left without the words of the measurement.
std::string beacon_in_name(std::string_view name, const std::vector<Word>& words) {
  std::size_t first = 0, last = words.size();
  const auto strange = [](const Word& word) {
    return is_in(kDistanceWords, word.text) || is_in(kTofWords, word.text) || is_in(kAroundWords, word.text);
  };
  while (first < last && strange(words[first])) ++first;
  while (last > first && strange(words[last - 1])) --last;
  return first < last ? std::string(name.substr(words[first].begin, words[last - 1].end - words[first].begin))
                      : "";
}

/// "A1", "Anchor 3", "0x1782", "28486".
bool is_name_of_beacon(std::string_view name, const std::vector<Word>& words) {
  const bool digits = !name.empty() &&
                      std::ranges::all_of(name, [](unsigned char c) { return std::isxdigit(c) != 0; }) &&
                      std::ranges::any_of(name, [](unsigned char c) { return std::isdigit(c) != 0; });
  if (digits && name.size() <= 16 && (words.size() == 1 || name.size() >= 4)) return true;
  const auto numbered = [&](std::size_t i) { return letter_kind(name[words[i].begin]) == Kind::kDigit; };
  if (words.size() == 4 && (words[0].text == "t" || words[0].text == "tag") && numbered(1) && numbered(3))
    return is_in(kBeaconWords, words[2].text) || is_in(kLetterWords, words[2].text);
  return words.size() == 2 && (is_in(kBeaconWords, words[0].text) || is_in(kLetterWords, words[0].text)) &&
         numbered(1);
}

}  // namespace

NamedColumn meaning_of(std::string_view full_name) {
  const std::string_view name = without_unit(full_name);
  std::vector<Word> words = words_of(name);
  join_pairs(words);
  const auto any = [&](Words of) {
    return std::ranges::any_of(words, [&](const Word& word) { return is_in(of, word.text); });
  };
  if (words.empty()) return {};
  const std::string lower = lower_case(full_name);
  if (lower.starts_with("0x")) return {ColumnRole::kBeaconName, std::string(name)};
  if (lower == "from" || lower == "to" || lower == "src" || lower == "dst")
    return {.role = ColumnRole::kBeacon, .is_end = true};
  if (lower == "id") return {.role = ColumnRole::kBeacon, .is_vague = true};
  if (lower == "x_value") return {ColumnRole::kTime, ""};  // LabVIEW
  if (any(kOtherWords) || words.front().text == "unnamed" || words.front().text == "index") {
    // ROS writes the time of a message and of its header: "field.header.stamp", "field.header.seq".
    return {any(kTimeWords) && !any(kDistanceWords) ? ColumnRole::kTime : ColumnRole::kUnknown, ""};
  }
  if (any(kTofWords)) return {ColumnRole::kTof, beacon_in_name(name, words)};
  if (any(kDistanceWords)) return {ColumnRole::kDistance, beacon_in_name(name, words)};
  if (is_name_of_beacon(name, words)) return {ColumnRole::kBeaconName, std::string(name)};
  if (words.size() > 1) std::erase_if(words, [](const Word& word) { return word.text == "t"; });
  if (any(kTimeWords)) return {ColumnRole::kTime, ""};
  if (any(kReceiverWords)) return {ColumnRole::kReceiver, ""};
  if (any(kVehicleWords)) return {ColumnRole::kVehicle, ""};
  if (any(kBeaconWords)) return {ColumnRole::kBeacon, ""};
  if (any(kEpochWords)) return {ColumnRole::kEpoch, ""};
  if (any(kTemperatureWords)) return {ColumnRole::kTemperature, ""};
  const bool is_unit_of_time =
      words.size() == 1 && unit_of_column(full_name, "time_s") && is_unit(full_name) && full_name.size() > 1;
  if (is_unit_of_time) return {ColumnRole::kTime, ""};
  return {};
}

}  // namespace octant::io
