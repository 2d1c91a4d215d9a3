// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "survey/report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace octant::survey {
namespace {

constexpr const char* kStyle = R"(<style>
:root{color-scheme:light dark;--ink:#1b2733;--soft:#5a6875;--line:#d9dfe5;--paper:#fff;--good:#1d7a3c;--bad:#b3261e}
@media(prefers-color-scheme:dark){:root{--ink:#dfe6ec;--soft:#96a3af;--line:#2b353f;--paper:#12181e;--good:#67c587;--bad:#f2867e}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:58rem;margin:2rem auto;padding:0 1rem}
h1{font-size:1.6rem;margin:0}h2{font-size:1.15rem;margin:2rem 0 .5rem}p{margin:.4rem 0}.soft{color:var(--soft)}
.verdict{border-left:.35rem solid var(--good);padding:.5rem 1rem;margin:1rem 0;font-size:1.1rem}.verdict.bad{border-color:var(--bad)}
table{border-collapse:collapse;width:100%}th,td{padding:.25rem .6rem;border-bottom:1px solid var(--line);text-align:right;font-variant-numeric:tabular-nums}
th:first-child,td:first-child,td.text,th.text{text-align:left}th:first-child,td:first-child{white-space:nowrap}td.bad{color:var(--bad)}td.good{color:var(--good)}code{overflow-wrap:anywhere}svg{max-width:100%;height:auto}
</style>
)";

std::string words(BeaconStatus status) {
  switch (status) {
    case BeaconStatus::kCalibrated: return "calibrated";
    case BeaconStatus::kControlPoint: return "control point";
    case BeaconStatus::kUndetermined: return "undetermined";
  }
  return "undetermined";
}

double sigma_m(const DeploymentBeacon& beacon, int axis) { return std::sqrt(std::max(0.0, beacon.covariance_m2(axis, axis))); }

/// Longer half axis of the horizontal 95 % ellipse [m]: the larger eigenvalue of the 2 x 2 covariance, in closed form.
double radius95_m(const DeploymentBeacon& beacon) {
  const auto& C = beacon.covariance_m2;
  const double largest_m2 = (C(0, 0) + C(1, 1)) / 2 + std::hypot((C(0, 0) - C(1, 1)) / 2, C(0, 1));
  return kEllipse95 * std::sqrt(std::max(0.0, largest_m2));
}

/// Unit in which delays of this size are read with ease: microseconds of sound, nanoseconds of radio.
struct TimeUnit {
  double per_s;
  const char* html;
};
TimeUnit delay_unit(const Deployment& deployment) {
  double largest_s = 0.0;
  for (const auto& beacon : deployment.beacons) largest_s = std::max({largest_s, std::abs(beacon.delay_s), beacon.delay_sigma_s});
  return largest_s > 0.0 && largest_s < 1.0e-7 ? TimeUnit{1.0e9, "ns"} : TimeUnit{1.0e6, "&micro;s"};
}

std::string row(const std::string& name, const std::string& value) {
  return fmt::format("<tr><td>{}</td><td class='text'>{}</td></tr>\n", escape_xml(name), escape_xml(value));
}

std::string list(const std::vector<std::string>& items) {
  std::string html = "<ul>\n";
  for (const auto& item : items) html += "<li>" + escape_xml(item) + "</li>\n";
  return html + "</ul>\n";
}

std::string beacons_section(const Deployment& deployment) {
  const TimeUnit unit = delay_unit(deployment);
  std::string html = fmt::format("<h2>Beacons</h2>\n<table>\n<tr><th>beacon</th><th>x [m]</th><th>y [m]</th><th>z [m]</th><th>&sigma;x [mm]</th>"
                                 "<th>&sigma;y [mm]</th><th>&sigma;z [mm]</th><th>delay [{0}]</th><th>&sigma; [{0}]</th>"
                                 "<th class='text'>status</th></tr>\n", unit.html);
  for (const auto& beacon : deployment.beacons) {
    if (beacon.status == BeaconStatus::kUndetermined) {
      html += fmt::format("<tr><td>{}</td><td colspan='8'></td><td class='text bad'>undetermined; localizers leave it out</td></tr>\n",
                          escape_xml(beacon.name));
      continue;
    }
    const auto& p = beacon.position_m;
    html += fmt::format("<tr><td>{}</td><td>{:.4f}</td><td>{:.4f}</td><td>{:.4f}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td>"
                        "<td>{:.4g}</td><td>{:.2g}</td><td class='text'>{}</td></tr>\n",
                        escape_xml(beacon.name), p.x(), p.y(), p.z(), 1e3 * sigma_m(beacon, 0), 1e3 * sigma_m(beacon, 1),
                        1e3 * sigma_m(beacon, 2), unit.per_s * beacon.delay_s, unit.per_s * beacon.delay_sigma_s, words(beacon.status));
  }
  return html + "</table>\n";
}

std::string adjustment_section(const ReportInput& input) {
  const Deployment& d = input.plan.deployment;
  const CalibrationStatistics& s = d.statistics;
  std::string html = "<h2>Adjustment</h2>\n<table>\n";
  html += row("Datum", d.datum.description);
  html += row("Speed", speed_in_words(d));
  if (d.attenuation) {
    html += row("Time-walk", fmt::format("{:.4g} V at 1 m, absorption {:.4g} Np/m, threshold {:.4g} V, rise time constant {:.4g} s",
                                         d.attenuation->amplitude_1m_v, d.attenuation->absorption_np_per_m, d.attenuation->threshold_v,
                                         d.attenuation->rise_time_s));
  }
  html += row("Arrivals", fmt::format("{} used, {} left out", s.arrivals, s.rejected));
  for (const auto& note : input.left_out) html += row("left out: " + note.reason, std::to_string(note.count));
  html += row("Unknowns", fmt::format("{}, redundancy {:.0f}", s.unknowns, s.redundancy));
  html += row("Variance factor", fmt::format("{:.4g} (1 where the stated noise is right; p = {:.3g})", s.variance_factor, s.chi2_p));
  html += row("Residuals, RMS", fmt::format("{:.4g} s", s.rms_s));
  html += "</table>\n";
  if (!input.weak.empty()) {
    html += "<h2>Weakly determined</h2>\n<ul>\n";
    for (const auto& weak : input.weak) {
      html += fmt::format("<li>{}: up to {:.2g} mm at the robot.{}</li>\n", escape_xml(weak.description), 1e3 * weak.consequence_m,
                          weak.remedy.empty() ? "" : " Settled by: " + escape_xml(weak.remedy) + ".");
    }
    html += "</ul>\n";
  }
  return html;
}

std::string check_section(const Evaluation& e) {
  std::string html = "<h2>Check against the reference</h2>\n<table>\n";
  html += row("Fixes", fmt::format("{}, of which {} have a reference; {} epochs without a fix", e.fixes, e.matched, e.no_fix));
  if (e.matched > 0) {
    html += row("Position error", fmt::format("RMSE {:.2f} mm, 95 % {:.2f} mm, largest {:.2f} mm", 1e3 * e.position_rmse_m, 1e3 * e.position_p95_m,
                                              1e3 * e.max_error_m));
  }
  if (e.heading_rmse_rad) html += row("Heading error", fmt::format("RMSE {:.4g} rad", *e.heading_rmse_rad));
  if (e.nees_mean) html += row("NEES over its degrees of freedom", fmt::format("{:.3g} (1 where the stated sigmas are honest)", *e.nees_mean));
  html += "</table>\n<table>\n<tr><th>gate</th><th>value</th><th>limit</th><th class='text'>verdict</th></tr>\n";
  for (const auto& gate : e.gates) {
    html += fmt::format("<tr><td>{}</td><td>{:.4g}</td><td>{:.4g}</td><td class='text {}'>{}</td></tr>\n", escape_xml(gate.name), gate.value,
                        gate.limit, gate.pass ? "good" : "bad", gate.pass ? "kept" : "not kept");
  }
  return html + "</table>\n";
}

std::string provenance_section(const Deployment& d) {
  std::string html = "<h2>Where this comes from</h2>\n<table>\n";
  html += row("Made", fmt::format("{} by octant {}", d.created, d.program_version));
  html += row("Command", d.program_command);
  for (const auto& input : d.inputs) {
    html += fmt::format("<tr><td>{}</td><td class='text'><code>sha256 {}</code></td></tr>\n", escape_xml(input.path), escape_xml(input.sha256));
  }
  return html + "</table>\n";
}

}  // namespace

std::string speed_in_words(const Deployment& d) {
  std::string text = fmt::format("{:.8g} m/s, sigma {:.2g} m/s", d.speed_mps(d.medium.temperature_degC), d.speed_sigma_mps);
  if (d.medium.model == MediumModel::kConstant) return text;
  return text + fmt::format(", at {:g} degC (model {})", d.medium.temperature_degC, std::string(to_string(d.medium.model)));
}

Verdict verdict(const ReportInput& input) {
  const Deployment& d = input.plan.deployment;
  std::size_t calibrated = 0, undetermined = 0;
  double worst_m = 0.0;
  for (const auto& beacon : d.beacons) {
    undetermined += beacon.status == BeaconStatus::kUndetermined;
    if (beacon.status != BeaconStatus::kCalibrated) continue;
    ++calibrated;
    worst_m = std::max(worst_m, radius95_m(beacon));
  }
  Verdict v{d.statistics.converged, d.statistics.converged ? "" : "The adjustment did not converge. "};
  v.sentence += fmt::format("{} beacons calibrated, the worst within {:.2g} mm in the plane (95 %)", calibrated, 1e3 * worst_m);
  if (d.tolerance.beacon_m) {
    const bool kept = worst_m <= *d.tolerance.beacon_m;
    v.good = v.good && kept;
    v.sentence += fmt::format(", {} the tolerance of {:.4g} mm", kept ? "inside" : "outside", 1e3 * *d.tolerance.beacon_m);
  }
  if (undetermined > 0) {
    v.good = false;
    v.sentence += fmt::format("; {} could not be determined", undetermined);
  }
  if (input.evaluation) {
    const Evaluation& e = *input.evaluation;
    v.good = v.good && e.pass();
    v.sentence += e.matched == 0 ? std::string("; no fix has a reference")
                                 : fmt::format("; fixes are {:.2g} mm RMSE off the reference, {}", 1e3 * e.position_rmse_m,
                                               e.pass() ? "inside their tolerance" : "outside their tolerance");
  }
  v.sentence += ".";
  return v;
}

std::string report_html(const ReportInput& input) {
  const Deployment& d = input.plan.deployment;
  const Verdict v = verdict(input);
  std::string html = "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
                     "<meta http-equiv='Content-Security-Policy' content=\"default-src 'none'; style-src 'unsafe-inline'\">\n"
                     "<meta name='viewport' content='width=device-width, initial-scale=1'>\n";
  html += fmt::format("<title>{} – calibration</title>\n", escape_xml(d.site));
  html += kStyle;
  html += fmt::format("</head>\n<body>\n<h1>{}</h1>\n<p class='soft'>Calibration of {}</p>\n", escape_xml(d.site), escape_xml(d.created));
  html += fmt::format("<p class='verdict{}'>{}</p>\n", v.good ? "" : " bad", escape_xml(v.sentence));
  html += site_plan_svg(input.plan);
  html += beacons_section(d);
  html += adjustment_section(input);
  if (input.evaluation) html += check_section(*input.evaluation);
  if (!input.warnings.empty()) html += "<h2>Warnings</h2>\n" + list(input.warnings);
  html += provenance_section(d);
  return html + "</body>\n</html>\n";
}

}  // namespace octant::survey
