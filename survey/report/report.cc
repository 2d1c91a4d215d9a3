// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report/report.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "models/support/enum_names.h"
#include "survey/report/report_sections.h"

namespace octant::survey {

std::string speed_in_words(const Deployment& d) {
  std::string text =
      fmt::format("{:.8g} m/s, {}", d.speed_mps(d.medium.temperature_degC),
                  d.speed_sigma_mps > 0 ? fmt::format("sigma {:.2g} m/s", d.speed_sigma_mps) : "held fixed");
  if (d.medium.model == MediumModel::kConstant) return text;
  return text + fmt::format(", at {:g} degC (model {})", d.medium.temperature_degC,
                            std::string(to_string(d.medium.model)));
}

std::string directivity_in_words(const Deployment& d) {
  constexpr double kDegree = std::numbers::pi / 180;
  std::string text =
      fmt::format("3 dB less at {:.4g} degrees off the axis", d.attenuation->half_power_angle_rad / kDegree);
  const int at = d.covariance.index_of(parameters::attenuation(3));
  return at < 0
             ? text
             : text + fmt::format(", sigma {:.2g} degrees", std::sqrt(d.covariance.matrix(at, at)) / kDegree);
}

double radius95_m(const DeploymentBeacon& beacon) {
  // The larger eigenvalue of the 2 x 2 covariance, in closed form.
  const auto& C = beacon.covariance_m2;
  const double largest_m2 = (C(0, 0) + C(1, 1)) / 2 + std::hypot((C(0, 0) - C(1, 1)) / 2, C(0, 1));
  return kEllipse95 * std::sqrt(std::max(0.0, largest_m2));
}

std::string in_words(BeaconStatus status) {
  static constexpr auto kWords = enum_names<BeaconStatus>("calibrated", "control point", "undetermined");
  return kWords[status];
}

std::string as_sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text.empty() || text.back() == '.' ? text : text + ".";
}

ReportText number_cell(const std::optional<double>& value, double per_si, int digits) {
  return {value && std::isfinite(*value) ? fmt::format("{:.{}f}", per_si * *value, digits) : "-"};
}

ReportDocument report_document(const ReportInput& input) {
  const Verdict v = verdict(input);
  ReportDocument document;
  document.title = input.plan.deployment.site.empty() ? "Site" : input.plan.deployment.site;
  document.subtitle =
      input.kind + (input.plan.deployment.created.empty()
                        ? ""
                        : (input.kind == "Verification" ? " of the calibration of " : " of ") +
                              input.plan.deployment.created);
  document.grade = to_string(v.grade);
  document.tone = tone_of(v.grade);
  document.sentence = v.sentence;
  using MakeSection = std::optional<ReportSection> (*)(const ReportInput&);
  // Actions and the plan come first, then the reasons, and last how they were determined.
  constexpr MakeSection kSections[] = {
      next_section,      plan_section,         verdict_section,   warnings_section, changes_section,
      beacons_section,   verification_section, weak_section,      loss_section,     left_out_section,
      residuals_section, words_section,        provenance_section};
  for (const MakeSection make : kSections)
    if (auto section = make(input)) document.sections.push_back(std::move(*section));
  return document;
}

}  // namespace octant::survey
