// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/cockpit/site_edit.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "io/yaml/yaml_writer.h"

namespace octant::app {
namespace {

tl::unexpected<Error> no_change(const std::string& path, std::string found, std::string expected) {
  return fail(
      {.code = Errc::kBadInput, .file = path, .found = std::move(found), .expected = std::move(expected)});
}

/// Position and length of an id in the text: the first value of a key `id` from the beacon's line on.
struct IdPlace {
  std::size_t at = 0, size = 0;
};
std::optional<IdPlace> place_of_id(const std::string& text, const SiteBeacon& beacon) {
  std::size_t at = 0;
  for (int line = 1; line < beacon.line && at != std::string::npos; ++line) {
    at = text.find('\n', at);
    if (at != std::string::npos) ++at;
  }
  while (at != std::string::npos) {
    at = text.find("id", at);
    if (at == std::string::npos) break;
    const bool begins =
        at == 0 || std::string_view(" \t\n{,-\"'").find(text[at - 1]) != std::string_view::npos;
    std::size_t value = text.find_first_not_of("\"' \t", at + 2);
    at += 2;
    if (!begins || value == std::string::npos || text[value] != ':') continue;
    value = text.find_first_not_of("\"' \t", value + 1);
    if (value == std::string::npos || text.compare(value, beacon.name.size(), beacon.name) != 0)
      return std::nullopt;
    return IdPlace{value, beacon.name.size()};
  }
  return std::nullopt;
}

const SiteBeacon* beacon_named(const Site& site, const std::string& name) {
  const auto at = std::ranges::find(site.beacons, name, &SiteBeacon::name);
  return at == site.beacons.end() ? nullptr : &*at;
}

bool is_at_same_place(const SiteBeacon* a, const SiteBeacon* b) {
  return a != nullptr && b != nullptr && a->position_m == b->position_m && a->sigma_m == b->sigma_m;
}

/// Position in the text after a line; lines begin with 1.
std::size_t end_of_line(const std::string& text, int line) {
  std::size_t at = 0;
  for (; line > 0 && at < text.size(); --line) at = std::min(text.find('\n', at), text.size() - 1) + 1;
  return at;
}

}  // namespace

Result<Site> read_text_as_site(const std::string& path, const std::string& text) {
  const std::string trial = path + ".edit.tmp";
  if (auto written = io::write_file(trial, text); !written) return fail(written.error());
  auto site = io::read_site(trial);
  std::remove(trial.c_str());
  return site;
}

Result<void> SiteEdit::exchange(const std::string& a, const std::string& b) {
  const auto site = io::read_site(path_);
  auto text = io::read_file(path_);
  if (!site) return fail(site.error());
  if (!text) return fail(text.error());
  const SiteBeacon *first = beacon_named(*site, a), *second = beacon_named(*site, b);
  if (first == nullptr || second == nullptr || first == second)
    return no_change(path_, fmt::format("no two beacons '{}' and '{}'", a, b), "two ids of the site file");
  auto place_a = place_of_id(*text, *first), place_b = place_of_id(*text, *second);
  const std::string advice = "exchange the two positions in the site file by hand";
  if (!place_a || !place_b) return no_change(path_, "an id that is not a plain text", advice);
  std::string changed = *text;
  const auto replace = [&changed](const IdPlace& place, const std::string& name) {
    changed.replace(place.at, place.size, name);
  };
  if (place_a->at > place_b->at) {
    replace(*place_a, b);
    replace(*place_b, a);
  } else {
    replace(*place_b, a);
    replace(*place_a, b);
  }
  const auto read = read_text_as_site(path_, changed);
  if (!read || !is_at_same_place(beacon_named(*read, a), second) ||
      !is_at_same_place(beacon_named(*read, b), first))
    return no_change(path_, "a layout in which the ids cannot be exchanged", advice);
  if (auto written = io::write_file(path_, changed); !written) return written;
  changes_.push_back({fmt::format("{} and {} exchanged", a, b), std::move(*text), changed});
  return {};
}

Result<void> SiteEdit::append(const std::vector<std::string>& names) {
  const auto site = io::read_site(path_);
  auto text = io::read_file(path_);
  if (!site) return fail(site.error());
  if (!text) return fail(text.error());
  const int line = site->beacons.empty() ? 0 : site->beacons.back().line;
  std::string rows;
  const std::size_t last = end_of_line(*text, line - 1);
  const std::string indent(text->find_first_not_of(' ', last) - last, ' ');
  for (const std::string& name : names) rows += fmt::format("{}- {{id: {}}}\n", indent, io::yaml_text(name));
  const auto with_rows = [&](std::string of) { return of.insert(end_of_line(of, line), rows); };
  const auto read = read_text_as_site(path_, with_rows(*text));
  const bool has_all =
      read && read->beacons.size() == site->beacons.size() + names.size() &&
      is_at_same_place(beacon_named(*read, site->beacons.back().name), &site->beacons.back()) &&
      std::ranges::all_of(names, [&](const auto& name) { return beacon_named(*read, name) != nullptr; });
  if (!has_all)
    return no_change(path_, "a layout to which beacons cannot be added", "add the new beacons by hand");
  if (auto written = io::write_file(path_, with_rows(*text)); !written) return written;
  for (Change& change : changes_)
    for (std::string* of : {&change.before, &change.after}) *of = with_rows(*of);
  return {};
}

Result<void> SiteEdit::undo() {
  if (changes_.empty()) return no_change(path_, "no change", "a change that was accepted here");
  if (const auto text = io::read_file(path_); !text || *text != changes_.back().after)
    return no_change(path_, "the site file was changed by another program", "undo the change there");
  if (auto written = io::write_file(path_, changes_.back().before); !written) return written;
  changes_.pop_back();
  return {};
}

std::vector<std::string> SiteEdit::changes() const {
  std::vector<std::string> words;
  for (const Change& change : changes_) words.push_back(change.words);
  return words;
}

}  // namespace octant::app
