// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/text/changes_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/text/layout.h"
#include "survey/changes.h"

namespace octant::app {
namespace {

std::string verdict_of(const survey::BeaconChange& c) {
  std::string verdict = c.moved() ? "moved" : "";
  if (c.delay_significant) verdict += verdict.empty() ? "delay changed" : ", delay changed";
  if (c.by_datum) verdict += verdict.empty() ? "shift: see the datum" : "; shift: see the datum";
  return verdict.empty() ? "as before" : verdict;
}

std::string shift_in_words(const Change& c) {
  const Unit unit = length_unit(c.size);
  return fmt::format("x {:+.1f}, y {:+.1f}, z {:+.1f} {}", unit.per_si * c.shift_m.x(),
                     unit.per_si * c.shift_m.y(), unit.per_si * c.shift_m.z(), unit.name);
}

}  // namespace

std::string found_lines(const std::vector<Change>& found) {
  std::string text;
  for (const Change& c : found)
    text += named_line(&c == found.data() ? "changed" : "", fmt::format("{} (p = {:.1g})", in_words(c), c.p));
  return text;
}

std::string in_words(const Change& c) {
  switch (c.kind) {
    case ChangeKind::kBeaconMoved:
      return fmt::format("{} stands {} (sigma {}) from where it was: {}", c.subject, length_text(c.size),
                         length_text(c.sigma), shift_in_words(c));
    case ChangeKind::kDelay:
      return fmt::format("{} {} {} (sigma {}): {}",
                         c.subject == kAllBeaconsSubject ? "all beacons answer" : c.subject + " answers",
                         time_text(std::abs(c.size)), c.size > 0 ? "later" : "earlier", time_text(c.sigma),
                         c.subject == kAllBeaconsSubject ? "other electronics of the vehicle?" : "replaced?");
    case ChangeKind::kReceiver:
      return fmt::format("receiver {} sits {} (sigma {}) from its place: {}", c.subject, length_text(c.size),
                         length_text(c.sigma), shift_in_words(c));
    case ChangeKind::kSpeed:
      return fmt::format(
          "sound is {:.2f} m/s (sigma {:.2f} m/s) {} than the calibration has it at this temperature",
          std::abs(c.size), c.sigma, c.size > 0 ? "faster" : "slower");
    case ChangeKind::kExchanged:
      return fmt::format("beacons {} hang at each other's places, {} apart", c.subject, length_text(c.size));
    case ChangeKind::kDatum:
      return fmt::format("the map as a whole lies {} (sigma {}) from where it was: {}", length_text(c.size),
                         length_text(c.sigma), shift_in_words(c));
    case ChangeKind::kAmplitude:
      return fmt::format("{} is heard at {:.2f} of its amplitude (sigma {:.2f}): dirty, or ageing?",
                         c.subject, c.size, c.sigma);
  }
  return c.subject;
}

std::string in_words(const Silence& s) {
  return fmt::format("{} is silent: {}", s.subject, survey::reception_words(s));
}

std::string remedy_of(const Change& c) {
  switch (c.kind) {
    case ChangeKind::kBeaconMoved: return fmt::format("inspect {} on site, then recalibrate", c.subject);
    case ChangeKind::kDelay:
      if (c.subject == kAllBeaconsSubject)
        return "if the vehicle's electronics or the synchronisation were changed, recalibrate; else inspect "
               "them";
      return fmt::format("if {} was replaced, recalibrate; else inspect its electronics", c.subject);
    case ChangeKind::kReceiver:
      return fmt::format("inspect receiver {}: straighten it, or recalibrate", c.subject);
    case ChangeKind::kSpeed: return "compare the thermometer with another one";
    case ChangeKind::kExchanged:
      return fmt::format("compare the labels of {} with the plan, then recalibrate", c.subject);
    case ChangeKind::kDatum: return "measure the control points again";
    case ChangeKind::kAmplitude: return fmt::format("clean {}", c.subject);
  }
  return {};
}

std::string changes_text(const survey::ReportInput& input) {
  return input.changes ? "\n" + changes_text(*input.changes) : std::string();
}

std::string changes_text(const survey::Changes& changes) {
  double length_m = 0.0, time_s = 0.0;
  for (const auto& c : changes.beacons) {
    length_m = std::max({length_m, c.shift_m.cwiseAbs().maxCoeff(), c.sigma_m.maxCoeff()});
    time_s = std::max({time_s, std::abs(c.delay_change_s), c.delay_sigma_s});
  }
  const Unit length = length_unit(length_m), time = time_unit(time_s);
  Table table{"lrrrrrrl",
              {{"changes", fmt::format("dx [{}]", length.name), "dy", "dz", "s",
                fmt::format("delay [{}]", time.name), "s", ""}}};
  const auto metres = [&](double value) {
    return fmt::format("{:.{}f}", length.per_si * value, length.per_si > 1 ? 1 : 3);
  };
  const auto seconds = [&](double value) {
    return fmt::format("{:.{}f}", time.per_si * value, time.per_si >= 1e6 ? 1 : 3);
  };
  for (const auto& c : changes.beacons)
    table.rows.push_back({c.name, metres(c.shift_m.x()), metres(c.shift_m.y()), metres(c.shift_m.z()),
                          metres(c.sigma_m.maxCoeff()), seconds(c.delay_change_s), seconds(c.delay_sigma_s),
                          verdict_of(c)});
  std::string text = table.text() + "\n" + named_line("changes", survey::changes_sentence(changes)) +
                     found_lines(changes.found);
  if (!changes.same_datum)
    text += named_line("", "the datum is another one: a part of the differences is that of the frame");
  return text;
}

bool add_changes_json(const survey::ReportInput& input, Json& object) {
  if (!input.changes) return false;
  object["changes"] = io::json_of(input.changes->found);
  return true;
}

}  // namespace octant::app
