// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/page/survey_verdict.h"

#include <cmath>

#include <fmt/format.h>

#include "survey/geometry/quantity.h"

namespace octant::survey {
namespace {

constexpr double kNearlyAll = 0.99;
/// Fraction of the floor beyond the tolerance from which the failure of a beacon is mentioned.
constexpr double kMuchLost = 0.05;

/// Where a fix is one of two places.
std::string mirrored_part_of(const Survey& s) {
  return s.mirror_fraction > 0 ? fmt::format(", in {} a mirror image explains the ranges as well",
                                             percent_text(s.mirror_fraction))
                               : std::string();
}

/// Fractions of the floor within the tolerance, beyond it, and without a fix.
std::string parts_of(const Survey& s) {
  constexpr double kRounded = 1e-9;
  const double beyond = s.fix_fraction - s.covered_fraction - s.mirror_fraction, none = 1 - s.fix_fraction;
  std::string text =
      fmt::format("{} of the floor is within the tolerance of {}", percent_text(s.covered_fraction),
                  figure_text(*s.model.tolerance.fix_m, "m"));
  text += mirrored_part_of(s);
  if (beyond > kRounded) text += fmt::format(", {} beyond it", percent_text(beyond));
  if (none > kRounded) text += fmt::format(", {} without a fix", percent_text(none));
  return text + ".";
}

/// Returns true if fewer beacons are received than the scene requires.
bool lacks_beacons(const Survey& s) { return s.scene.coverage > 0 && s.k_covered_fraction < kNearlyAll; }

bool reach_is_known(const Survey& s) { return std::isfinite(reach_m(s.model.hearing)); }

std::vector<std::string> steps_of(const Survey& s, Grade grade) {
  std::vector<std::string> steps;
  if (!s.model.tolerance.fix_m)
    steps.emplace_back("State tolerance.fix_m in the site file: what a fix must reach.");
  if (grade == Grade::kPoor) {
    const std::string coverage = lacks_beacons(s) ? fmt::format(" --coverage {}", s.scene.coverage) : "";
    steps.push_back(
        fmt::format("Look at the map for where; octant plan SITE.yaml {}{} says which beacons would do.",
                    s.model.tolerance.fix_m ? fmt::format("--tolerance {:g}", *s.model.tolerance.fix_m)
                                            : fmt::format("--beacons {}", s.model.beacons.size() + 1),
                    coverage));
  }
  if (!reach_is_known(s))
    steps.emplace_back(
        "State how far a beacon is heard (acoustics.range_m in the scene, --scene): until then every beacon "
        "counts everywhere.");
  if (!s.failures.empty() && s.poses() > 0) {
    const Loss& worst = s.failures.front();
    const double lost = static_cast<double>(worst.poses_out) / static_cast<double>(s.poses());
    if (lost > kMuchLost)
      steps.push_back(fmt::format("Mind {}: without it {} of the floor falls out of tolerance.",
                                  s.model.beacons[worst.first].name, percent_text(lost)));
  }
  if (s.mirror_fraction > 1 - kNearlyAll)
    steps.push_back(
        "Hang a beacon off the line of the others, or let odometry or receivers that are no line tell the "
        "side.");
  if (steps.empty())
    steps.emplace_back(s.calibrated ? "Nothing needs to be done."
                                    : "Nothing: hang the beacons, record, and calibrate.");
  return steps;
}

}  // namespace

SurveyVerdict survey_verdict(const Survey& s) {
  SurveyVerdict v;
  if (s.model.tolerance.fix_m) {
    // Beacons that are assumed to be received everywhere make any floor look well covered; failures despite
    // that are serious.
    v.grade = s.covered_fraction < kNearlyAll ? Grade::kPoor
              : reach_is_known(s)             ? Grade::kGood
                                              : Grade::kUnjudged;
    v.sentence = (reach_is_known(s) ? "" : "if every beacon is heard everywhere, ") + parts_of(s);
  } else {
    v.sentence = fmt::format(
        "{} of the floor has a fix{}. The site states no tolerance (tolerance.fix_m) to hold that against.",
        percent_text(s.fix_fraction), mirrored_part_of(s));
  }
  if (lacks_beacons(s)) {
    v.grade = Grade::kPoor;
    v.sentence += fmt::format(" {} of the floor hears the {} beacons that the scene asks for.",
                              percent_text(s.k_covered_fraction), s.scene.coverage);
  }
  v.next = steps_of(s, v.grade);
  return v;
}

}  // namespace octant::survey
