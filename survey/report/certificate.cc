// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report/certificate.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "survey/geometry/quantity.h"
#include "survey/report/report.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

/// Coverage factor: 95 % of a normal distribution, as EA-4/02 and ILAC-P14 have it.
constexpr double kCoverageFactor = 2.0;
constexpr std::size_t kDigestShown = 12;
/// Dots: Markdown has a meaning for underscores.
constexpr const char* kToFillIn = ". . . . . . . . . . . . . . . .";

std::string or_line(const std::string& text) { return text.empty() ? kToFillIn : text; }

std::string certificate_number(const Deployment& d, const CertificateInput& input) {
  if (!input.number.empty()) return input.number;
  return fmt::format("{}-{}", d.site.empty() ? "site" : d.site, input.digest.substr(0, kDigestShown));
}

ReportSection identification(const Deployment& d, const CertificateInput& input) {
  FactTable table("identification", "This record and what it is about");
  table.add("certificate", certificate_number(d, input));
  table.add("calibrated by", or_line(input.organisation));
  table.add("operator", or_line(input.operator_name));
  table.add("customer", or_line(input.customer));
  table.add("place", or_line(input.place));
  table.add("item",
            fmt::format("site {}: {} beacons, {} receivers on {} vehicles", d.site.empty() ? "-" : d.site,
                        d.beacons.size(), d.receivers.size(), d.vehicles.size()));
  table.add("calibrated", d.created);
  table.add("issued", or_line(input.issued));
  table.add("deployment file, SHA-256", input.digest);
  return {"identification",
          "Identification",
          {table, ReportText{"The results relate to the items above as they were when they were calibrated. "
                             "This record is to be copied whole only."}}};
}

ReportSection conditions(const Deployment& d) {
  FactTable table("conditions-table", "During the recordings");
  if (const auto& range = d.validity_temperature_degC)
    table.add("air temperature", fmt::format("{:.1f} to {:.1f} degC", (*range)[0], (*range)[1]));
  if (d.medium.model == MediumModel::kCramer1993) {
    table.add("relative humidity, as stated", fmt::format("{:.0f} %", 100 * d.medium.relative_humidity));
    table.add("air pressure, as stated", fmt::format("{:.0f} hPa", d.medium.pressure_pa / 100));
  }
  table.add("arrivals used", fmt::format("{}", d.statistics.arrivals));
  table.add("arrivals left out", fmt::format("{}", d.statistics.rejected));
  return {"conditions", "Conditions", {table}};
}

ReportSection method(const Deployment& d) {
  FactTable table("method-table", "Program and data");
  table.add("program", "octant " + d.program_version);
  table.add("command", d.program_command);
  for (const InputDigest& file : d.inputs) table.add(file.path, "SHA-256 " + file.sha256);
  return {
      "method",
      "Method",
      {ReportText{
           "Times of flight between beacons and receivers are adjusted together (bundle adjustment, least "
           "squares after the rejection of outliers) for the places of beacons and receivers, delays, the "
           "speed of the medium and the vehicle's poses."},
       table}};
}

ReportSection traceability(const Deployment& d) {
  ReportList list;
  list.items.push_back("Position, orientation and scale: " + d.datum.description + ".");
  if (!d.datum.control_points.empty())
    list.items.push_back(fmt::format(
        "Control points {} were taken as the site file states them; their own traceability is that of "
        "the survey they come from.",
        fmt::join(d.datum.control_points, ", ")));
  list.items.push_back(fmt::format(
      "Speed of the medium: {}; scale from it is as traceable as the thermometer.", speed_in_words(d)));
  list.items.push_back("Time: the recorder's clock, taken without an uncertainty of its own.");
  return {"traceability", "Metrological traceability", {list}};
}

std::string expanded(double sigma, bool held, double per_si, const char* format) {
  return held ? "held" : fmt::format(fmt::runtime(format), kCoverageFactor * per_si * sigma);
}

ReportSection results(const Deployment& d) {
  double largest_s = 1e-9;
  for (const DeploymentBeacon& b : d.beacons)
    largest_s = std::max({largest_s, std::abs(b.delay_s), b.delay_sigma_s});
  const Unit time = time_unit(largest_s);
  ReportTable table{"results-table",
                    "Beacons as left, with expanded uncertainties U",
                    {{"beacon", true},
                     {"x [m]"},
                     {"U [mm]"},
                     {"y [m]"},
                     {"U [mm]"},
                     {"z [m]"},
                     {"U [mm]"},
                     {fmt::format("delay [{}]", time.symbol)},
                     {fmt::format("U [{}]", time.symbol)},
                     {"status", true}}};
  for (const DeploymentBeacon& b : d.beacons) {
    std::vector<ReportText> row = {{b.name}};
    if (b.status == BeaconStatus::kUndetermined) {
      row.resize(9);
      row.push_back({in_words(b.status), Tone::kBad});
      table.rows.push_back(std::move(row));
      continue;
    }
    for (int i = 0; i < 3; ++i) {
      const double sigma_m = std::sqrt(std::max(0.0, b.covariance_m2(i, i)));
      row.push_back({fmt::format("{:.4f}", b.position_m[i])});
      row.push_back({expanded(sigma_m, sigma_m == 0.0, 1e3, "{:.1f}")});
    }
    row.push_back({fmt::format("{:.2f}", time.per_si * b.delay_s)});
    row.push_back({expanded(b.delay_sigma_s, b.delay_sigma_s == 0.0, time.per_si, "{:.2f}")});
    row.push_back({in_words(b.status)});
    table.rows.push_back(std::move(row));
  }
  return {"results",
          "Results",
          {table, ReportText{fmt::format("Speed of the medium: {}.", speed_in_words(d))},
           ReportText{fmt::format(
               "U is the standard uncertainty times the coverage factor k = {:g}, which is a coverage "
               "probability of some 95 % for normal errors. Standard uncertainties come from the "
               "adjustment and from the correlations that its residuals show; those of statements "
               "that were held (control points) are not part of it.",
               kCoverageFactor)}}};
}

