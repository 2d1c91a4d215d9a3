// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Short summary of a calibration; calibration_text() has all results.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/octant/steps/reporting.h"
#include "apps/octant/text/layout.h"

namespace octant::app {
namespace {

constexpr std::size_t kMovedShown = 5;
constexpr double kBeyondChance = 1e-3;  // significance level of the variance factor's test
constexpr double kMuchMore = 1.2;       // variance factor above which the noise is mentioned

/// Comparison of the residuals with the noise in the site file.
std::string residuals_in_words(const CalibrationStatistics& s) {
  const char* size =
      s.chi2_p > kBeyondChance || (s.variance_factor < kMuchMore && s.variance_factor > 1 / kMuchMore)
          ? "as large as stated"
      : s.variance_factor > 1 ? "larger than stated"
                              : "smaller than stated";
  return fmt::format("{} RMS, {} (variance factor {:.3g}, p = {:.2g})", time_text(s.rms_s), size,
                     s.variance_factor, s.chi2_p);
}

std::string arrivals_in_words(const Calibration& calibration) {
  const CalibrationStatistics& s = calibration.deployment->statistics;
  std::string reasons;
  for (const auto& note : left_out_by_reason(calibration))
    reasons += fmt::format("{}{} {}", reasons.empty() ? ": " : ", ", note.count, note.reason);
  return fmt::format("{} used, {} left out{}", s.arrivals, s.rejected, reasons);
}

/// Beacons that deviate most from their positions in the site file.
std::string moved_text(const std::vector<survey::MovedNote>& moved) {
  if (moved.empty()) return "";
  const Unit unit = length_unit(moved.front().distance_m);
  const std::string in = fmt::format(" [{}]", unit.name);
  Table table{"lrrrrr",
              {{"moved from site", "dx" + in, "dy" + in, "dz" + in, "known to" + in, "stated within" + in}}};
  const auto length = [&](const std::optional<double>& metres) {
    return metres ? fmt::format("{:.{}f}", unit.per_si * *metres, unit.per_si > 1 ? 1 : 3) : std::string("-");
  };
  for (std::size_t i = 0; i < std::min(kMovedShown, moved.size()); ++i) {
    const survey::MovedNote& m = moved[i];
    table.rows.push_back({m.beacon, length(m.shift_m[0]), length(m.shift_m[1]), length(m.shift_m[2]),
                          length(m.sigma_m), length(m.stated_sigma_m)});
  }
  std::string text = "\n" + table.text();
  if (moved.size() > kMovedShown)
    text += fmt::format("({} more; -v lists all beacons)\n", moved.size() - kMovedShown);
  return text + "\n";
}

}  // namespace

std::vector<survey::MovedNote> moved_from_site(const Calibration& calibration) {
  std::vector<survey::MovedNote> moved;
  const Site& site = calibration.problem.site;
  const auto& found = calibration.deployment->beacons;
  for (std::size_t i = 0; i < std::min(site.beacons.size(), found.size()); ++i) {
    const SiteBeacon& stated = site.beacons[i];
    if (stated.is_control_point() || found[i].status == BeaconStatus::kUndetermined) continue;
    survey::MovedNote note;
    note.beacon = found[i].name;
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
      if (!stated.position_m[k]) continue;
      const double shift_m = found[i].position_m[k] - *stated.position_m[k];
      note.shift_m[k] = shift_m;
      square += shift_m * shift_m;
      note.sigma_m = std::max(note.sigma_m, std::sqrt(std::max(0.0, found[i].covariance_m2(k, k))));
      if (stated.sigma_m[k])
        note.stated_sigma_m = std::max(note.stated_sigma_m.value_or(0.0), *stated.sigma_m[k]);
    }
    note.distance_m = std::sqrt(square);
    if (square > 0) moved.push_back(std::move(note));
  }
  std::ranges::stable_sort(moved, [](const auto& a, const auto& b) { return a.distance_m > b.distance_m; });
  return moved;
}

std::string calibration_summary(const Calibration& calibration, const survey::ReportInput& input) {
  const Deployment& d = *calibration.deployment;
  const survey::Verdict verdict = survey::verdict(input);
  std::string text =
      named_line("verdict", fmt::format("{}: {}", survey::to_string(verdict.grade), verdict.sentence)) +
      moved_text(input.moved);
  if (input.moved.empty()) text += "\n";
  text += named_line("speed", survey::speed_in_words(d)) +
          named_line("arrivals", arrivals_in_words(calibration)) +
          named_line("residuals", residuals_in_words(d.statistics));
  for (const auto& weak : calibration.solution.weak)
    if (weak.remedy.empty())
      text += named_line("weak", weak.description);  // the others are listed as next steps
  for (const std::string& step : survey::next_steps(input)) text += named_line("next", step);
  return text;
}

}  // namespace octant::app