/// The state before the recalibration, where there was one.
std::optional<ReportSection> as_found(const Deployment& d) {
  if (!d.previous) return {};
  ReportSection section{"as-found", "As found"};
  section.blocks.emplace_back(ReportText{
      fmt::format("Against the calibration of {} (SHA-256 {}). What is not listed was found as it was left "
                  "then, within chance and the drift that was allowed for.",
                  d.previous->created, d.previous->sha256)});
  ReportTable table{"as-found-table",
                    "Found to have changed, as found less as left before",
                    {{"what", true}, {"kind", true}, {"size"}, {"U"}, {"p"}}};
  for (const Change& c : d.previous->changes) {
    const bool time = c.kind == ChangeKind::kDelay;
    const bool length = std::string_view(unit_of(c.kind)) == "m";
    const Unit unit = time     ? time_unit(std::abs(c.size))
                      : length ? length_unit(std::abs(c.size))
                               : Unit{1.0, unit_of(c.kind), unit_of(c.kind)};
    table.rows.push_back({{c.subject},
                          {to_string(c.kind)},
                          {fmt::format("{:.3g} {}", unit.per_si * c.size, unit.symbol)},
                          {fmt::format("{:.2g} {}", kCoverageFactor * unit.per_si * c.sigma, unit.symbol)},
                          {fmt::format("{:.2g}", c.p)}});
  }
  if (table.rows.empty())
    section.blocks.emplace_back(ReportText{"Nothing was found to have changed."});
  else
    section.blocks.emplace_back(std::move(table));
  return section;
}

struct Conformity {
  std::size_t inside = 0, asked = 0;
  double worst_m = 0.0;
};

Conformity conformity_of(const Deployment& d, double tolerance_m) {
  Conformity c;
  for (const DeploymentBeacon& b : d.beacons) {
    if (b.status == BeaconStatus::kControlPoint) continue;
    ++c.asked;
    if (b.status == BeaconStatus::kUndetermined) continue;
    const double radius_m = radius95_m(b);
    c.worst_m = std::max(c.worst_m, radius_m);
    c.inside += radius_m < tolerance_m;
  }
  return c;
}

ReportSection conformity(const Deployment& d) {
  ReportSection section{"conformity", "Statement of conformity"};
  if (!d.tolerance.beacon_m) {
    section.blocks.emplace_back(ReportText{"The site file states no tolerance: none is made."});
    return section;
  }
  const Conformity c = conformity_of(d, *d.tolerance.beacon_m);
  const bool passes = c.inside == c.asked && d.contradictions.empty();
  section.blocks.emplace_back(ReportText{
      fmt::format(
          "{}: {} of {} calibrated beacons are within {:.0f} mm in the plane; the worst radius is {:.1f} mm.",
          passes ? "Conforms" : "Does not conform", c.inside, c.asked, 1e3 * *d.tolerance.beacon_m,
          1e3 * c.worst_m),
      passes ? Tone::kGood : Tone::kBad});
  section.blocks.emplace_back(ReportText{
      "Decision rule: a beacon conforms where the ellipse in which it lies with 95 % is within the tolerance "
      "(guard band of the expanded uncertainty), so that one which is stated to conform lies outside with a "
      "probability of at most 5 %. Control points are taken as stated and not judged."});
  for (const Contradiction& x : d.contradictions)
    section.blocks.emplace_back(
        ReportText{fmt::format("The data contradict the site file: {}, stated {}, found {}.", x.subject,
                               x.stated, x.found),
                   Tone::kBad});
  return section;
}

}  // namespace

ReportDocument certificate_document(const Deployment& d, const CertificateInput& input) {
  ReportDocument document;
  document.title = "Calibration record " + certificate_number(d, input);
  document.subtitle = d.site;
  const ReportSection judged = conformity(d);
  document.tone = d.tolerance.beacon_m ? std::get<ReportText>(judged.blocks.front()).tone : Tone::kPlain;
  document.grade = document.tone == Tone::kGood  ? "Conforms"
                   : document.tone == Tone::kBad ? "Does not conform"
                                                 : "No tolerance stated";
  document.sentence = std::get<ReportText>(judged.blocks.front()).text;
  document.sections = {identification(d, input), conditions(d), method(d), traceability(d), results(d)};
  if (auto found = as_found(d)) document.sections.push_back(std::move(*found));
  document.sections.push_back(judged);
  document.sections.push_back({"signature",
                               "Authorised by",
                               {ReportText{fmt::format("Name, date, signature: {}", kToFillIn)},
                                ReportText{"Made by a program from the data named above, in the order of "
                                           "ISO/IEC 17025:2017, 7.8. It claims no "
                                           "accreditation of whoever made it."}}});
  return document;
}

}  // namespace octant::survey
